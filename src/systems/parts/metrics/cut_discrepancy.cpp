#include "parts/metrics/cut_discrepancy.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "geometry/kd_tree.h"
#include "geometry/shortest_path.h"
#include "parts/shape/face_frames.h"

namespace rangegrasp::parts {
namespace {

double MeanDistanceToCentroid(const Shape& mesh) {
  const FaceFrames frames = BuildFaceFrames(mesh);
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (std::size_t f = 0; f < frames.area.size(); ++f) moment += frames.area[f] * frames.center[f];
  const Eigen::Vector3d centroid = moment / frames.total_area;
  double sum = 0.0;
  for (std::size_t f = 0; f < frames.area.size(); ++f) {
    sum += frames.area[f] * (frames.center[f] - centroid).norm();
  }
  return sum / frames.total_area;
}

}  // namespace

CutMeasure::CutMeasure(const Shape& mesh)
    : points_(mesh.points),
      faces_(BuildFaceGraph(mesh)),
      vertices_(BuildVertexGraph(mesh)),
      radius_(MeanDistanceToCentroid(mesh)) {}

std::vector<std::uint32_t> CutMeasure::CutVertices(std::span<const std::int32_t> label) const {
  std::vector<bool> on_cut(points_.size(), false);
  for (std::size_t f = 0; f + 1 < faces_.begin.size(); ++f) {
    for (std::uint32_t k = faces_.begin[f]; k < faces_.begin[f + 1]; ++k) {
      if (label[faces_.neighbor[k]] == label[f]) continue;
      for (const std::uint32_t v : faces_.edge[k]) on_cut[v] = true;
    }
  }
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < on_cut.size(); ++v) {
    if (on_cut[v]) vertices.push_back(v);
  }
  return vertices;
}

double CutMeasure::SumOfDistances(const std::vector<std::uint32_t>& from,
                                  const std::vector<std::uint32_t>& to) const {
  const std::vector<double> distance = geometry::DistancesFrom(to, vertices_.Links());
  geometry::Points targets;
  std::optional<geometry::KdTree> tree;
  std::vector<geometry::KdTree::Neighbor> nearest;
  double sum = 0.0;
  for (const std::uint32_t v : from) {
    if (distance[v] < geometry::ShortestPaths::kFar) {
      sum += distance[v];
      continue;
    }
    if (!tree) {
      targets = geometry::Select(points_, to);
      tree.emplace(targets);
    }
    tree->Nearest(points_[v], 1, nearest);
    sum += std::sqrt(nearest.front().squared_distance);
  }
  return sum;
}

std::optional<double> CutMeasure::Discrepancy(std::span<const std::int32_t> a,
                                              std::span<const std::int32_t> b) const {
  const std::size_t faces = faces_.begin.size() - 1;
  if (a.size() != faces || b.size() != faces) {
    throw std::invalid_argument(fmt::format(
        "CutMeasure: labellings of {} and {} faces; the mesh has {}", a.size(), b.size(), faces));
  }
  const std::vector<std::uint32_t> cut_a = CutVertices(a);
  const std::vector<std::uint32_t> cut_b = CutVertices(b);
  if (cut_a.empty() || cut_b.empty()) return std::nullopt;
  const double sum = SumOfDistances(cut_a, cut_b) + SumOfDistances(cut_b, cut_a);
  return sum / static_cast<double>(cut_a.size() + cut_b.size()) / radius_;
}

std::optional<double> CutDiscrepancy(const Shape& mesh, std::span<const std::int32_t> a,
                                     std::span<const std::int32_t> b) {
  return CutMeasure(mesh).Discrepancy(a, b);
}

}  // namespace rangegrasp::parts
