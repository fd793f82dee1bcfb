#include "parts/shape/segmentation.h"

#include <algorithm>
#include <cmath>
#include <functional>
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

/// Hue in turns: red, then green, then blue.
std::array<std::uint8_t, 3> FromHsv(double hue, double saturation, double value) {
  std::array<std::uint8_t, 3> color{};
  for (int i = 0; i < 3; ++i) {
    const double turn = 6.0 * std::fmod(hue + (i == 0 ? 0.0 : (3.0 - i) / 3.0), 1.0);
    const double ramp = std::clamp(std::abs(turn - 3.0) - 1.0, 0.0, 1.0);
    color[i] =
        static_cast<std::uint8_t>(std::lround(255.0 * value * (1.0 - saturation * (1.0 - ramp))));
  }
  return color;
}

}  // namespace

Labels LabelsOfNearest(const Points& points, const Points& labelled, const Labels& labels) {
  const geometry::KdTree tree(labelled);
  std::vector<geometry::KdTree::Neighbor> nearest;
  Labels found;
  for (const Eigen::Vector3d& p : points) {
    tree.Nearest(p, 1, nearest);
    found.push_back(labels[nearest.front().index]);
  }
  return found;
}

void LabelByNearest(const Points& points, const Indices& kept, const Indices& others,
                    Labels& label) {
  if (kept.empty() || others.empty()) return;
  const Labels found = LabelsOfNearest(geometry::Select(points, others),
                                       geometry::Select(points, kept), ValuesAt(label, kept));
  for (std::size_t k = 0; k < others.size(); ++k) label[others[k]] = found[k];
}

Labels LabelsOfInput(const Shape& shape, const TriangleMesh& input,
                     const Segmentation& segmentation) {
  Labels label;
  Points centers;
  Indices kept, others;
  for (std::uint32_t i = 0; i < shape.element_of_input.size(); ++i) {
    const std::int32_t element = shape.element_of_input[i];
    label.push_back(element < 0 ? -1 : segmentation.label[element]);
    centers.push_back(Center(input, i));
    if (element >= 0) kept.push_back(i);
    if (element < 0 && IsUsable(centers[i])) others.push_back(i);
  }
  LabelByNearest(centers, kept, others, label);
  return label;
}

Labels LargestLabels(std::size_t count, const Indices& group, std::span<const std::int32_t> labels,
                     const std::vector<double>& weights) {
  std::vector<std::map<std::int32_t, double>> sums(count);
  for (std::size_t i = 0; i < labels.size(); ++i) sums[group[i]][labels[i]] += weights[i];
  Labels result(count, -1);
  for (std::size_t k = 0; k < count; ++k) {
    double largest = -1.0;
    for (const auto& [label, sum] : sums[k]) {
      if (sum <= largest) continue;
      largest = sum;
      result[k] = label;
    }
  }
  return result;
}

Labels LabelsOfPolygons(const geometry::PolygonMesh& input,
                        std::span<const std::int32_t> triangles) {
  if (input.polygons == 0) return {triangles.begin(), triangles.end()};
  std::vector<double> areas;
  for (const auto& [a, b, c] : input.mesh.triangles) {
    const Eigen::Vector3d& p = input.mesh.vertices[a];
    areas.push_back((input.mesh.vertices[b] - p).cross(input.mesh.vertices[c] - p).norm());
  }
  return LargestLabels(input.polygons, input.polygon, triangles, areas);
}

Labels RankLabels(Indices labels, const std::vector<double>& weight) {
  std::ranges::stable_sort(labels, std::greater<>(), [&](std::uint32_t l) { return weight[l]; });
  Labels number(weight.size(), -1);
  for (std::size_t k = 0; k < labels.size(); ++k) number[labels[k]] = static_cast<std::int32_t>(k);
  return number;
}

std::array<std::uint8_t, 3> PartColor(std::int32_t label) {
  if (label < 0) return {128, 128, 128};
  if (label == 0) return {214, 32, 32};
  // Hues by the golden section, which fills the color circle evenly for any number, away from the
  // red of the core. Every other round is darker or paler.
  constexpr double kGolden = 0.61803398874989485;
  constexpr double kSaturation[] = {0.85, 0.45, 0.90};
  constexpr double kValue[] = {0.95, 0.95, 0.55};
  const int k = label - 1;
  const double hue = 0.09 + 0.82 * std::fmod(0.62 + k * kGolden, 1.0);
  const int round = (k / 7) % 3;
  return FromHsv(hue, kSaturation[round], kValue[round]);
}

}  // namespace rangegrasp::parts
