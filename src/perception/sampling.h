#pragma once

#include <algorithm>

#include "geometry/plane.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::perception {

/// How a cloud samples its surfaces, measured on the cloud itself. [m]
struct Sampling {
  /// Standard deviation of the points across their surface; 0: not known.
  double noise_m = 0.0;
  /// Square root of the surface area per point: the mean distance of neighbors.
  double spacing_m = 0.0;
  /// Distance of neighbors in the direction in which they are further apart, e.g. from one profile
  /// of a line scanner to the next. At least spacing_m.
  double gap_m = 0.0;
};

struct SamplingOptions {
  /// Number of places that are sampled; their median counts. Each costs a pass over all points.
  int places = 32;
  /// Points around a place: five profiles of a line scanner that is three times denser along them.
  int neighbors = 64;
  /// Share of a neighborhood's squared radius: it contains the nearest neighbors of inner points.
  double inner_share = 0.4;
  std::size_t table_points = 10000;  ///< about this many measure the noise of the table
  int max_rounds = 20;               ///< rounds of growing the band around the table
  /// The growing ends if the deviation changes by less than this share.
  double settled = 0.02;
};

/// Medians over neighborhoods evenly spread over a cloud: of residuals about their planes (white
/// noise: an error that is constant over a neighborhood does not show), of the area per point and
/// of the distance to the nearest neighbor in the plane. O(places * n).
/// @return zeros if there are not enough points for one neighborhood.
Sampling MeasureSampling(geometry::PointSpan points, const SamplingOptions& options);

/// A table's plane, fitted to all points that its own noise explains.
struct NoisyPlane {
  geometry::Plane plane;
  double noise_m = 0.0;  ///< standard deviation of its points
};
/// Refits a plane found on the assumption of little noise, and measures the noise including the
/// sensor's slow errors, which vary over a table. The band of points around the plane grows from
/// `band_m` until it contains their distribution. The deviation is measured below the plane, where
/// no object has points. The normal keeps its side. O(options.table_points) per round.
NoisyPlane FitNoisy(const geometry::Plane& table, geometry::PointSpan points, double band_m,
                    const SamplingOptions& options);

/// How much of each quantity a length has to cover.
struct Growth {
  double noises = 0.0;    ///< of Sampling::noise_m
  double spacings = 0.0;  ///< of Sampling::spacing_m
  double gaps = 0.0;      ///< of Sampling::gap_m
};

/// A length that depends on noise or point spacing, not on the size of an object or a hand: the
/// published value, or more if the sensor is noisier or coarser than the dissertation's. An
/// assigned value is not adapted.
class AdaptiveLength {
 public:
  constexpr AdaptiveLength(double published_m, Growth growth)
      : published_m_(published_m), growth_(growth), length_m_(published_m) {}
  AdaptiveLength& operator=(double length_m) {
    length_m_ = length_m;
    given_ = true;
    return *this;
  }
  constexpr operator double() const { return length_m_; }  // NOLINT: it is a length

  void AdaptTo(const Sampling& sampling) {
    if (given_) return;
    length_m_ = std::max({published_m_, growth_.noises * sampling.noise_m,
                          growth_.spacings * sampling.spacing_m, growth_.gaps * sampling.gap_m});
  }

 private:
  double published_m_;
  Growth growth_;
  double length_m_;
  bool given_ = false;
};

}  // namespace rangegrasp::perception
