#include "parts/cloud/walls.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "geometry/kd_tree.h"
#include "parts/cloud/internal/join_parts.h"
#include "parts/shape/face_frames.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;

/// Of a wall, in edges: noise that joins a wall's sides is about one edge, and what is three times
/// as thick stays apart.
constexpr double kThickness = 4.0;
/// Of the smaller part's area, that faces the other.
constexpr double kShare = 0.5;
/// Cosines: of the way to the other face with the normal, and of both normals.
constexpr double kAcross = 0.8, kParallel = 0.7;

/// The nearest face that lies before or behind one, about parallel to it.
std::optional<std::uint32_t> Facing(const FaceFrames& frames, const geometry::KdTree& tree,
                                    std::uint32_t f, double reach,
                                    std::vector<geometry::KdTree::Neighbor>& near) {
  tree.Within(frames.center[f], reach, near);
  std::optional<std::uint32_t> best;
  double distance = reach * reach;
  for (const auto& n : near) {
    const Vector3d way = frames.center[n.index] - frames.center[f];
    if (n.squared_distance >= distance) continue;
    if (std::abs(way.dot(frames.normal[f])) < kAcross * way.norm()) continue;
    if (std::abs(frames.normal[f].dot(frames.normal[n.index])) < kParallel || n.index == f)
      continue;
    distance = n.squared_distance;
    best = n.index;
  }
  return best;
}

}  // namespace

Segmentation JoinWalls(const Shape& mesh, const Segmentation& found) {
  const FaceFrames frames = BuildFaceFrames(mesh);
  const double edge =
      std::sqrt(4.0 / std::sqrt(3.0) * frames.total_area / static_cast<double>(frames.area.size()));
  const geometry::KdTree tree(frames.center);
  std::vector<geometry::KdTree::Neighbor> near;
  std::map<std::pair<std::int32_t, std::int32_t>, double> facing;
  std::vector<double> area(static_cast<std::size_t>(found.parts), 0.0);
  for (std::uint32_t f = 0; f < frames.area.size(); ++f) {
    area[static_cast<std::size_t>(found.label[f])] += frames.area[f];
    const auto other = Facing(frames, tree, f, kThickness * edge, near);
    if (other) facing[{found.label[f], found.label[*other]}] += frames.area[f];
  }
  geometry::UnionFind sets(area.size());
  bool any = false;
  for (const auto& [parts, size] : facing) {
    const auto a = static_cast<std::uint32_t>(parts.first);
    const auto b = static_cast<std::uint32_t>(parts.second);
    if (area[a] <= area[b] && size >= kShare * area[a]) any = sets.Unite(a, b) || any;
  }
  return any ? JoinParts(found, area, sets) : found;
}

}  // namespace rangegrasp::parts
