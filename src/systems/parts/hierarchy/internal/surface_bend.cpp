#include "parts/hierarchy/internal/surface_bend.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/kd_tree.h"
#include "parts/hierarchy/internal/patches.h"

namespace rangegrasp::parts {
namespace {

/// Side of the patches that stand for their edges, of the scale: within it bends are seen as one.
constexpr double kPatchSide = 0.25;
/// Weight of a convex bend beside that of a concave one: cuts run along grooves and seldom along
/// ridges (minima rule).
constexpr double kConvexShare = 0.25;

/// Sine of the angle between two faces that lie on each other, at most: rounding decides which of
/// them is above, so that the edge where they meet is neither ridge nor groove.
constexpr double kFold = 0.01;

/// Cosine below which a normal points away. That of a wall at a right angle does, whatever rounding
/// makes of it.
constexpr double kAway = 0.001;

/// The angle between two faces, > 0 where they are convex; 0 where they are folded on each other.
double Dihedral(const FaceFrames& frames, std::uint32_t f, std::uint32_t g) {
  const Eigen::Vector3d& n = frames.normal[f];
  const Eigen::Vector3d& m = frames.normal[g];
  const double sine = n.cross(m).norm();
  if (n.dot(m) < 0.0 && sine < kFold) return 0.0;
  const double angle = std::atan2(sine, n.dot(m));
  return n.dot(frames.center[g] - frames.center[f]) > 0.0 ? -angle : angle;
}

/// sum_e beta(e) |e| e e^T over the edges of each patch; an edge between two counts half in each.
std::vector<Eigen::Matrix3d> BendsOfPatches(const Shape& mesh, const FaceGraph& faces,
                                            const FaceFrames& frames, const Patches& patches) {
  std::vector<Eigen::Matrix3d> bends(patches.size(), Eigen::Matrix3d::Zero());
  for (std::uint32_t f = 0; f < frames.area.size(); ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const Eigen::Vector3d edge = mesh.points[faces.edge[k][1]] - mesh.points[faces.edge[k][0]];
      const double length = edge.norm();
      if (length == 0.0) continue;
      const double weight = 0.5 * Dihedral(frames, f, faces.neighbor[k]) / length;
      bends[static_cast<std::size_t>(patches.of_face[f])] += weight * edge * edge.transpose();
    }
  }
  return bends;
}

/// The tensors of the ball round each patch.
std::vector<Eigen::Matrix3d> BendsOfBalls(const Patches& patches,
                                          const std::vector<Eigen::Matrix3d>& bends, double scale) {
  const geometry::KdTree tree(patches.center);
  std::vector<geometry::KdTree::Neighbor> near;
  std::vector<Eigen::Matrix3d> of_ball(patches.size(), Eigen::Matrix3d::Zero());
  for (std::size_t p = 0; p < patches.size(); ++p) {
    tree.Within(patches.center[p], scale, near);
    for (const auto& other : near) {
      if (patches.normal[p].dot(patches.normal[other.index]) < kAway) continue;
      of_ball[p] += 2.0 * (1.0 - std::sqrt(other.squared_distance) / scale) * bends[other.index];
    }
  }
  return of_ball;
}

}  // namespace

std::vector<double> EdgeBends(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                              double scale) {
  const Patches patches = CutByGrid(faces, frames, kPatchSide * scale);
  const auto of_ball = BendsOfBalls(patches, BendsOfPatches(mesh, faces, frames, patches), scale);
  std::vector<double> bends(faces.neighbor.size(), 0.0);
  for (std::uint32_t f = 0; f < frames.area.size(); ++f) {
    const auto& here = of_ball[static_cast<std::size_t>(patches.of_face[f])];
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const auto& there = of_ball[static_cast<std::size_t>(patches.of_face[faces.neighbor[k]])];
      const Eigen::Vector3d along =
          (mesh.points[faces.edge[k][1]] - mesh.points[faces.edge[k][0]]).normalized();
      bends[k] = -along.dot((here + there) * along) / (4.0 * scale);
    }
  }
  return bends;
}

std::vector<double> BendCosts(const Shape& mesh, const FaceGraph& faces,
                              const std::vector<double>& bends, double gain) {
  std::vector<double> costs(bends.size());
  for (std::size_t k = 0; k < costs.size(); ++k) {
    const double length = (mesh.points[faces.edge[k][0]] - mesh.points[faces.edge[k][1]]).norm();
    costs[k] = length *
               (bends[k] > 0.0 ? std::exp(-gain * bends[k]) : 1.0 - kConvexShare * gain * bends[k]);
  }
  return costs;
}

}  // namespace rangegrasp::parts
