#include "cylinders/barrel_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <optional>
#include <stdexcept>

namespace rangegrasp::cylinders {
namespace {

using geometry::PointCloud;
using geometry::Points;

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

/// A vote for a standing axis in the plane of the table.
struct Flat {
  std::int64_t x = 0, y = 0;  ///< its cell
  Eigen::Vector3d place;      ///< across, across, and along the table's normal [m]
};

struct Cell {
  std::int64_t x = 0, y = 0;
  std::size_t first = 0, count = 0;
};

/// Counts votes in square cells, and in each cell with its eight neighbors.
class BarrelGrid {
 public:
  BarrelGrid(std::vector<Flat> votes, double cell_m) : votes_(std::move(votes)) {
    for (Flat& vote : votes_) {
      vote.x = static_cast<std::int64_t>(std::floor(vote.place.x() / cell_m));
      vote.y = static_cast<std::int64_t>(std::floor(vote.place.y() / cell_m));
    }
    std::stable_sort(votes_.begin(), votes_.end(), [](const Flat& a, const Flat& b) {
      return a.x != b.x ? a.x < b.x : a.y < b.y;
    });
    for (std::size_t i = 0; i < votes_.size(); ++i) {
      if (cells_.empty() || cells_.back().x != votes_[i].x || cells_.back().y != votes_[i].y) {
        cells_.push_back({votes_[i].x, votes_[i].y, i, 0});
      }
      ++cells_.back().count;
    }
  }

  const std::vector<Cell>& cells() const { return cells_; }

  /// The sum and count of the votes in a cell and round it.
  std::pair<Eigen::Vector3d, std::size_t> Round(const Cell& cell) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::size_t count = 0;
    for (std::int64_t x = cell.x - 1; x <= cell.x + 1; ++x) {
      auto at = std::lower_bound(cells_.begin(), cells_.end(), std::pair{x, cell.y - 1},
                                 [](const Cell& a, const std::pair<std::int64_t, std::int64_t>& b) {
                                   return a.x != b.first ? a.x < b.first : a.y < b.second;
                                 });
      for (; at != cells_.end() && at->x == x && at->y <= cell.y + 1; ++at) {
        for (std::size_t i = at->first; i < at->first + at->count; ++i) sum += votes_[i].place;
        count += at->count;
      }
    }
    return {sum, count};
  }

 private:
  std::vector<Flat> votes_;
  std::vector<Cell> cells_;
};

/// A place in the plane that many votes are about, at their mean height.
struct Peak {
  Eigen::Vector3d place;
  std::size_t count = 0;
};

std::vector<Line> Standing(const Votes& votes, const Eigen::Vector3d& up, double scatter_m,
                           double radius_m, const BarrelSearchOptions& options) {
  const Eigen::Vector3d u = up.unitOrthogonal();
  const Eigen::Vector3d v = up.cross(u);
  const double max_sine = std::sin(options.max_off_square_rad);
  std::vector<Flat> flat;
  for (std::size_t i = 0; i < votes.places.size(); ++i) {
    if (std::abs(votes.normals[i].dot(up)) > max_sine) continue;
    const Eigen::Vector3d& p = votes.places[i];
    flat.push_back({0, 0, {p.dot(u), p.dot(v), p.dot(up)}});
  }
  const BarrelGrid grid(std::move(flat), scatter_m);
  std::vector<Peak> peaks;
  for (const Cell& cell : grid.cells()) {
    const auto [sum, count] = grid.Round(cell);
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

Points PlacesOf(const Votes& votes, const std::vector<std::size_t>& chosen) {
  Points places;
  for (const std::size_t i : chosen) places.push_back(votes.places[i]);
  return places;
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
    std::optional<Line> best;
    std::size_t most = 0;
    for (int draw = 0; draw < options.draws; ++draw) {
      const std::size_t i = leaning[rng.Index(leaning.size())];
      const auto line = LyingThrough(votes, i, up, min_lean);
      if (!line) continue;
      const std::size_t count = support.Count(leaning, *line, most + 1);
      if (count <= most) continue;
      most = count;
      best = line;
    }
    if (!best || most < static_cast<std::size_t>(options.min_support)) break;
    // Once more with all that is about the line through the supporters.
    const auto drawn = support.Of(leaning, *best);
    if (const auto fit = FitTrimmedLine(PlacesOf(votes, drawn))) best = fit;
    const auto about = support.Of(left, *best);
    if (const auto fit = FitTrimmedLine(PlacesOf(votes, about))) best = fit;
    lines.push_back(*best);
    // Twice the scatter: what is left of the same barrel would be found again.
    const Support wider{votes, 2.0 * scatter_m, 2.0 * height_m, 1.0};
    const auto taken = wider.Of(leaning, *best);
    std::vector<std::size_t> rest;
    std::set_difference(leaning.begin(), leaning.end(), taken.begin(), taken.end(),
                        std::back_inserter(rest));
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
    std::optional<Line> best;
    std::size_t most = 0;
    for (int draw = 0; draw < options.pair_draws; ++draw) {
      const std::size_t i = left[rng.Index(left.size())];
      const std::size_t k = left[rng.Index(left.size())];
      const auto line = LeaningThrough(votes, i, k, up, radius_m, height_m, options);
      if (!line) continue;
      const std::size_t count = support.Count(left, *line, most + 1);
      if (count <= most) continue;
      most = count;
      best = line;
    }
    if (!best || most < static_cast<std::size_t>(options.min_support)) break;
    const auto drawn = support.Of(left, *best);
    if (const auto fit = FitTrimmedLine(PlacesOf(votes, drawn))) best = fit;
    lines.push_back(*best);
    std::vector<std::size_t> rest;
    std::set_difference(left.begin(), left.end(), drawn.begin(), drawn.end(),
                        std::back_inserter(rest));
    left = std::move(rest);
  }
  return lines;
}

}  // namespace

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
