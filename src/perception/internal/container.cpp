#include "perception/internal/container.h"

#include <cmath>
#include <limits>
#include <ranges>

#include "base/statistics.h"

namespace rangegrasp::perception::internal {
namespace {

using Flat = std::vector<Vector2d>;

/// A cloud's points seen from above, their heights, and which belong to upright surfaces.
struct Seen {
  Flat all;
  std::vector<double> height_m;
  Flat upright;
  Flat facing;  ///< one per upright point: its normal's part in the table's plane
};

Seen SeeFromAbove(const PointCloud& cloud, const PlanarFrame& frame,
                  const ContainerOptions& options) {
  Seen seen;
  seen.all = Flatten(frame, cloud.points);
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const Vector3d& n = cloud.normals[i];
    seen.height_m.push_back(frame.Height(cloud.points[i]));
    if (std::abs(n.dot(frame.n)) > options.max_upward) continue;
    seen.upright.push_back(seen.all[i]);
    seen.facing.emplace_back(n.dot(frame.u), n.dot(frame.v));
  }
  return seen;
}

/// Local maxima [rad, up to a quarter turn] of the histogram of upright normals, the highest first.
std::vector<double> Directions(const Seen& seen, const ContainerOptions& options) {
  constexpr double kQuarter = std::numbers::pi / 2.0;
  const auto bins = static_cast<std::size_t>(std::lround(kQuarter / options.direction_step_rad));
  std::vector<double> count(bins, 0.0);
  for (const auto& n : seen.facing) {
    const double turn = std::atan2(n.y(), n.x()) / kQuarter;
    const double part = turn - std::floor(turn);
    ++count[std::min(bins - 1, static_cast<std::size_t>(part * static_cast<double>(bins)))];
  }
  std::vector<std::pair<double, std::size_t>> peaks;
  const auto smooth = [&](std::size_t k) {
    return count[(k + bins - 1) % bins] + count[k] + count[(k + 1) % bins];
  };
  for (std::size_t k = 0; k < bins; ++k) {
    const double here = smooth(k);
    if (here > 0.0 && here >= smooth((k + bins - 1) % bins) && here > smooth((k + 1) % bins)) {
      peaks.emplace_back(-here, k);
    }
  }
  std::ranges::sort(peaks);
  peaks.resize(std::min(peaks.size(), static_cast<std::size_t>(options.max_directions)));
  std::vector<double> directions;
  for (const auto& [negative, k] : peaks) {
    directions.push_back((static_cast<double>(k) + 0.5) / static_cast<double>(bins) * kQuarter);
  }
  return directions;
}

/// The same in a frame that is turned about the table's normal; `facing` is left as it is.
Seen Turned(const Seen& seen, double by_rad) {
  const Eigen::Matrix2d back = Eigen::Rotation2Dd(-by_rad).toRotationMatrix();
  Seen turned = seen;
  for (Flat* points : {&turned.all, &turned.upright}) {
    for (auto& q : *points) q = back * q;
  }
  return turned;
}

constexpr double kNothing = -std::numeric_limits<double>::infinity();

/// A line across one of the axes, and its height at the steps along it.
struct Line {
  double at_m = 0.0;
  std::vector<double> highest_m;    ///< of the points at each step; kNothing if there are none
  std::vector<int> level_before{};  ///< number of steps before each that are as high as the rim

  /// The height of most of its steps, within the margin.
  double Level(double margin_m) const {
    std::vector<double> heights = highest_m;
    std::erase(heights, kNothing);
    std::ranges::sort(heights);
    std::size_t first = 0;
    std::size_t best = 0;
    std::size_t most = 0;
    for (std::size_t last = 0; last < heights.size(); ++last) {
      while (heights[last] - heights[first] > 2.0 * margin_m) ++first;
      if (last - first + 1 <= most) continue;
      most = last - first + 1;
      best = first;
    }
    return heights.empty() ? kNothing : heights[best + most / 2];
  }

  void FindLevel(double rim_m, double margin_m) {
    level_before.assign(1, 0);
    for (const double h : highest_m) {
      level_before.push_back(level_before.back() + (std::abs(h - rim_m) <= margin_m ? 1 : 0));
    }
  }
};

/// One axis of the search; positions are along it, steps are across it.
class Axis {
 public:
  Axis(const Seen& seen, Eigen::Index axis, const ContainerOptions& options)
      : options_(options), seen_(seen), at_(axis), along_(1 - axis) {
    Eigen::AlignedBox2d box(Vector2d::Zero().eval());
    for (const auto& q : seen.all) box.extend(q);
    first_step_ = StepOf(box.min()[along_]);
    steps_ = static_cast<std::size_t>(StepOf(box.max()[along_]) - first_step_ + 1);
  }

  /// Finds the sheets: windows as wide as a wall that have more steps with upright points than
  /// their neighbors, and enough for a wall; and the ends of each along the other axis.
  void FindSheets(std::vector<double>& at, std::vector<double>& ends) const {
    if (seen_.upright.empty()) return;
    const double half_m = 0.5 * options_.wall_m;
    const auto [low, high] = std::ranges::minmax(
        seen_.upright | std::views::transform([this](const Vector2d& q) { return q[at_]; }));
    const auto bins = static_cast<std::size_t>((high - low) / half_m) + 2;
    std::vector<Flat> in(bins);
    for (const Vector2d& q : seen_.upright) {
      in[static_cast<std::size_t>((q[at_] - low) / half_m)].push_back(q);
    }
    std::vector<int> support;
    for (std::size_t k = 0; k + 1 < bins; ++k) support.push_back(Support(in[k], in[k + 1]));
    for (std::size_t k = 0; k < support.size(); ++k) {
      if (support[k] * options_.coverage_step_m < 0.5 * options_.min_side_m) continue;
      if (k > 0 && support[k - 1] > support[k]) continue;
      if (k + 1 < support.size() && support[k + 1] > support[k]) continue;
      std::vector<double> positions;
      std::vector<double> along;
      for (const Flat* bin : {&in[k], &in[k + 1]}) {
        for (const Vector2d& q : *bin) {
          positions.push_back(q[at_]);
          along.push_back(q[along_]);
        }
      }
      at.push_back(base::UpperMedianOf(std::move(positions)));
      const auto others = static_cast<std::size_t>(options_.min_end_points);
      ends.push_back(SupportedEnd(along, others, options_.wall_m));
      for (auto& s : along) s = -s;
      ends.push_back(-SupportedEnd(along, others, options_.wall_m));
    }
  }

  /// A line at each position; positions within half a wall's thickness become one.
  std::vector<Line> LinesAt(std::vector<double> positions) const {
    std::ranges::sort(positions);
    std::vector<Line> lines;
    for (const double at : positions) {
      if (!lines.empty() && at - lines.back().at_m < 0.5 * options_.wall_m) continue;
      lines.push_back({at, std::vector<double>(steps_, kNothing)});
    }
    for (std::size_t i = 0; i < seen_.all.size(); ++i) {
      const double at = seen_.all[i][at_];
      auto line = std::ranges::lower_bound(lines, at - options_.wall_m, {}, &Line::at_m);
      for (; line != lines.end() && line->at_m <= at + options_.wall_m; ++line) {
        double& highest_m = line->highest_m[Step(seen_.all[i])];
        highest_m = std::max(highest_m, seen_.height_m[i]);
      }
    }
    return lines;
  }

  /// The length [m] between two positions of the other axis where the line is as high as the rim.
  double Covered(const Line& line, double from_m, double to_m) const {
    const auto bound = [&](double m) {
      return static_cast<std::size_t>(
          std::clamp(StepOf(m) - first_step_, 0L, static_cast<long>(steps_)));
    };
    const double covered = (line.level_before[bound(to_m)] - line.level_before[bound(from_m)]) *
                           options_.coverage_step_m;
    return std::min(covered, to_m - from_m);
  }

  /// The place at a position across this axis and one along it.
  Vector2d Corner(double at_m, double along_m) const {
    Vector2d corner;
    corner[at_] = at_m;
    corner[along_] = along_m;
    return corner;
  }

 private:
  long StepOf(double along_m) const {
    return static_cast<long>(std::floor(along_m / options_.coverage_step_m));
  }
  std::size_t Step(const Vector2d& q) const {
    return static_cast<std::size_t>(StepOf(q[along_]) - first_step_);
  }

  /// The number of steps with points in a window of two bins; single points are strays.
  int Support(const Flat& a, const Flat& b) const {
    if (a.empty() && b.empty()) return 0;
    std::vector<int> points(steps_, 0);
    for (const auto& q : a) ++points[Step(q)];
    for (const auto& q : b) ++points[Step(q)];
    return static_cast<int>(std::ranges::count_if(points, [](int n) { return n > 1; }));
  }

  const ContainerOptions& options_;
  const Seen& seen_;
  Eigen::Index at_;
  Eigen::Index along_;
  long first_step_ = 0;
  std::size_t steps_ = 0;
};

/// A rectangle along the axes of a turned frame, and its rim.
struct RimBox {
  Eigen::AlignedBox2d box;
  double rim_m = 0.0;     ///< height of the rim
  double coverage = 0.0;  ///< share of the rim that is so high; 0: there is none
};

/// Replaces `best` by the rectangle with the largest level share of its border, if that is better,
/// among those with two sides across one axis, at sheets, and two across the other.
void SearchRim(const Axis& axis, const std::vector<double>& sheets, const Axis& other,
               const std::vector<double>& others, const ContainerOptions& options, RimBox& best) {
  const double margin_m = 2.0 * options.rim_margin_m;
  std::vector<Line> opposite = axis.LinesAt(sheets);
  std::vector<Line> between = other.LinesAt(others);
  const auto try_box = [&](const Line& low, const Line& high, const Line& left, const Line& right,
                           double rim_m) {
    const double across = high.at_m - low.at_m;
    const double along = right.at_m - left.at_m;
    if (across < options.min_side_m || along < options.min_side_m) return;
    const double covered =
        axis.Covered(low, left.at_m, right.at_m) + axis.Covered(high, left.at_m, right.at_m) +
        other.Covered(left, low.at_m, high.at_m) + other.Covered(right, low.at_m, high.at_m);
    const double length = 2.0 * (high.at_m - low.at_m + right.at_m - left.at_m);
    if (covered <= best.coverage * length) return;
    best = {{axis.Corner(low.at_m, left.at_m), axis.Corner(high.at_m, right.at_m)},
            rim_m,
            covered / length};
  };
  for (const Line& low : opposite) {
    const double rim_m = low.Level(margin_m);
    for (Line& line : opposite) line.FindLevel(rim_m, margin_m);
    for (Line& line : between) line.FindLevel(rim_m, margin_m);
    for (const Line& high : opposite) {
      for (const Line& left : between) {
        for (const Line& right : between) try_box(low, high, left, right, rim_m);
      }
    }
  }
}

/// The rectangle with two sheets as opposite sides and the largest level share of its border.
RimBox FindRimBox(const Seen& seen, const ContainerOptions& options) {
  const std::array<Axis, 2> axes{Axis(seen, 0, options), Axis(seen, 1, options)};
  std::array<std::vector<double>, 2> sheets;
  std::array<std::vector<double>, 2> ends;  // of the sheets of the other axis
  axes[0].FindSheets(sheets[0], ends[1]);
  axes[1].FindSheets(sheets[1], ends[0]);
  RimBox best;
  for (std::size_t a = 0; a < 2; ++a) {
    std::vector<double> others = sheets[1 - a];
    others.insert(others.end(), ends[1 - a].begin(), ends[1 - a].end());
    SearchRim(axes[a], sheets[a], axes[1 - a], others, options, best);
  }
  return best;
}

/// The turn [rad] of the upright points at the border: the slope of one line through all.
double TurnOf(const RimBox& border, const Flat& upright, double wall_m) {
  double turned = 0.0;
  double spread = 0.0;
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    for (const double side : {border.box.min()[axis], border.box.max()[axis]}) {
      Vector2d mean = Vector2d::Zero();
      Flat at;
      for (const auto& q : upright) {
        if (std::abs(q[axis] - side) > wall_m || border.box.exteriorDistance(q) > wall_m) continue;
        at.push_back(q);
        mean += q;
      }
      if (at.empty()) continue;
      mean /= static_cast<double>(at.size());
      for (const auto& q : at) {
        const Vector2d d = q - mean;
        turned += (axis == 0 ? -1.0 : 1.0) * d.x() * d.y();
        spread += d[1 - axis] * d[1 - axis];
      }
    }
  }
  return spread > 0.0 ? turned / spread : 0.0;
}

/// Whether the upright points around the border are on a circle rather than on its sides: a pot.
bool IsRound(const RimBox& border, Flat upright, double wall_m) {
  const auto from_side = [&](const Vector2d& q) {
    return std::abs(((q - border.box.center()).cwiseAbs() - 0.5 * border.box.sizes()).maxCoeff());
  };
  std::erase_if(upright, [&](const Vector2d& q) { return from_side(q) > 2.0 * wall_m; });
  const auto circle = FitCircle2(upright);
  if (!circle) return false;
  const auto at_circle = std::ranges::count_if(upright, [&](const Vector2d& q) {
    return std::abs((q - circle->center).norm() - circle->radius_m) <= wall_m;
  });
  const auto at_sides =
      std::ranges::count_if(upright, [&](const Vector2d& q) { return from_side(q) <= wall_m; });
  return at_circle > at_sides;
}

/// The best border over all directions, each refined with its own points.
std::optional<Container> FindWalls(const Seen& seen, const PlanarFrame& frame,
                                   const ContainerOptions& options) {
  RimBox best;
  double best_rad = 0.0;
  for (double direction : Directions(seen, options)) {
    for (int round = 0; round <= options.turn_rounds; ++round) {
      const Seen turned = Turned(seen, direction);
      const RimBox border = FindRimBox(turned, options);
      if (border.coverage == 0.0) break;
      if (border.coverage > best.coverage) {
        best = border;
        best_rad = direction;
      }
      direction += TurnOf(border, turned.upright, options.wall_m);
    }
  }
  if (best.coverage < options.min_coverage) return std::nullopt;
  if (IsRound(best, Turned(seen, best_rad).upright, options.wall_m)) return std::nullopt;
  const Eigen::Rotation2Dd turn(best_rad);
  const Vector2d sides = best.box.sizes();
  const bool along_x = sides.x() >= sides.y();
  return Container{frame,
                   {.center = turn * best.box.center(),
                    .axis = turn * (along_x ? Vector2d::UnitX() : Vector2d::UnitY()).eval(),
                    .length_m = sides.maxCoeff(),
                    .width_m = sides.minCoeff()},
                   best.rim_m + options.rim_margin_m};
}

/// Distance inside the rectangle's border; < 0: outside.
double Depth(const Rectangle& r, const Vector2d& q) {
  const Vector2d d = q - r.center;
  return std::min(0.5 * r.length_m - std::abs(d.dot(r.axis)),
                  0.5 * r.width_m - std::abs(Cross(r.axis, d)));
}

/// Whether the points inside at the height of the rim close the box: it is a cuboid.
bool HasLid(const PointCloud& cloud, const Container& container, const ContainerOptions& options) {
  Flat lid;
  for (const auto& p : cloud.points) {
    const Vector2d q = container.frame.Flat(p);
    const double below = container.rim_m - container.frame.Height(p);
    if (std::abs(below - options.rim_margin_m) <= 2.0 * options.rim_margin_m &&
        Depth(container.walls, q) > options.wall_m) {
      lid.push_back(q);
    }
  }
  return FilledArea(lid, options.coverage_step_m) >
         options.max_lid * container.walls.length_m * container.walls.width_m;
}

/// Whether a point lies within a distance of the border, below the rim.
bool IsAtWall(const Container& container, const Vector3d& p, double within_m) {
  return std::abs(Depth(container.walls, container.frame.Flat(p))) <= within_m &&
         container.frame.Height(p) <= container.rim_m;
}

}  // namespace

std::optional<Container> FindContainer(const PointCloud& cloud, const Plane& table,
                                       const ContainerOptions& options) {
  const PlanarFrame frame = MakePlanarFrame(table, geometry::Centroid(cloud.points));
  auto container = FindWalls(SeeFromAbove(cloud, frame, options), frame, options);
  if (container && HasLid(cloud, *container, options)) return std::nullopt;
  return container;
}

Indices PointsOfWalls(const PointCloud& cloud, const Container& container,
                      const ContainerOptions& options) {
  return geometry::PositionsWhere(
      cloud.points, [&](const Vector3d& p) { return IsAtWall(container, p, options.wall_m); });
}

bool IsPieceOfWall(const PointCloud& cloud, const Container& container,
                   const ContainerOptions& options, const Indices& segment) {
  return HoldsForShare(options.piece_share, segment, [&](auto i) {
    return IsAtWall(container, cloud.points[i], options.piece_walls * options.wall_m);
  });
}

}  // namespace rangegrasp::perception::internal
