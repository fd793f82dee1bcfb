#include "cylinders/barrel.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <stdexcept>

#include "base/statistics.h"

namespace rangegrasp::cylinders {
namespace {

using geometry::Indices;
using geometry::PointCloud;
using geometry::Points;

/// A point in a cylinder's own coordinates.
struct About {
  double along_m = 0.0;   ///< from the axis' point
  double radial_m = 0.0;  ///< distance from the axis
  Eigen::Vector3d radial;

  /// Unit, from the axis to the point.
  Eigen::Vector3d Out() const { return radial / std::max(radial_m, 1e-12); }
};

About PlaceOf(const Line& axis, const Eigen::Vector3d& p) {
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

/// Lengths along the axis are measured in radii, so that all parameters weigh alike.
Step StepOf(const PointCloud& cloud, const Indices& points, const Line& axis, const Across& across,
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
    const double on_u = out.dot(across.u);
    const double on_v = out.dot(across.v);
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

void Move(const Across& across, const Eigen::Vector4d& change, double radius_m, Line& axis) {
  axis.point += change[0] * across.u + change[1] * across.v;
  axis.direction =
      (axis.direction + (change[2] * across.u + change[3] * across.v) / radius_m).normalized();
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
  const Across across(axis.direction);
  for (const auto i : points) {
    const Eigen::Vector3d offset = cloud.points[i] - axis.point;
    const double angle = std::atan2(offset.dot(across.v), offset.dot(across.u));
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

/// The radius fitted together with the axis, its deviation, and their residuals.
void MeasureRadius(const PointCloud& cloud, const Line& fixed_axis, double radius_m,
                   double distance_m, RefinedAxis& refined) {
  Line axis = fixed_axis;
  double radius = radius_m;
  for (int round = 0; round < 3; ++round) {
    const Across across(axis.direction);
    const Step step = StepOf(cloud, refined.points, axis, across, radius, distance_m);
    if (round == 0) refined.rms_m = std::sqrt(step.weighted_squares / std::max(step.weights, 1.0));
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

/// The fullest run with those next to it, fuller ones first, that make it no longer than so many
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

/// Axis points with the normals that they came from.
struct Votes {
  Points places;
  Points normals;
};

Votes VotesOf(const PointCloud& cloud, double radius_m, int max_points) {
  const std::size_t step =
      std::max<std::size_t>(1, cloud.size() / static_cast<std::size_t>(max_points));
  Votes votes;
  for (std::size_t i = step / 2; i < cloud.size(); i += step) {
    votes.places.push_back(AxisPoint(cloud.points[i], cloud.normals[i], radius_m));
    votes.normals.push_back(cloud.normals[i]);
  }
  return votes;
}

/// Votes for standing axes by square cells in the plane of the table: places across, across, and
/// along its normal [m].
using Cells = std::map<std::pair<std::int64_t, std::int64_t>, Points>;

/// A place in the plane that many votes are about, at their mean height.
struct Peak {
  Eigen::Vector3d place;
  std::size_t count = 0;
};

std::vector<Line> Standing(const Votes& votes, const Eigen::Vector3d& up, double scatter_m,
                           double radius_m, const BarrelSearchOptions& options) {
  const auto& [u, v] = Across(up);
  const double max_sine = std::sin(options.max_off_square_rad);
  Cells cells;
  for (std::size_t i = 0; i < votes.places.size(); ++i) {
    if (std::abs(votes.normals[i].dot(up)) > max_sine) continue;
    const Eigen::Vector3d& p = votes.places[i];
    const Eigen::Vector3d place(p.dot(u), p.dot(v), p.dot(up));
    cells[{static_cast<std::int64_t>(std::floor(place.x() / scatter_m)),
           static_cast<std::int64_t>(std::floor(place.y() / scatter_m))}]
        .push_back(place);
  }
  std::vector<Peak> peaks;
  for (const auto& [cell, own] : cells) {
    // Each cell with its eight neighbors.
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
  std::stable_sort(peaks.begin(), peaks.end(),
                   [](const Peak& a, const Peak& b) { return a.count > b.count; });
  std::vector<Peak> apart;
  for (const Peak& peak : peaks) {
    if (apart.size() == static_cast<std::size_t>(options.max_standing)) break;
    const bool known = std::ranges::any_of(apart, [&](const Peak& other) {
      return (other.place - peak.place).head<2>().norm() < 0.5 * radius_m;
    });
    if (!known) apart.push_back(peak);
  }
  std::vector<Line> lines;
  lines.reserve(apart.size());
  for (const auto& [place, count] : apart) {
    lines.push_back({place.x() * u + place.y() * v + place.z() * up, up});
  }
  return lines;
}

/// Which votes are about a line, no further along it than a cylinder is high.
struct Support {
  const Votes& votes;
  double scatter_m;
  double height_m;
  double max_sine;

  bool Has(std::size_t i, const Line& line) const {
    const Eigen::Vector3d offset = votes.places[i] - line.point;
    const double along = offset.dot(line.direction);
    return std::abs(along) <= height_m &&
           (offset - along * line.direction).squaredNorm() <= scatter_m * scatter_m &&
           std::abs(votes.normals[i].dot(line.direction)) <= max_sine;
  }

  /// How many of them do, or anything below `enough` as soon as so many cannot be reached.
  std::size_t Count(const std::vector<std::size_t>& of, const Line& line,
                    std::size_t enough) const {
    std::size_t count = 0;
    for (std::size_t k = 0; k < of.size() && count + (of.size() - k) >= enough; ++k) {
      count += Has(of[k], line) ? 1 : 0;
    }
    return count;
  }

  std::vector<std::size_t> Of(const std::vector<std::size_t>& left, const Line& line) const {
    std::vector<std::size_t> supporters;
    for (const std::size_t i : left) {
      if (Has(i, line)) supporters.push_back(i);
    }
    return supporters;
  }
};

/// The horizontal axis that one vote names: square to its normal.
std::optional<Line> LyingThrough(const Votes& votes, std::size_t i, const Eigen::Vector3d& up,
                                 double min_lean) {
  const Eigen::Vector3d across = up.cross(votes.normals[i]);
  const double sine = across.norm();
  if (sine < min_lean) return std::nullopt;
  return Line{votes.places[i], across / sine};
}

/// Fits the line to the votes that support it; returns these.
std::vector<std::size_t> FitToSupport(const Support& support, const std::vector<std::size_t>& of,
                                      Line& line) {
  auto supporters = support.Of(of, line);
  Points places;
  for (const std::size_t i : supporters) places.push_back(support.votes.places[i]);
  if (const auto fit = FitTrimmedLine(places)) line = *fit;
  return supporters;
}

/// The best supported of the lines that `draw` makes in so many draws, where one is supported
/// enough.
template <typename Draw>
std::optional<Line> BestDrawn(const Support& support, const std::vector<std::size_t>& of, int draws,
                              int min_support, Draw draw) {
  std::optional<Line> best;
  std::size_t most = 0;
  for (int k = 0; k < draws; ++k) {
    const std::optional<Line> line = draw();
    if (!line) continue;
    const std::size_t count = support.Count(of, *line, most + 1);
    if (count <= most) continue;
    most = count;
    best = line;
  }
  return most < static_cast<std::size_t>(min_support) ? std::nullopt : best;
}

std::vector<std::size_t> Without(const std::vector<std::size_t>& all,
                                 const std::vector<std::size_t>& taken) {
  std::vector<std::size_t> rest;
  std::ranges::set_difference(all, taken, std::back_inserter(rest));
  return rest;
}

std::vector<Line> Lying(const Votes& votes, const Eigen::Vector3d& up, double scatter_m,
                        double height_m, const BarrelSearchOptions& options, base::Rng& rng) {
  const double max_sine = std::sin(options.max_off_square_rad);
  const double max_upright = std::cos(options.max_off_square_rad);
  const double min_lean = std::sin(options.min_lean_rad);
  // What faces sideways only is of standing things; half of what is seen of a lying one leans.
  std::vector<std::size_t> left;
  std::vector<std::size_t> leaning;
  for (std::size_t i = 0; i < votes.places.size(); ++i) {
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
    // Once more with all that is about the line through the supporters.
    FitToSupport(support, leaning, *line);
    FitToSupport(support, left, *line);
    lines.push_back(*line);
    // Twice the scatter: what is left of the same barrel would be found again.
    const Support wider{votes, 2.0 * scatter_m, 2.0 * height_m, 1.0};
    auto rest = Without(leaning, wider.Of(leaning, *line));
    if (rest.size() == leaning.size()) break;
    leaning = std::move(rest);
  }
  return lines;
}

/// The line through the axis points of two votes, if it is oblique and square to both normals.
std::optional<Line> LeaningThrough(const Votes& votes, std::size_t i, std::size_t k,
                                   const Eigen::Vector3d& up, double min_length_m,
                                   double max_length_m, const BarrelSearchOptions& options) {
  const Eigen::Vector3d way = votes.places[k] - votes.places[i];
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
  return Line{votes.places[i], direction};
}

std::vector<Line> Leaning(const Votes& votes, const Eigen::Vector3d& up, double scatter_m,
                          double radius_m, double height_m, const BarrelSearchOptions& options,
                          base::Rng& rng) {
  const Support support{votes, scatter_m, height_m, std::sin(options.max_off_square_rad)};
  std::vector<std::size_t> left(votes.places.size());
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
    left = Without(left, taken);
  }
  return lines;
}

}  // namespace

Indices BarrelPoints(geometry::PointSpan points, const Line& axis, double radius_m, double low_m,
                     double high_m, double distance_m) {
  Indices barrel;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const About about = PlaceOf(axis, points[i]);
    if (about.along_m < low_m || about.along_m > high_m) continue;
    if (std::abs(about.radial_m - radius_m) <= distance_m) barrel.push_back(i);
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

std::vector<Line> FindBarrels(const PointCloud& cloud, const Eigen::Vector3d& up, double radius_m,
                              double height_m, const BarrelSearchOptions& options, base::Rng& rng) {
  if (cloud.normals.size() != cloud.size()) {
    throw std::invalid_argument("a search for barrels needs one normal a point");
  }
  const double scatter_m =
      std::max<double>(options.min_scatter_m, options.scatter_of_radius * radius_m);
  const Votes votes = VotesOf(cloud, radius_m, options.points);
  std::vector<Line> lines = Standing(votes, up, scatter_m, radius_m, options);
  const std::vector<Line> lying = Lying(votes, up, scatter_m, height_m, options, rng);
  lines.insert(lines.end(), lying.begin(), lying.end());
  const Votes fewer = VotesOf(cloud, radius_m, options.pair_points);
  const std::vector<Line> leaning = Leaning(fewer, up, scatter_m, radius_m, height_m, options, rng);
  lines.insert(lines.end(), leaning.begin(), leaning.end());
  return lines;
}

}  // namespace rangegrasp::cylinders
