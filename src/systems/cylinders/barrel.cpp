#include "cylinders/barrel.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/quantile.h"

namespace rangegrasp::cylinders {
namespace {

using geometry::Indices;
using geometry::PointCloud;

/// A point in a cylinder's own coordinates.
struct About {
  double along_m = 0.0;   ///< from the axis' point
  double radial_m = 0.0;  ///< distance from the axis
  Eigen::Vector3d radial;

  /// Unit, from the axis to the point.
  Eigen::Vector3d Out() const { return radial / std::max(radial_m, 1e-12); }
};

inline About PlaceOf(const Line& axis, const Eigen::Vector3d& p) {
  const Eigen::Vector3d offset = p - axis.point;
  About about;
  about.along_m = offset.dot(axis.direction);
  about.radial = offset - about.along_m * axis.direction;
  about.radial_m = about.radial.norm();
  return about;
}

Indices Gather(const PointCloud& cloud, std::span<const std::uint32_t> near, const Line& axis,
               double radius_m, double distance_m, double min_cosine) {
  Indices gathered;
  for (const auto i : near) {
    const About about = PlaceOf(axis, cloud.points[i]);
    if (std::abs(about.radial_m - radius_m) > distance_m) continue;
    if (cloud.normals[i].dot(about.Out()) >= min_cosine) gathered.push_back(i);
  }
  return gathered;
}

/// The normal equations of one Gauss-Newton step: two shifts, two tilts, the radius. Of the
/// symmetric matrix the lower half alone, which is what its decomposition reads.
struct Step {
  Eigen::Matrix<double, 5, 5> information = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> gradient = Eigen::Matrix<double, 5, 1>::Zero();
  double weighted_squares = 0.0;
  double weights = 0.0;
};

struct Frame {
  Eigen::Vector3d u, v;
};

Frame FrameOf(const Line& axis) {
  const Eigen::Vector3d u = axis.direction.unitOrthogonal();
  return {u, axis.direction.cross(u)};
}

/// Lengths along the axis are measured in radii, so that all parameters weigh alike.
Step StepOf(const PointCloud& cloud, const Indices& points, const Line& axis, const Frame& frame,
            double radius_m, double distance_m) {
  // In variables of the function's own, which stay in registers.
  std::array<double, 15> information{};
  std::array<double, 5> gradient{};
  double weighted_squares = 0.0;
  double weights = 0.0;
  for (const auto i : points) {
    const About about = PlaceOf(axis, cloud.points[i]);
    const double residual = about.radial_m - radius_m;
    const double share = residual / distance_m;
    if (std::abs(share) >= 1.0) continue;
    const double weight = (1.0 - share * share) * (1.0 - share * share);
    const Eigen::Vector3d out = about.Out();
    const double on_u = out.dot(frame.u);
    const double on_v = out.dot(frame.v);
    const double along = about.along_m / radius_m;
    const std::array<double, 5> row = {-on_u, -on_v, -along * on_u, -along * on_v, -1.0};
    std::size_t at = 0;
    for (std::size_t k = 0; k < 5; ++k) {
      const double weighted = weight * row[k];
      for (std::size_t l = 0; l <= k; ++l) information[at++] += weighted * row[l];
      gradient[k] += weight * residual * row[k];
    }
    weighted_squares += weight * residual * residual;
    weights += weight;
  }
  Step step{.weighted_squares = weighted_squares, .weights = weights};
  std::size_t at = 0;
  for (int k = 0; k < 5; ++k) {
    for (int l = 0; l <= k; ++l) step.information(k, l) = information[at++];
    step.gradient[k] = gradient[static_cast<std::size_t>(k)];
  }
  return step;
}

void Move(const Frame& frame, const Eigen::Vector4d& change, double radius_m, Line& axis) {
  axis.point += change[0] * frame.u + change[1] * frame.v;
  axis.direction =
      (axis.direction + (change[2] * frame.u + change[3] * frame.v) / radius_m).normalized();
}

/// The axis' point moves to the middle of the points: tilts then hardly trade against shifts.
void Center(const PointCloud& cloud, const Indices& points, Line& axis) {
  double sum = 0.0;
  for (const auto i : points) sum += (cloud.points[i] - axis.point).dot(axis.direction);
  axis.point += sum / static_cast<double>(points.size()) * axis.direction;
}

/// How far round the points go in one run of bins of 10 deg; a bin that is empty alone is no gap.
double ArcOf(const PointCloud& cloud, const Indices& points, const Line& axis) {
  constexpr int kBins = 36;
  constexpr int kTurns = 2;  // a run may go over the first bin
  std::array<bool, kBins> filled{};
  const Frame frame = FrameOf(axis);
  for (const auto i : points) {
    const Eigen::Vector3d offset = cloud.points[i] - axis.point;
    const double angle = std::atan2(offset.dot(frame.v), offset.dot(frame.u));
    const int bin = static_cast<int>((angle + base::kPi) / (2.0 * base::kPi) * kBins);
    filled[static_cast<std::size_t>(std::clamp(bin, 0, kBins - 1))] = true;
  }
  int longest = 0;
  int run = 0;
  int empty = 0;
  for (int k = 0; k < kTurns * kBins; ++k) {
    empty = filled[static_cast<std::size_t>(k % kBins)] ? 0 : empty + 1;
    run = empty > 1 ? 0 : run + 1;
    longest = std::max(longest, run - empty);
  }
  return 2.0 * base::kPi / kBins * static_cast<double>(std::min(longest, kBins));
}

double MedianNormalAngle(const PointCloud& cloud, const Indices& points, const Line& axis) {
  std::vector<double> cosines;
  cosines.reserve(points.size());
  for (const auto i : points) {
    cosines.push_back(cloud.normals[i].dot(PlaceOf(axis, cloud.points[i]).Out()));
  }
  return std::acos(std::clamp(base::MedianOf(std::move(cosines)), -1.0, 1.0));
}

/// One step with the radius as it is; false if the points say nothing of the axis.
bool Improve(const PointCloud& cloud, const Indices& points, double radius_m, double distance_m,
             Line& axis) {
  Center(cloud, points, axis);
  const Frame frame = FrameOf(axis);
  const Step step = StepOf(cloud, points, axis, frame, radius_m, distance_m);
  const Eigen::Matrix4d information = step.information.topLeftCorner<4, 4>();
  const Eigen::LDLT<Eigen::Matrix4d> solver(information);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-9 * step.weights)) {
    return false;
  }
  Move(frame, -solver.solve(step.gradient.head<4>()), radius_m, axis);
  return true;
}

/// The radius that the points say beside their axis, its deviation, and their residuals.
void MeasureRadius(const PointCloud& cloud, const Line& fixed_axis, double radius_m,
                   double distance_m, RefinedAxis& refined) {
  Line axis = fixed_axis;
  double radius = radius_m;
  for (int round = 0; round < 3; ++round) {
    const Frame frame = FrameOf(axis);
    const Step step = StepOf(cloud, refined.points, axis, frame, radius, distance_m);
    if (round == 0) refined.rms_m = std::sqrt(step.weighted_squares / std::max(step.weights, 1.0));
    const Eigen::LDLT<Eigen::Matrix<double, 5, 5>> solver(step.information);
    const Eigen::Matrix<double, 5, 1> change = -solver.solve(step.gradient);
    if (solver.info() != Eigen::Success || !change.allFinite()) break;
    Move(frame, change.head<4>(), radius, axis);
    radius += change[4];
    const Eigen::Matrix<double, 5, 1> unit = Eigen::Matrix<double, 5, 1>::Unit(4);
    const double variance = step.weighted_squares / std::max(step.weights - 5.0, 1.0);
    refined.radius_sd_m = std::sqrt(std::max(0.0, variance * unit.dot(solver.solve(unit))));
    if (!(radius > 0.5 * radius_m && radius < 2.0 * radius_m)) break;
  }
  refined.radius_m = radius;
}

/// The median place along the axis of the points whose normals face along `sign` axis and that are
/// within the radius and a few millimetres of the end that the barrel shows.
std::optional<double> FaceAt(const PointCloud& cloud, std::span<const std::uint32_t> near,
                             const Line& axis, double radius_m, double sign, double end_m,
                             const BarrelOptions& options) {
  const double min_cosine = std::cos(options.max_face_angle_rad);
  const double reach_m = 2.0 * options.piece_m + options.distance_m;
  std::vector<double> places;
  for (const auto i : near) {
    if (sign * cloud.normals[i].dot(axis.direction) < min_cosine) continue;
    const About about = PlaceOf(axis, cloud.points[i]);
    if (about.radial_m > radius_m - options.distance_m) continue;
    if (std::abs(about.along_m - end_m) <= reach_m) places.push_back(about.along_m);
  }
  if (places.size() < static_cast<std::size_t>(options.min_face_points)) return std::nullopt;
  return base::MedianOf(std::move(places));
}

/// Pieces of the barrel along its axis, with their counts of points.
struct Pieces {
  double low_m = 0.0;
  double length_m = 0.0;
  std::vector<std::size_t> counts;
};

Pieces Cut(const std::vector<double>& along, double length_m) {
  const auto [low, high] = std::ranges::minmax(along);
  Pieces pieces{low, length_m, {}};
  pieces.counts.resize(static_cast<std::size_t>((high - low) / length_m) + 1, 0);
  for (const double a : along) ++pieces.counts[static_cast<std::size_t>((a - low) / length_m)];
  return pieces;
}

/// Pieces from first to last that all have enough points.
struct Run {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t count = 0;  ///< of points
};

std::vector<Run> RunsOf(const Pieces& pieces, double min_share) {
  std::vector<std::size_t> occupied;
  for (const auto count : pieces.counts) {
    if (count > 0) occupied.push_back(count);
  }
  const double enough = min_share * static_cast<double>(base::UpperMedianOf(occupied));
  std::vector<Run> runs;
  for (std::size_t i = 0; i < pieces.counts.size(); ++i) {
    if (static_cast<double>(pieces.counts[i]) < std::max(1.0, enough)) continue;
    if (runs.empty() || runs.back().last + 1 < i) runs.push_back({i, i, 0});
    runs.back().last = i;
    runs.back().count += pieces.counts[i];
  }
  return runs;
}

/// The fullest run with those beside it, fuller ones first, that make it no longer than so many
/// pieces.
Run Joined(std::vector<Run> runs, std::size_t max_pieces) {
  std::stable_sort(runs.begin(), runs.end(),
                   [](const Run& a, const Run& b) { return a.count > b.count; });
  Run joined = runs.front();
  for (const Run& run : runs) {
    const std::size_t first = std::min(joined.first, run.first);
    const std::size_t last = std::max(joined.last, run.last);
    if (last - first + 1 > max_pieces) continue;
    joined = {first, last, joined.count + run.count};
  }
  return joined;
}

}  // namespace

Indices BarrelPoints(geometry::PointSpan points, const Line& axis, double radius_m, double low_m,
                     double high_m, double distance_m) {
  Indices barrel;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d offset = points[i] - axis.point;
    const double along_m = offset.dot(axis.direction);
    if (along_m < low_m || along_m > high_m) continue;
    const double radial_m = (offset - along_m * axis.direction).norm();
    if (std::abs(radial_m - radius_m) <= distance_m) barrel.push_back(i);
  }
  return barrel;
}

std::optional<RefinedAxis> RefineAxis(const PointCloud& cloud, std::span<const std::uint32_t> near,
                                      const Line& start, double radius_m,
                                      const BarrelOptions& options) {
  const double min_cosine = std::cos(options.max_normal_angle_rad);
  const auto enough = static_cast<std::size_t>(options.min_points);
  RefinedAxis refined{.axis = start, .radius_m = radius_m, .points = {}};
  double distance_m = options.first_distance_m;
  for (int round = 0; round < options.rounds; ++round) {
    refined.points = Gather(cloud, near, refined.axis, radius_m, distance_m, min_cosine);
    if (refined.points.size() < enough) return std::nullopt;
    if (!Improve(cloud, refined.points, radius_m, distance_m, refined.axis)) return std::nullopt;
    distance_m = std::max<double>(options.distance_m, 0.6 * distance_m);
  }
  refined.points = Gather(cloud, near, refined.axis, radius_m, distance_m, min_cosine);
  if (refined.points.size() < enough) return std::nullopt;
  MeasureRadius(cloud, refined.axis, radius_m, options.first_distance_m, refined);
  refined.arc_rad = ArcOf(cloud, refined.points, refined.axis);
  refined.normal_angle_rad = MedianNormalAngle(cloud, refined.points, refined.axis);
  return refined;
}

std::optional<BarrelEnds> FindEnds(const PointCloud& cloud, std::span<const std::uint32_t> near,
                                   const RefinedAxis& refined, double radius_m, double max_length_m,
                                   const BarrelOptions& options) {
  if (refined.points.empty()) return std::nullopt;
  std::vector<double> along;
  along.reserve(refined.points.size());
  for (const auto i : refined.points) {
    along.push_back((cloud.points[i] - refined.axis.point).dot(refined.axis.direction));
  }
  const Pieces pieces = Cut(along, options.piece_m);
  const std::vector<Run> runs = RunsOf(pieces, options.min_piece_share);
  if (runs.empty()) return std::nullopt;
  const Run run = Joined(runs, static_cast<std::size_t>(max_length_m / pieces.length_m));
  BarrelEnds ends;
  const double from_m = pieces.low_m + static_cast<double>(run.first) * pieces.length_m;
  const double to_m = pieces.low_m + static_cast<double>(run.last + 1) * pieces.length_m;
  ends.low_m = to_m;
  ends.high_m = from_m;
  for (const double a : along) {
    if (a < from_m || a > to_m) continue;
    ends.low_m = std::min(ends.low_m, a);
    ends.high_m = std::max(ends.high_m, a);
  }
  if (const auto face = FaceAt(cloud, near, refined.axis, radius_m, 1.0, ends.high_m, options)) {
    ends.high_m = *face;
    ends.high_face = true;
  }
  if (const auto face = FaceAt(cloud, near, refined.axis, radius_m, -1.0, ends.low_m, options)) {
    ends.low_m = *face;
    ends.low_face = true;
  }
  return ends;
}

}  // namespace rangegrasp::cylinders
