#include "parts/shape/segmentation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "geometry/kd_tree.h"

namespace rangegrasp::parts {
namespace {

using geometry::TriangleMesh;

Eigen::Vector3d Center(const TriangleMesh& mesh, std::size_t element) {
  if (mesh.triangles.empty()) return mesh.vertices[element];
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const std::uint32_t v : mesh.triangles[element]) {
    if (v >= mesh.vertices.size()) return Eigen::Vector3d::Constant(std::nan(""));
    sum += mesh.vertices[v] / 3.0;
  }
  return sum;
}

/// Hue in turns, from red over green and blue.
std::array<std::uint8_t, 3> FromHsv(double hue, double saturation, double value) {
  std::array<std::uint8_t, 3> color{};
  for (int i = 0; i < 3; ++i) {
    const double turn = 6.0 * std::fmod(hue + (i == 0 ? 0.0 : (3.0 - i) / 3.0), 1.0);
    const double ramp = std::clamp(std::abs(turn - 3.0) - 1.0, 0.0, 1.0);
    color[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(std::lround(255.0 * value * (1.0 - saturation * (1.0 - ramp))));
  }
  return color;
}

}  // namespace

std::vector<std::int32_t> LabelsOfInput(const Shape& shape, const TriangleMesh& input,
                                        const Segmentation& segmentation) {
  const std::size_t n = shape.element_of_input.size();
  std::vector<std::int32_t> label(n, 0);
  geometry::Points kept;
  std::vector<std::size_t> kept_index;
  for (std::size_t i = 0; i < n; ++i) {
    if (shape.element_of_input[i] < 0) continue;
    label[i] = segmentation.label[static_cast<std::size_t>(shape.element_of_input[i])];
    kept.push_back(Center(input, i));
    kept_index.push_back(i);
  }
  if (kept.size() == n || kept.empty()) return label;
  const geometry::KdTree tree(kept);
  std::vector<geometry::KdTree::Neighbor> found;
  for (std::size_t i = 0; i < n; ++i) {
    if (shape.element_of_input[i] >= 0) continue;
    const Eigen::Vector3d center = Center(input, i);
    if (!IsUsable(center)) {
      label[i] = -1;
      continue;
    }
    tree.Nearest(center, 1, found);
    label[i] = label[kept_index[found.front().index]];
  }
  return label;
}

std::vector<std::int32_t> LabelsOfPolygons(const geometry::PolygonMesh& input,
                                           std::span<const std::int32_t> triangles) {
  if (input.polygons == 0) return {triangles.begin(), triangles.end()};
  std::vector<std::map<std::int32_t, double>> area(input.polygons);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c] = input.mesh.triangles[t];
    const Eigen::Vector3d& p = input.mesh.vertices[a];
    area[input.polygon[t]][triangles[t]] +=
        (input.mesh.vertices[b] - p).cross(input.mesh.vertices[c] - p).norm();
  }
  std::vector<std::int32_t> label(input.polygons, -1);
  for (std::size_t i = 0; i < label.size(); ++i) {
    double largest = -1.0;
    for (const auto& [one, size] : area[i]) {
      if (size <= largest) continue;
      largest = size;
      label[i] = one;
    }
  }
  return label;
}

std::vector<std::int32_t> LabelsOfTriangles(const geometry::PolygonMesh& input,
                                            std::span<const std::int32_t> polygons) {
  if (polygons.size() != input.polygons) {
    throw std::invalid_argument("LabelsOfTriangles: not one label a polygon");
  }
  std::vector<std::int32_t> label;
  for (const std::uint32_t i : input.polygon) label.push_back(polygons[i]);
  return label;
}

Segmentation AtLevel(const Segmentation& segmentation, int level) {
  if (segmentation.tree.empty()) return segmentation;
  // Of each node the one that stands for it.
  std::vector<std::size_t> top(segmentation.tree.size());
  std::vector<std::size_t> of_label(static_cast<std::size_t>(segmentation.parts));
  for (std::size_t k = 0; k < top.size(); ++k) {
    const PartNode& node = segmentation.tree[k];
    top[k] = node.level > level ? top[static_cast<std::size_t>(node.parent)] : k;
    if (node.label >= 0) of_label[static_cast<std::size_t>(node.label)] = top[k];
  }
  std::vector<std::size_t> size(top.size(), 0);
  for (const std::int32_t l : segmentation.label) ++size[of_label[static_cast<std::size_t>(l)]];
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < top.size(); ++k) {
    if (size[k] > 0) order.push_back(k);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
  Segmentation coarse = segmentation;
  coarse.tree.clear();
  coarse.parts = static_cast<int>(order.size());
  coarse.has_core = coarse.parts > 1;
  std::vector<std::int32_t> number(top.size(), -1);
  for (std::size_t k = 0; k < order.size(); ++k) number[order[k]] = static_cast<std::int32_t>(k);
  for (std::int32_t& l : coarse.label) l = number[of_label[static_cast<std::size_t>(l)]];
  // What is cut further has no label of its own any more.
  for (std::size_t k = 0; k < top.size(); ++k) {
    if (segmentation.tree[k].level > level) continue;
    coarse.tree.push_back(segmentation.tree[k]);
    coarse.tree.back().label = number[k];
  }
  return coarse;
}

std::array<std::uint8_t, 3> PartColor(std::int32_t label) {
  if (label < 0) return {128, 128, 128};
  if (label == 0) return {214, 32, 32};
  // Hues by the golden section, which fills the circle evenly however many there are, away from the
  // red of the core; every other round is darker or paler.
  constexpr double kGolden = 0.61803398874989485;
  constexpr double kSaturation[] = {0.85, 0.45, 0.90};
  constexpr double kValue[] = {0.95, 0.95, 0.55};
  const int k = label - 1;
  const double hue = 0.09 + 0.82 * std::fmod(0.62 + k * kGolden, 1.0);
  const int round = (k / 7) % 3;
  return FromHsv(hue, kSaturation[round], kValue[round]);
}

}  // namespace rangegrasp::parts
