#include "perception/sampling.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/statistics.h"
#include "perception/internal/planar.h"

namespace rangegrasp::perception {
namespace {

using Eigen::Vector3d;
using geometry::Plane;
using geometry::Points;
using geometry::PointSpan;

/// The median absolute value of a normal distribution, as a share of its standard deviation.
constexpr double kMedianOfNormal = 0.6745;
/// Parameters of a plane: a neighborhood with no more points than that says nothing about noise.
constexpr std::size_t kPlaneFreedoms = 3;

/// A point's nearest neighbors, in the order of the cloud.
struct Neighborhood {
  Points points;
  std::vector<double> squared_distance;  ///< of each from the middle [m^2]
  double squared_radius = 0.0;           ///< to the first point that is left out
};

/// Finds them by one pass over all points per place: a tree costs as much as a hundred places.
class Neighborhoods {
 public:
  Neighborhoods(PointSpan points, std::size_t size) : points_(points), size_(size) {}

  Neighborhood Round(const Vector3d& middle) {
    // The last neighborhood's size is a good guess of this one's.
    while (!Collect(middle)) guess_ *= 4.0;
    std::vector<double> nearest = within_.squared_distance;
    const auto last = nearest.begin() + static_cast<std::ptrdiff_t>(size_);
    std::nth_element(nearest.begin(), last, nearest.end());
    Neighborhood found;
    found.squared_radius = *last;
    for (std::size_t i = 0; i < within_.points.size(); ++i) {
      if (within_.squared_distance[i] >= *last) continue;
      found.points.push_back(within_.points[i]);
      found.squared_distance.push_back(within_.squared_distance[i]);
    }
    guess_ = std::max(kGuess * *last, kLeastGuess);
    return found;
  }

 private:
  static constexpr double kGuess = 2.0;  ///< larger: more to sort; smaller: more second passes
  /// [m^2] So small that it can only grow at first. Not 0: many points may be in one place.
  static constexpr double kLeastGuess = 1e-8;

  /// Collects all points within the guess; returns whether they are enough.
  bool Collect(const Vector3d& middle) {
    within_.points.clear();
    within_.squared_distance.clear();
    for (const Vector3d& p : points_) {
      const double along_x = p.x() - middle.x();
      if (along_x * along_x > guess_) continue;  // sufficient for most points
      const double squared = (p - middle).squaredNorm();
      if (squared > guess_) continue;
      within_.points.push_back(p);
      within_.squared_distance.push_back(squared);
    }
    return within_.points.size() > size_;
  }

  PointSpan points_;
  std::size_t size_;
  double guess_ = kLeastGuess;  ///< squared [m^2]
  Neighborhood within_;
};

/// The median distance in the plane from the inner points to their nearest neighbors.
double NearestInPlane(const Plane& plane, const Neighborhood& round, double inner_share) {
  const Vector3d u = plane.normal.unitOrthogonal();
  const auto flat =
      internal::Flatten({Vector3d::Zero(), u, plane.normal.cross(u), plane.normal}, round.points);
  std::vector<double> nearest;
  for (std::size_t i = 0; i < flat.size(); ++i) {
    if (round.squared_distance[i] > inner_share * round.squared_radius) continue;
    double squared = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < flat.size(); ++j) {
      if (j != i) squared = std::min(squared, (flat[i] - flat[j]).squaredNorm());
    }
    nearest.push_back(std::sqrt(squared));
  }
  return nearest.empty() ? 0.0 : base::MedianOf(std::move(nearest));
}

double ResidualDeviation(const Plane& plane, const Points& points) {
  double sum = 0.0;
  for (const auto& p : points) sum += plane.Distance(p) * plane.Distance(p);
  return std::sqrt(sum / static_cast<double>(points.size() - kPlaneFreedoms));
}

}  // namespace

Sampling MeasureSampling(PointSpan points, const SamplingOptions& options) {
  const auto size = static_cast<std::size_t>(options.neighbors);
  if (points.size() <= size) return {};
  Neighborhoods neighborhoods(points, size);
  std::vector<double> noises;
  std::vector<double> areas;
  std::vector<double> nearest;
  const std::size_t step =
      std::max<std::size_t>(1, points.size() / static_cast<std::size_t>(options.places));
  for (std::size_t middle = step / 2; middle < points.size(); middle += step) {
    const Neighborhood round = neighborhoods.Round(points[middle]);
    const auto plane = geometry::FitPlane(round.points);
    if (!plane || round.points.size() <= kPlaneFreedoms) continue;
    noises.push_back(ResidualDeviation(*plane, round.points));
    areas.push_back(std::numbers::pi * round.squared_radius /
                    static_cast<double>(round.points.size()));
    const double one = NearestInPlane(*plane, round, options.inner_share);
    if (one > 0.0) nearest.push_back(one);
  }
  if (noises.empty() || nearest.empty()) return {};
  const double area_m2 = base::MedianOf(std::move(areas));
  const double spacing_m = std::sqrt(area_m2);
  return {.noise_m = base::MedianOf(std::move(noises)),
          .spacing_m = spacing_m,
          .gap_m = std::max(spacing_m, area_m2 / base::MedianOf(std::move(nearest)))};
}

NoisyPlane FitNoisy(const Plane& table, PointSpan points, double band_m,
                    const SamplingOptions& options) {
  // A band of five deviations holds a normal distribution, and its median is not cut.
  constexpr double kBand = 5.0;
  NoisyPlane fit{table, 0.0};
  const std::size_t step = std::max<std::size_t>(1, points.size() / options.table_points);
  for (int round = 0; round < options.max_rounds; ++round) {
    Points near;
    for (std::size_t i = 0; i < points.size(); i += step) {
      if (std::abs(fit.plane.Distance(points[i])) <= band_m) near.push_back(points[i]);
    }
    const auto plane = geometry::FitPlane(near);
    if (!plane) break;
    fit.plane = geometry::TurnedLike(table, *plane);
    std::vector<double> depths;
    for (const auto& p : near) {
      const double depth_m = -fit.plane.Distance(p);
      if (depth_m >= 0.0) depths.push_back(depth_m);
    }
    // Without noise, all points may be rounded to one side.
    if (depths.empty()) return {fit.plane, 0.0};
    const double before_m = fit.noise_m;
    fit.noise_m = base::MedianOf(std::move(depths)) / kMedianOfNormal;
    band_m = kBand * fit.noise_m;
    if (std::abs(fit.noise_m - before_m) <= options.settled * fit.noise_m) break;
  }
  return fit;
}

}  // namespace rangegrasp::perception
