#include "parts/hierarchy/internal/cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "geometry/graph.h"
#include "geometry/kd_tree.h"

namespace rangegrasp::parts {
namespace {

// ---- bends ----

/// Side of the patches that represent their edges, relative to the scale; they merge bends within.
constexpr double kPatchSide = 0.25;
/// Weight of a convex bend compared with a concave one: cuts run along grooves and rarely along
/// ridges (minima rule).
constexpr double kConvexShare = 0.25;

/// Maximum sine of the angle between two faces folded onto each other. Rounding decides which of
/// them is above, so that the edge between them is neither a ridge nor a groove.
constexpr double kFold = 0.01;

/// Cosine below which a normal points away. The normal of a wall at a right angle then does so
/// regardless of rounding.
constexpr double kAway = 0.001;

/// The angle between two faces, > 0 if they are convex, 0 if they are folded onto each other.
double Dihedral(const FaceFrames& frames, std::uint32_t f, std::uint32_t g) {
  const Eigen::Vector3d& n = frames.normal[f];
  const Eigen::Vector3d& m = frames.normal[g];
  const double sine = n.cross(m).norm();
  if (n.dot(m) < 0.0 && sine < kFold) return 0.0;
  const double angle = std::atan2(sine, n.dot(m));
  return n.dot(frames.center[g] - frames.center[f]) > 0.0 ? -angle : angle;
}

/// A mesh divided into patches: connected faces whose centers lie in the same cube of a grid.
struct Patches {
  Labels of_face;     ///< numbered by their first faces
  FaceFrames frames;  ///< of the patches
};
Patches CutByGrid(const FaceGraph& faces, const FaceFrames& frames, double side) {
  std::vector<Eigen::Vector3i> cube;
  for (const Eigen::Vector3d& p : frames.center) {
    cube.emplace_back((p / side).array().floor().cast<int>());
  }
  geometry::UnionFind sets(cube.size());
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t) {
    if (g > f && cube[g] == cube[f]) sets.Unite(f, g);
  });
  Patches patches;
  Labels number(cube.size(), -1);
  std::int32_t numbers = 0;
  for (std::uint32_t f = 0; f < cube.size(); ++f) {
    std::int32_t& own = number[sets.Find(f)];
    if (own < 0) own = numbers++;
    patches.of_face.push_back(own);
  }
  patches.frames = GroupFrames(frames, patches.of_face, numbers);
  return patches;
}

/// sum_e beta(e) |e| e e^T over the edges of each patch; an edge between two counts half in each.
std::vector<Eigen::Matrix3d> BendsOfPatches(const Shape& mesh, const FaceGraph& faces,
                                            const FaceFrames& frames, const Patches& patches) {
  std::vector<Eigen::Matrix3d> bends(patches.frames.area.size(), Eigen::Matrix3d::Zero());
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    const Eigen::Vector3d edge = mesh.points[faces.edge[k][1]] - mesh.points[faces.edge[k][0]];
    const double length = edge.norm();
    if (length == 0.0) return;
    const double weight = 0.5 * Dihedral(frames, f, g) / length;
    bends[patches.of_face[f]] += weight * edge * edge.transpose();
  });
  return bends;
}

/// Weighted sum of the tensors in the ball around each patch.
std::vector<Eigen::Matrix3d> BendsOfBalls(const FaceFrames& patches,
                                          const std::vector<Eigen::Matrix3d>& bends, double scale) {
  const geometry::KdTree tree(patches.center);
  std::vector<geometry::KdTree::Neighbor> near;
  std::vector<Eigen::Matrix3d> of_ball(bends.size(), Eigen::Matrix3d::Zero());
  for (std::size_t p = 0; p < bends.size(); ++p) {
    tree.Within(patches.center[p], scale, near);
    for (const auto& other : near) {
      if (patches.normal[p].dot(patches.normal[other.index]) < kAway) continue;
      of_ball[p] += 2.0 * (1.0 - std::sqrt(other.squared_distance) / scale) * bends[other.index];
    }
  }
  return of_ball;
}

// ---- cells ----

/// Minimum patch area for a seed, relative to a cube's side; smaller patches are cut-off corners.
constexpr double kMinPatch = 0.3;
/// Depth below the surface at which cells look for each other, relative to the square root of the
/// area: deeper than noise and the bumps of coarse faces; at most a quarter of the thickness.
constexpr double kDepth = 0.005;
constexpr double kMinDepth = 1e-5;  ///< below the thickness of any wall
constexpr double kMaxThickness = 10.0;

/// Moves of seeds to the middle of their cells: the first evens the grid out, more change little.
constexpr int kRounds = 2;

/// A seed in each large patch of the grid, and in the largest patch of a piece without a seed.
Indices GridSeeds(const FaceGraph& faces, const FaceFrames& frames, double side) {
  const auto& [of_face, patches] = CutByGrid(faces, frames, side);
  std::vector<bool> wanted;
  for (const double area : patches.area) wanted.push_back(area >= kMinPatch * side * side);
  const auto& [piece, pieces] = ConnectedPieces(faces, AnyNeighbors);
  Labels largest(pieces, -1);
  std::vector<bool> has(pieces, false);
  for (std::size_t f = 0; f < piece.size(); ++f) {
    const std::int32_t p = of_face[f];
    if (wanted[p]) has[piece[f]] = true;
    std::int32_t& best = largest[piece[f]];
    if (best < 0 || patches.area[p] > patches.area[best]) best = p;
  }
  for (std::int32_t k = 0; k < pieces; ++k) {
    if (!has[k]) wanted[largest[k]] = true;
  }
  return ValuesAt(MiddleFaces(frames, of_face, patches.center), geometry::PositionsOf(wanted));
}

/// Builds the cells from the cell number of each face.
Cells Summarize(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                const std::vector<double>& costs, const Labels& of_face, std::size_t count) {
  FaceFrames sums = GroupFrames(frames, of_face, count);
  Cells cells;
  cells.of_face = of_face;
  cells.begin = {0};
  cells.center = std::move(sums.center);
  cells.normal = std::move(sums.normal);
  cells.area = std::move(sums.area);
  cells.on_edge.assign(count, 0);
  std::vector<std::map<std::uint32_t, Cells::Border>> borders(count);
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    if (of_face[g] == of_face[f]) return;
    Cells::Border& border = borders[of_face[f]][static_cast<std::uint32_t>(of_face[g])];
    border.cost += costs[k];
    border.length += LengthOf(mesh.points, faces.edge[k]);
  });
  for (std::size_t c = 0; c < count; ++c) {
    for (const auto& [to, border] : borders[c]) {
      cells.neighbor.push_back(to);
      // A border has the same cost from both sides, independent of the order of the sum.
      cells.border.push_back(to < c ? borders[to].at(static_cast<std::uint32_t>(c)) : border);
    }
    cells.begin.push_back(static_cast<std::uint32_t>(cells.neighbor.size()));
  }
  return cells;
}

}  // namespace

std::vector<double> EdgeBends(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                              double scale) {
  const Patches patches = CutByGrid(faces, frames, kPatchSide * scale);
  const auto of_ball =
      BendsOfBalls(patches.frames, BendsOfPatches(mesh, faces, frames, patches), scale);
  std::vector<double> bends(faces.neighbor.size(), 0.0);
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    const auto& here = of_ball[patches.of_face[f]];
    const auto& there = of_ball[patches.of_face[g]];
    const Eigen::Vector3d along =
        (mesh.points[faces.edge[k][1]] - mesh.points[faces.edge[k][0]]).normalized();
    bends[k] = -along.dot((here + there) * along) / (4.0 * scale);
  });
  return bends;
}

std::vector<double> BendCosts(const Shape& mesh, const FaceGraph& faces,
                              const std::vector<double>& bends, double gain) {
  std::vector<double> costs(bends.size());
  for (std::size_t k = 0; k < costs.size(); ++k) {
    costs[k] = LengthOf(mesh.points, faces.edge[k]) *
               (bends[k] > 0.0 ? std::exp(-gain * bends[k]) : 1.0 - kConvexShare * gain * bends[k]);
  }
  return costs;
}

Cells BuildCells(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                 const std::vector<double>& bends, const std::vector<double>& costs, int count,
                 double crease) {
  std::vector<double> step(bends.size());
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    const double length = (frames.center[f] - frames.center[g]).norm();
    step[k] = length * (1.0 + crease * std::max(0.0, bends[k]));
  });
  // A surface lies in about 1.5 area / side^2 patches, two thirds of which get a seed.
  Indices seeds = GridSeeds(faces, frames, std::sqrt(frames.total_area / count));
  Cells cells;
  for (int round = 0; round <= kRounds; ++round) {
    NearestSeeds nearest;
    GrowSeeds(faces, step, seeds, 0, nearest);
    cells = Summarize(mesh, faces, frames, costs, nearest.seed, seeds.size());
    if (round < kRounds) seeds = MiddleFaces(frames, cells.of_face, cells.center);
  }
  return cells;
}

Sight::Sight(const Shape& mesh, const FaceFrames& frames, const Cells& cells) {
  const geometry::TriangleMesh walls{mesh.points, mesh.faces};
  const geometry::TriangleMesh* const all = &walls;
  caster_ = std::make_unique<geometry::RayCaster>(std::span(&all, 1));
  const double unit = std::sqrt(frames.total_area);
  const std::uint32_t count = cells.size();
  const Indices middle = MiddleFaces(frames, cells.of_face, cells.center);
  for (const std::uint32_t f : middle) {
    const Eigen::Vector3d in = -frames.normal[f];
    rays_.push_back({frames.center[f].cast<float>(), in.cast<float>(),
                     static_cast<float>(kMinDepth * unit),
                     static_cast<float>(kMaxThickness * unit)});
  }
  std::vector<geometry::Hit> hits;
  caster_->FirstHits(rays_, hits);
  for (std::uint32_t c = 0; c < count; ++c) {
    const double thickness = hits[c].found() ? hits[c].distance_m : kMaxThickness * unit;
    below_.push_back(frames.center[middle[c]] -
                     std::min(kDepth * unit, 0.25 * thickness) * frames.normal[middle[c]]);
  }
  rank_.resize(count);
  // Multiples of the golden section, so that no region of the surface comes first.
  for (std::uint32_t k = 0; k < count; ++k) rank_[k] = k * 0x9e3779b9u;
  sees_.assign(PlaceOf(0, count), kUnknown);
}

Sight::Sight(const std::vector<std::vector<bool>>& sees)
    : rank_(sees.size()), sees_(PlaceOf(0, sees.size())) {
  for (std::uint32_t a = 0; a < sees.size(); ++a) {
    rank_[a] = a;
    for (std::uint32_t b = 0; b < a; ++b) sees_[PlaceOf(b, a)] = sees[a][b];
  }
}

void Sight::Look(std::span<const Pair> pairs, std::vector<std::uint8_t>& sees) {
  rays_.clear();
  asked_.clear();
  sees.clear();
  for (const auto& [one, other] : pairs) {
    // Rays always start from the cell with the larger number, since rounding may decide.
    const auto [a, b] = std::minmax(one, other);
    const std::size_t place = PlaceOf(a, b);
    if (sees_[place] == kUnknown) {
      const Eigen::Vector3d way = below_[a] - below_[b];
      const double length = way.norm();
      rays_.push_back({below_[b].cast<float>(), (way / std::max(length, 1e-30)).cast<float>(), 0.0f,
                       static_cast<float>(length)});
      asked_.emplace_back(place, sees.size());
    }
    sees.push_back(sees_[place]);
  }
  if (rays_.empty()) return;
  caster_->Blocked(rays_, blocked_);
  for (std::size_t k = 0; k < asked_.size(); ++k) {
    const auto& [place, answer] = asked_[k];
    sees[answer] = sees_[place] = blocked_[k] == 0;
  }
}

Cells Subset(const Cells& cells, const Indices& some) {
  constexpr std::uint32_t kOut = std::numeric_limits<std::uint32_t>::max();
  Indices number(cells.size(), kOut);
  for (std::uint32_t k = 0; k < some.size(); ++k) number[some[k]] = k;
  Cells subset;
  subset.begin = {0};
  subset.sight = cells.sight;
  for (const std::uint32_t c : some) {
    subset.center.push_back(cells.center[c]);
    subset.normal.push_back(cells.normal[c]);
    subset.area.push_back(cells.area[c]);
    subset.on_edge.push_back(cells.on_edge[c]);
    if (cells.sight) subset.name.push_back(cells.name[c]);
    for (std::uint32_t k = cells.begin[c]; k < cells.begin[c + 1]; ++k) {
      const std::uint32_t to = number[cells.neighbor[k]];
      if (to == kOut) {
        subset.on_edge.back() = 1;
      } else {
        subset.neighbor.push_back(to);
        subset.border.push_back(cells.border[k]);
      }
    }
    subset.begin.push_back(static_cast<std::uint32_t>(subset.neighbor.size()));
  }
  return subset;
}

}  // namespace rangegrasp::parts
