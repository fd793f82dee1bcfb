#include "cylinders/curvature.h"

#include <cmath>
#include <optional>
#include <stdexcept>

namespace rangegrasp::cylinders {
namespace {

/// The first point at least step_m from point i, going along its scan line by `forward` or back.
std::optional<std::size_t> Along(geometry::PointSpan points, std::span<const ScanPlace> places,
                                 std::size_t i, bool forward, double step_m) {
  std::size_t at = i;
  for (;;) {
    if (forward ? at + 1 == points.size() : at == 0) return std::nullopt;
    at = forward ? at + 1 : at - 1;
    if (places[at].line != places[i].line) return std::nullopt;
    if ((points[at] - points[i]).squaredNorm() >= step_m * step_m) return at;
  }
}

}  // namespace

double MeanCosine(const Eigen::Vector3d& normal, geometry::PointSpan neighbor_normals) {
  if (neighbor_normals.empty()) return 1.0;
  double sum = 0.0;
  for (const Eigen::Vector3d& other : neighbor_normals) {
    sum += normal.dot(other) / (normal.norm() * other.norm());
  }
  return sum / static_cast<double>(neighbor_normals.size());
}

double EdgeCosine(const Eigen::Vector3d& before, const Eigen::Vector3d& p,
                  const Eigen::Vector3d& after) {
  const Eigen::Vector3d back = p - before;
  const Eigen::Vector3d ahead = p - after;
  const double lengths = back.norm() * ahead.norm();
  return lengths > 0.0 ? back.dot(ahead) / lengths : -1.0;
}

std::vector<bool> CurvedPoints(const geometry::PointCloud& cloud, const geometry::KdTree& tree,
                               const CurvatureOptions& options,
                               const geometry::NeighborLists& known) {
  const double max_cosine = std::cos(options.min_angle_rad);
  const bool usable = known.radius_m == options.radius_m;
  std::vector<bool> curved(cloud.size(), false);
  std::vector<geometry::KdTree::Neighbor> near;
  geometry::Indices searched;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    std::span<const std::uint32_t> neighbors;
    if (usable && known.Has(i)) {
      neighbors = known.Of(i);
    } else {
      tree.Within(cloud.points[i], options.radius_m, near);
      searched.clear();
      for (const auto& neighbor : near) searched.push_back(neighbor.index);
      neighbors = searched;
    }
    // The mean cosine of unit normals, by their sum. The point finds itself.
    Eigen::Vector3d sum = -cloud.normals[i];
    for (const auto k : neighbors) sum += cloud.normals[k];
    const auto others = static_cast<double>(neighbors.size()) - 1.0;
    curved[i] = others > 0.0 && cloud.normals[i].dot(sum) < max_cosine * others;
  }
  return curved;
}

std::vector<bool> LineEdges(geometry::PointSpan points, std::span<const ScanPlace> places,
                            const CurvatureOptions& options) {
  if (points.size() != places.size()) {
    throw std::invalid_argument("line edges need the place of each point in the scan");
  }
  const double min_cosine = std::cos(options.max_edge_angle_rad);
  std::vector<bool> edges(points.size(), false);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto before = Along(points, places, i, false, options.line_step_m);
    const auto after = Along(points, places, i, true, options.line_step_m);
    if (!before || !after) continue;
    edges[i] = EdgeCosine(points[*before], points[i], points[*after]) > min_cosine;
  }
  return edges;
}

}  // namespace rangegrasp::cylinders
