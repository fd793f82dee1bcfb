#include "parts/hierarchy/internal/surface_bend.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/kd_tree.h"

namespace rangegrasp::parts {
namespace {

/// Bits of edges that are looked at, at most: bounds the time; of a mesh with more, an even sample
/// stands for all.
constexpr std::size_t kMaxBits = 100000;
/// Bits of one edge, at most: bounds the work on meshes with a few very long edges.
constexpr int kMaxPieces = 1000;
/// Length of the sum of two unit normals below which the edge is folded flat and has no direction.
constexpr double kFolded = 1e-9;
/// Weight of a convex bend beside that of a concave one: cuts run along grooves and seldom along
/// ridges (minima rule).
constexpr double kConvexShare = 0.25;

/// A bit of an edge.
struct Bits {
  geometry::Points middle;
  geometry::Points normal;
  geometry::Points along;
  std::vector<double> weight;       ///< length times signed angle, > 0 convex
  std::vector<std::uint32_t> slot;  ///< of the edge, in FaceGraph::neighbor
};

/// The angle between two faces, > 0 where they are convex.
double Dihedral(const FaceFrames& frames, std::uint32_t f, std::uint32_t g) {
  const Eigen::Vector3d& n = frames.normal[f];
  const Eigen::Vector3d& m = frames.normal[g];
  const double angle = std::atan2(n.cross(m).norm(), n.dot(m));
  return n.dot(frames.center[g] - frames.center[f]) > 0.0 ? -angle : angle;
}

Bits BitsOfEdges(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                 double max_length) {
  Bits bits;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::uint32_t g = faces.neighbor[k];
      if (g < f) continue;
      const Eigen::Vector3d& a = mesh.points[faces.edge[k][0]];
      const Eigen::Vector3d& b = mesh.points[faces.edge[k][1]];
      const double length = (b - a).norm();
      const double angle = Dihedral(frames, f, g);
      Eigen::Vector3d normal = frames.normal[f] + frames.normal[g];
      if (normal.norm() > kFolded) normal.normalize();
      const int count = std::clamp(static_cast<int>(std::ceil(length / max_length)), 1, kMaxPieces);
      for (int i = 0; i < count; ++i) {
        bits.middle.emplace_back(a + (i + 0.5) / count * (b - a));
        bits.normal.push_back(normal);
        bits.along.emplace_back((b - a) / length);
        bits.weight.push_back(angle * length / count);
        bits.slot.push_back(k);
      }
    }
  }
  return bits;
}

std::vector<double> BendOfBits(const Bits& bits, double scale) {
  const std::size_t stride = (bits.middle.size() + kMaxBits - 1) / kMaxBits;
  geometry::Points some;
  for (std::size_t i = 0; i < bits.middle.size(); i += stride) some.push_back(bits.middle[i]);
  const geometry::KdTree tree(some);
  std::vector<geometry::KdTree::Neighbor> near;
  std::vector<double> bend(bits.middle.size(), 0.0);
  for (std::size_t i = 0; i < bits.middle.size(); ++i) {
    tree.Within(bits.middle[i], scale, near);
    double sum = 0.0;
    for (const auto& neighbor : near) {
      const std::size_t other = neighbor.index * stride;
      if (bits.normal[other].dot(bits.normal[i]) <= 0.0) continue;
      const double cosine = bits.along[other].dot(bits.along[i]);
      const double nearness = 1.0 - std::sqrt(neighbor.squared_distance) / scale;
      sum -= 2.0 * nearness * bits.weight[other] * cosine * cosine;
    }
    bend[i] = sum * static_cast<double>(stride) / (2.0 * scale);
  }
  return bend;
}

}  // namespace

std::vector<double> EdgeBends(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                              double scale) {
  const Bits bits = BitsOfEdges(mesh, faces, frames, scale);
  const std::vector<double> bend_of_bit = BendOfBits(bits, scale);
  // The bits come edge after edge; each edge has its lower face's turn.
  std::vector<double> bends(faces.neighbor.size(), 0.0);
  std::size_t bit = 0;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::uint32_t g = faces.neighbor[k];
      if (g < f) continue;
      double sum = 0.0;
      std::size_t count = 0;
      for (; bit < bits.slot.size() && bits.slot[bit] == k; ++bit, ++count) {
        sum += bend_of_bit[bit];
      }
      bends[k] = sum / static_cast<double>(count);
      for (std::uint32_t back = faces.begin[g]; back < faces.begin[g + 1]; ++back) {
        if (faces.neighbor[back] == f && faces.edge[back] == faces.edge[k]) bends[back] = bends[k];
      }
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
