#include "cylinders/barrel.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>

#include "base/statistics.h"

namespace rangegrasp::cylinders {
namespace {

using geometry::Indices;
using geometry::PointCloud;
using geometry::Points;

Indices Gather(const PointCloud& cloud, std::span<const std::uint32_t> near, const Line& axis,
               double radius_m, double distance_m, double min_cosine) {
  Indices gathered;
  for (const auto i : near) {
    const About about = axis.PlaceOf(cloud.points[i]);
    if (std::abs(about.radial_m - radius_m) > distance_m) continue;
    if (cloud.normals[i].dot(about.Out()) >= min_cosine) gathered.push_back(i);
  }
  return gathered;
}

/// Normal equations of one Gauss-Newton step for two shifts, two tilts and the radius.
struct Step {
  Eigen::Matrix<double, 5, 5> information = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> gradient = Eigen::Matrix<double, 5, 1>::Zero();
  double weighted_squares = 0.0;
  double weights = 0.0;
};

/// Lengths along the axis are in units of the radius, so that all parameters have a similar scale.
Step StepOf(const PointCloud& cloud, const Indices& points, const Line& axis, const Across& across,
            double radius_m, double distance_m) {
  Step step;
  for (const auto i : points) {
    const About about = axis.PlaceOf(cloud.points[i]);
    const double residual = about.radial_m - radius_m;
    const double share = residual / distance_m;
    if (std::abs(share) >= 1.0) continue;
    const double weight = (1.0 - share * share) * (1.0 - share * share);
    const Eigen::Vector3d out = about.Out();
    const double on_u = out.dot(across.u);
    const double on_v = out.dot(across.v);
    const double along = about.along_m / radius_m;
    const Eigen::Matrix<double, 5, 1> row{-on_u, -on_v, -along * on_u, -along * on_v, -1.0};
    step.information.noalias() += (weight * row) * row.transpose();
    step.gradient += weight * residual * row;
    step.weighted_squares += weight * residual * residual;
    step.weights += weight;
  }
  return step;
}

void Move(const Across& across, const Eigen::Vector4d& change, double radius_m, Line& axis) {
  axis.point += change[0] * across.u + change[1] * across.v;
  axis.direction =
      (axis.direction + (change[2] * across.u + change[3] * across.v) / radius_m).normalized();
}

/// Moves the axis' point to the mean of the points, which nearly decouples tilts from shifts.
void Center(const PointCloud& cloud, const Indices& points, Line& axis) {
  double sum = 0.0;
  for (const auto i : points) sum += (cloud.points[i] - axis.point).dot(axis.direction);
  axis.point += sum / static_cast<double>(points.size()) * axis.direction;
}

/// Longest run of filled 10 deg bins around the axis [rad]; a single empty bin is not a gap.
double ArcOf(const PointCloud& cloud, const Indices& points, const Line& axis) {
  constexpr std::size_t kBins = 36;
  constexpr std::size_t kTurns = 2;  // a run may extend over the first bin
  std::vector<bool> filled(kBins, false);
  const Across across(axis.direction);
  for (const auto i : points) {
    const Eigen::Vector3d offset = cloud.points[i] - axis.point;
    const double angle = std::atan2(offset.dot(across.v), offset.dot(across.u));
    const auto bin = static_cast<std::size_t>((angle + base::kPi) / (2.0 * base::kPi) * kBins);
    filled[std::min(bin, kBins - 1)] = true;
  }
  int longest = 0, run = 0, empty = 0;
  for (std::size_t k = 0; k < kTurns * kBins; ++k) {
    empty = filled[k % kBins] ? 0 : empty + 1;
    run = empty > 1 ? 0 : run + 1;
    longest = std::max(longest, run - empty);
  }
  return 2.0 * base::kPi / kBins * static_cast<double>(std::min<int>(longest, kBins));
}

double MedianNormalAngle(const PointCloud& cloud, const Indices& points, const Line& axis) {
  std::vector<double> cosines;
  for (const auto i : points) {
    cosines.push_back(cloud.normals[i].dot(axis.PlaceOf(cloud.points[i]).Out()));
  }
  return std::acos(std::clamp(base::MedianOf(std::move(cosines)), -1.0, 1.0));
}

/// One step with fixed radius; false if the points do not determine the axis.
bool Improve(const PointCloud& cloud, const Indices& points, double radius_m, double distance_m,
             Line& axis) {
  Center(cloud, points, axis);
  const Across across(axis.direction);
  const Step step = StepOf(cloud, points, axis, across, radius_m, distance_m);
  const Eigen::Matrix4d information = step.information.topLeftCorner<4, 4>();
  const Eigen::LDLT<Eigen::Matrix4d> solver(information);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-9 * step.weights)) {
    return false;
  }
  Move(across, -solver.solve(step.gradient.head<4>()), radius_m, axis);
  return true;
}

/// Fits the radius together with the axis; computes its standard deviation.
void MeasureRadius(const PointCloud& cloud, const Line& fixed_axis, double radius_m,
                   double distance_m, RefinedAxis& refined) {
  Line axis = fixed_axis;
  double radius = radius_m;
  for (int round = 0; round < 3; ++round) {
    const Across across(axis.direction);
    const Step step = StepOf(cloud, refined.points, axis, across, radius, distance_m);
    const Eigen::LDLT<Eigen::Matrix<double, 5, 5>> solver(step.information);
    const Eigen::Matrix<double, 5, 1> change = -solver.solve(step.gradient);
    if (solver.info() != Eigen::Success || !change.allFinite()) break;
    Move(across, change.head<4>(), radius, axis);
    radius += change[4];
    const Eigen::Matrix<double, 5, 1> unit = Eigen::Matrix<double, 5, 1>::Unit(4);
    const double variance = step.weighted_squares / std::max(step.weights - 5.0, 1.0);
    refined.radius_sd_m = std::sqrt(std::max(0.0, variance * unit.dot(solver.solve(unit))));
    if (!(radius > 0.5 * radius_m && radius < 2.0 * radius_m)) break;
  }
  refined.radius_m = radius;
}

/// Median position along the axis of the points near an end of the barrel with normals along it.
std::optional<double> FaceAt(const PointCloud& cloud, std::span<const std::uint32_t> near,
                             const Line& axis, double radius_m, double sign, double end_m,
                             const BarrelOptions& options) {
  const double min_cosine = std::cos(options.max_face_angle_rad);
  const double reach_m = 2.0 * options.piece_m + options.distance_m;
  std::vector<double> places;
  for (const auto i : near) {
    if (sign * cloud.normals[i].dot(axis.direction) < min_cosine) continue;
    const About about = axis.PlaceOf(cloud.points[i]);
    if (about.radial_m > radius_m - options.distance_m) continue;
    if (std::abs(about.along_m - end_m) <= reach_m) places.push_back(about.along_m);
  }
  if (places.size() < static_cast<std::size_t>(options.min_face_points)) return std::nullopt;
  return base::MedianOf(std::move(places));
}

/// Consecutive pieces, from first to last, that all have enough points.
struct Run {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t count = 0;  ///< number of points
};

/// @param counts  numbers of points in the pieces of a barrel along its axis
std::vector<Run> RunsOf(const std::vector<std::size_t>& counts, double min_share) {
  std::vector<std::size_t> occupied = counts;
  std::erase(occupied, 0u);
  const double enough = min_share * static_cast<double>(base::UpperMedianOf(occupied));
  std::vector<Run> runs;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (static_cast<double>(counts[i]) < std::max(1.0, enough)) continue;
    if (runs.empty() || runs.back().last + 1 < i) runs.push_back({i, i, 0});
    runs.back().last = i;
    runs.back().count += counts[i];
  }
  return runs;
}

/// The fullest run joined with others, fuller ones first, up to `max_pieces` in total.
Run Joined(std::vector<Run> runs, std::size_t max_pieces) {
  std::ranges::stable_sort(runs, std::greater{}, &Run::count);
  Run joined = runs.front();
  for (const Run& run : runs) {
    const std::size_t first = std::min(joined.first, run.first);
    const std::size_t last = std::max(joined.last, run.last);
    if (last - first + 1 > max_pieces) continue;
    joined = {first, last, joined.count + run.count};
  }
  return joined;
}

/// Axis points with the normals that they were computed from.
PointCloud VotesOf(const PointCloud& cloud, double radius_m, int max_points) {
  const std::size_t step =
      std::max<std::size_t>(1, cloud.size() / static_cast<std::size_t>(max_points));
  PointCloud votes;
  for (std::size_t i = step / 2; i < cloud.size(); i += step) {
    votes.points.push_back(AxisPoint(cloud.points[i], cloud.normals[i], radius_m));
    votes.normals.push_back(cloud.normals[i]);
  }
  return votes;
}

/// A place in the plane near which many votes are, at their mean height.
struct Peak {
  Eigen::Vector3d place;
  std::size_t count = 0;
};

std::vector<Line> Standing(const PointCloud& votes, const Eigen::Vector3d& up, double scatter_m,
                           double radius_m, const BarrelSearchOptions& options) {
  const auto& [u, v] = Across(up);
  const double max_sine = std::sin(options.max_off_square_rad);
  // Grid cells in the table's plane. Coordinates: two in the plane, and one along its normal [m].
  std::map<std::pair<std::int64_t, std::int64_t>, Points> cells;
  for (std::size_t i = 0; i < votes.points.size(); ++i) {
    if (std::abs(votes.normals[i].dot(up)) > max_sine) continue;
    const Eigen::Vector3d& p = votes.points[i];
    const Eigen::Vector3d place(p.dot(u), p.dot(v), p.dot(up));
    cells[{static_cast<std::int64_t>(std::floor(place.x() / scatter_m)),
           static_cast<std::int64_t>(std::floor(place.y() / scatter_m))}]
        .push_back(place);
  }
  std::vector<Peak> peaks;
  for (const auto& [cell, own] : cells) {
    // Sum over each cell and its eight neighbors.
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::size_t count = 0;
    for (std::int64_t x = cell.first - 1; x <= cell.first + 1; ++x) {
      for (auto at = cells.lower_bound({x, cell.second - 1});
           at != cells.end() && at->first <= std::pair(x, cell.second + 1); ++at) {
        for (const Eigen::Vector3d& place : at->second) sum += place;
        count += at->second.size();
      }
    }
    if (count < static_cast<std::size_t>(options.min_support)) continue;
    peaks.push_back({sum / static_cast<double>(count), count});
  }
  std::ranges::stable_sort(peaks, std::greater{}, &Peak::count);
  Points apart;
  std::vector<Line> lines;
  for (const auto& [place, count] : peaks) {
    if (apart.size() == static_cast<std::size_t>(options.max_standing)) break;
    const bool known = std::ranges::any_of(apart, [&](const Eigen::Vector3d& other) {
      return (other - place).head<2>().norm() < 0.5 * radius_m;
    });
    if (known) continue;
    apart.push_back(place);
    lines.push_back({place.x() * u + place.y() * v + place.z() * up, up});
  }
  return lines;
}

/// Tests which votes lie near a line, at most a cylinder's height along it.
struct Support {
  const PointCloud& votes;
  double scatter_m;
  double height_m;
  double max_sine;

  bool Has(std::size_t i, const Line& line) const {
    const Eigen::Vector3d offset = votes.points[i] - line.point;
    const double along = offset.dot(line.direction);
    return std::abs(along) <= height_m &&
           (offset - along * line.direction).squaredNorm() <= scatter_m * scatter_m &&
           std::abs(votes.normals[i].dot(line.direction)) <= max_sine;
  }
};

/// The horizontal axis that a single vote determines: it is perpendicular to its normal.
std::optional<Line> LyingThrough(const PointCloud& votes, std::size_t i, const Eigen::Vector3d& up,
                                 double min_lean) {
  const Eigen::Vector3d across = up.cross(votes.normals[i]);
  const double sine = across.norm();
  if (sine < min_lean) return std::nullopt;
  return Line{votes.points[i], across / sine};
}

/// Fits the line to those of the votes that support it; returns these votes.
std::vector<std::size_t> FitToSupport(const Support& support, std::vector<std::size_t> supporters,
                                      Line& line) {
  std::erase_if(supporters, [&](std::size_t i) { return !support.Has(i, line); });
  Points places;
  for (const std::size_t i : supporters) places.push_back(support.votes.points[i]);
  if (const auto fit = FitTrimmedLine(places)) line = *fit;
  return supporters;
}

/// The best supported of the lines from `draw`; nullopt if its support is below min_support.
template <typename Draw>
std::optional<Line> BestDrawn(const Support& support, const std::vector<std::size_t>& of, int draws,
                              int min_support, Draw draw) {
  std::optional<Line> best;
  std::size_t most = 0;
  for (int k = 0; k < draws; ++k) {
    const std::optional<Line> line = draw();
    if (!line) continue;
    const std::size_t count =
        base::CountToBeat(of, most, [&](std::size_t i) { return support.Has(i, *line); });
    if (count <= most) continue;
    most = count;
    best = line;
  }
  return most < static_cast<std::size_t>(min_support) ? std::nullopt : best;
}

std::vector<Line> Lying(const PointCloud& votes, const Eigen::Vector3d& up, double scatter_m,
                        double height_m, const BarrelSearchOptions& options, base::Rng& rng) {
  const double max_sine = std::sin(options.max_off_square_rad);
  const double max_upright = std::cos(options.max_off_square_rad);
  const double min_lean = std::sin(options.min_lean_rad);
  // Standing objects have only horizontal normals; half of a lying one's visible normals lean.
  std::vector<std::size_t> left;
  std::vector<std::size_t> leaning;
  for (std::size_t i = 0; i < votes.points.size(); ++i) {
    const double rise = votes.normals[i].dot(up);
    if (rise < -max_sine) continue;
    left.push_back(i);
    if (rise > max_sine && rise < max_upright) leaning.push_back(i);
  }
  const Support support{votes, scatter_m, height_m, max_sine};
  std::vector<Line> lines;
  while (lines.size() < static_cast<std::size_t>(options.max_lying) && !leaning.empty()) {
    auto line = BestDrawn(support, leaning, options.draws, options.min_support, [&] {
      return LyingThrough(votes, leaning[rng.Index(leaning.size())], up, min_lean);
    });
    if (!line) break;
    // Refines the line with its leaning supporters, then with all votes near it.
    FitToSupport(support, leaning, *line);
    FitToSupport(support, left, *line);
    lines.push_back(*line);
    // Twice the scatter, or the rest of the same barrel would be found again.
    const Support wider{votes, 2.0 * scatter_m, 2.0 * height_m, 1.0};
    if (std::erase_if(leaning, [&](std::size_t i) { return wider.Has(i, *line); }) == 0) break;
  }
  return lines;
}

/// The line through two votes' axis points, if it is oblique and perpendicular to both normals.
std::optional<Line> LeaningThrough(const PointCloud& votes, std::size_t i, std::size_t k,
                                   const Eigen::Vector3d& up, double min_length_m,
                                   double max_length_m, const BarrelSearchOptions& options) {
  const Eigen::Vector3d way = votes.points[k] - votes.points[i];
  const double length_m = way.norm();
  if (length_m < min_length_m || length_m > max_length_m) return std::nullopt;
  const Eigen::Vector3d direction = way / length_m;
  const double max_sine = std::sin(options.max_off_square_rad);
  if (std::abs(direction.dot(votes.normals[i])) > max_sine) return std::nullopt;
  if (std::abs(direction.dot(votes.normals[k])) > max_sine) return std::nullopt;
  const double rise = std::abs(direction.dot(up));
  if (rise < std::sin(options.min_oblique_rad) || rise > std::cos(options.min_oblique_rad)) {
    return std::nullopt;
  }
  return Line{votes.points[i], direction};
}

std::vector<Line> Leaning(const PointCloud& votes, const Eigen::Vector3d& up, double scatter_m,
                          double radius_m, double height_m, const BarrelSearchOptions& options,
                          base::Rng& rng) {
  const Support support{votes, scatter_m, height_m, std::sin(options.max_off_square_rad)};
  std::vector<std::size_t> left(votes.points.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  std::vector<Line> lines;
  while (lines.size() < static_cast<std::size_t>(options.max_leaning) && left.size() > 1) {
    auto line = BestDrawn(support, left, options.pair_draws, options.min_support, [&] {
      const std::size_t i = left[rng.Index(left.size())];
      const std::size_t k = left[rng.Index(left.size())];
      return LeaningThrough(votes, i, k, up, radius_m, height_m, options);
    });
    if (!line) break;
    const auto taken = FitToSupport(support, left, *line);
    lines.push_back(*line);
    std::erase_if(left, [&](std::size_t i) { return std::ranges::binary_search(taken, i); });
  }
  return lines;
}

}  // namespace

Indices BarrelPoints(geometry::PointSpan points, const Line& axis, double radius_m, double low_m,
                     double high_m, double distance_m) {
  return geometry::PositionsWhere(points, [&](const Eigen::Vector3d& p) {
    const About about = axis.PlaceOf(p);
    return about.along_m >= low_m && about.along_m <= high_m &&
           std::abs(about.radial_m - radius_m) <= distance_m;
  });
}

std::optional<RefinedAxis> RefineAxis(const PointCloud& cloud, std::span<const std::uint32_t> near,
                                      const Line& start, double radius_m,
                                      const BarrelOptions& options) {
  const double min_cosine = std::cos(options.max_normal_angle_rad);
  const auto enough = static_cast<std::size_t>(options.min_points);
  RefinedAxis refined{.axis = start, .radius_m = radius_m, .points = {}};
  double distance_m = options.first_distance_m;
  for (int round = 0;; ++round) {
    refined.points = Gather(cloud, near, refined.axis, radius_m, distance_m, min_cosine);
    if (refined.points.size() < enough) return std::nullopt;
    if (round == options.rounds) break;
    if (!Improve(cloud, refined.points, radius_m, distance_m, refined.axis)) return std::nullopt;
    distance_m = std::max<double>(options.distance_m, 0.6 * distance_m);
  }
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
  for (const auto i : refined.points) {
    along.push_back((cloud.points[i] - refined.axis.point).dot(refined.axis.direction));
  }
  const auto [low_m, high_m] = std::ranges::minmax(along);
  const double piece_m = options.piece_m;
  std::vector<std::size_t> counts(static_cast<std::size_t>((high_m - low_m) / piece_m) + 1, 0);
  for (const double a : along) ++counts[static_cast<std::size_t>((a - low_m) / piece_m)];
  const std::vector<Run> runs = RunsOf(counts, options.min_piece_share);
  if (runs.empty()) return std::nullopt;
  const Run run = Joined(runs, static_cast<std::size_t>(max_length_m / piece_m));
  const double from_m = low_m + static_cast<double>(run.first) * piece_m;
  const double to_m = low_m + static_cast<double>(run.last + 1) * piece_m;
  BarrelEnds ends{to_m, from_m};
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

std::vector<Line> FindBarrels(const PointCloud& cloud, const Eigen::Vector3d& up, double radius_m,
                              double height_m, const BarrelSearchOptions& options, base::Rng& rng) {
  const double scatter_m =
      std::max<double>(options.min_scatter_m, options.scatter_of_radius * radius_m);
  const PointCloud votes = VotesOf(cloud, radius_m, options.points);
  std::vector<Line> lines = Standing(votes, up, scatter_m, radius_m, options);
  std::ranges::move(Lying(votes, up, scatter_m, height_m, options, rng), std::back_inserter(lines));
  const PointCloud fewer = VotesOf(cloud, radius_m, options.pair_points);
  std::ranges::move(Leaning(fewer, up, scatter_m, radius_m, height_m, options, rng),
                    std::back_inserter(lines));
  return lines;
}

}  // namespace rangegrasp::cylinders
