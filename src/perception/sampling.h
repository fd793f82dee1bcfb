#pragma once

#include <algorithm>

#include "geometry/plane.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::perception {

/// How a cloud samples the surfaces in it, measured on the cloud itself. [m]
struct Sampling {
  /// Standard deviation of the points across their surface; 0: not known.
  double noise_m = 0.0;
  /// Root of the area of surface that one point stands for: the mean distance of neighbors.
  double spacing_m = 0.0;
  /// Distance of neighbors in the direction in which they are further apart: of one profile of a
  /// line scanner from the next. At least spacing_m.
  double gap_m = 0.0;
};

struct SamplingOptions {
  /// Places that are looked at; their median counts. More cost a pass over all points each.
  int places = 32;
  /// Round a place: over five profiles of a line scanner, points three times closer along them.
  int neighbors = 64;
  /// Of a neighborhood's squared radius: the nearest neighbors of inner points are in it.
  double inner_share = 0.4;
  std::size_t table_points = 10000;  ///< about so many measure the noise about the table
  int max_rounds = 20;               ///< of growing the band round the table
  /// Ends the growing: a change of the deviation by less than this share.
  double settled = 0.02;
};

/// Medians over neighborhoods evenly spread over a cloud: residuals about their planes (white
/// noise: what is the same over a neighborhood does not show), the area of a point and the distance
/// of the nearest neighbor in the plane. O(places * n).
/// @return zeros if there are not enough points for one neighborhood.
Sampling MeasureSampling(geometry::PointSpan points, const SamplingOptions& options);

/// A table's plane, fitted to all points that its own noise explains.
struct NoisyPlane {
  geometry::Plane plane;
  double noise_m = 0.0;  ///< standard deviation of its points
};
/// Refits a plane that was found as if there were little noise, and measures the noise with the
/// sensor's slow errors, which differ over a table. The band of points round the plane grows from
/// `band_m` until it holds the distribution in it; the deviation is taken under the plane, where no
/// object's points are. The normal keeps its side. O(options.table_points) a round.
NoisyPlane FitNoisy(const geometry::Plane& table, geometry::PointSpan points, double band_m,
                    const SamplingOptions& options);

/// How much of each a length has to cover.
struct Growth {
  double noises = 0.0;    ///< of Sampling::noise_m
  double spacings = 0.0;  ///< of Sampling::spacing_m
  double gaps = 0.0;      ///< of Sampling::gap_m
};

/// A length that stands for noise or point spacing, not for the size of an object or a hand: the
/// published value, or more where the sensor is noisier or coarser than the dissertation's. A value
/// that is assigned stays as it is.
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

/// A number of points that stands for an area of surface: fewer where the sensor is coarser. A
/// value that is assigned stays as it is.
class AdaptiveCount {
 public:
  /// @param min  with fewer points nothing can be said at all
  constexpr AdaptiveCount(int published, double area_m2, int min)
      : count_(published), published_(published), area_m2_(area_m2), min_(min) {}
  AdaptiveCount& operator=(int count) {
    count_ = count;
    given_ = true;
    return *this;
  }
  constexpr operator int() const { return count_; }  // NOLINT: it is a count

  void AdaptTo(const Sampling& sampling) {
    if (given_ || !(sampling.spacing_m > 0.0)) return;
    const double points = area_m2_ / (sampling.spacing_m * sampling.spacing_m);
    count_ = std::clamp(static_cast<int>(std::min(points, 1.0 * published_)), min_, published_);
  }

 private:
  int count_;
  int published_;
  double area_m2_;
  int min_;
  bool given_ = false;
};

}  // namespace rangegrasp::perception
