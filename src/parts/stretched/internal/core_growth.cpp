#include "parts/stretched/internal/core_growth.h"

#include <algorithm>
#include <utility>

#include "geometry/hull.h"
#include "parts/shape/internal/pieces.h"

namespace rangegrasp::parts {
namespace {

/// The core's hull is tried at factors of growth so far apart: finer steps cost time, coarser ones
/// may pass over the sizes at which a limb is apart.
constexpr double kGrowthStep = 0.05;
/// Share of the faces from which a part counts: a smaller one is a shell left by the hull's
/// corners.
constexpr double kMinShare = 0.01;

/// For each point the factor by which a hull has to grow about `center` until it holds the point.
std::vector<double> GrowthToHold(const geometry::Points& points, const geometry::TriangleMesh& hull,
                                 const Eigen::Vector3d& center) {
  std::vector<double> growth(points.size(), 0.0);
  for (const auto& [a, b, c] : hull.triangles) {
    const Eigen::Vector3d normal =
        (hull.vertices[b] - hull.vertices[a]).cross(hull.vertices[c] - hull.vertices[a]);
    const double distance = normal.dot(hull.vertices[a] - center);
    if (!(distance > 0.0)) continue;
    for (std::size_t i = 0; i < points.size(); ++i) {
      growth[i] = std::max(growth[i], normal.dot(points[i] - center) / distance);
    }
  }
  return growth;
}

struct Grown {
  Segmentation segmentation;
  std::size_t large = 0;  ///< parts that count
};
Grown WithCore(const FaceGraph& faces, const std::vector<bool>& core) {
  Grown grown;
  Segmentation& found = grown.segmentation;
  found.parts = 1 + LabelOutside(faces, core, found.label);
  found.has_core = true;
  std::vector<std::uint32_t> size(static_cast<std::size_t>(found.parts), 0);
  for (const std::int32_t label : found.label) ++size[static_cast<std::size_t>(label)];
  for (std::size_t p = 1; p < size.size(); ++p) {
    if (size[p] >= kMinShare * static_cast<double>(core.size())) ++grown.large;
  }
  return grown;
}

/// The factor at which each face is held as a whole; 0 for those of the core.
std::vector<double> GrowthOfFaces(const Shape& form, const Segmentation& segmentation) {
  std::vector<bool> used(form.points.size(), false);
  geometry::Points core;
  for (std::size_t f = 0; f < form.faces.size(); ++f) {
    if (segmentation.label[f] != 0) continue;
    for (const std::uint32_t v : form.faces[f]) {
      if (!used[v]) core.push_back(form.points[v]);
      used[v] = true;
    }
  }
  const geometry::TriangleMesh hull = geometry::ConvexHull(core);
  if (hull.triangles.empty()) return {};
  const std::vector<double> of_point =
      GrowthToHold(form.points, hull, geometry::Centroid(hull.vertices));
  std::vector<double> growth(form.faces.size(), 0.0);
  for (std::size_t f = 0; f < form.faces.size(); ++f) {
    if (segmentation.label[f] == 0) continue;
    for (const std::uint32_t v : form.faces[f]) growth[f] = std::max(growth[f], of_point[v]);
  }
  return growth;
}

}  // namespace

Segmentation GrowCore(const Shape& form, const Segmentation& segmentation, double max_growth) {
  if (max_growth < 1.0 + kGrowthStep) return segmentation;
  const std::vector<double> growth = GrowthOfFaces(form, segmentation);
  if (growth.empty()) return segmentation;
  constexpr double kRounding = 1e-9;  // of a step
  const FaceGraph faces = BuildFaceGraph(form);
  const int steps = static_cast<int>((max_growth - 1.0) / kGrowthStep + kRounding);
  Grown best;
  for (int step = 0; step <= steps; ++step) {
    std::vector<bool> core(growth.size());
    for (std::size_t f = 0; f < core.size(); ++f) core[f] = growth[f] <= 1.0 + kGrowthStep * step;
    Grown grown = WithCore(faces, core);
    if (step == 0 || grown.large > best.large) best = std::move(grown);
  }
  best.segmentation.note = segmentation.note;
  return best.segmentation;
}

}  // namespace rangegrasp::parts
