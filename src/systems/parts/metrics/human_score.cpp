#include "parts/metrics/human_score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/error.h"
#include "geometry/graph.h"
#include "geometry/kd_tree.h"
#include "parts/shape/shape_file.h"

namespace rangegrasp::parts {
namespace {

double Pairs(std::ptrdiff_t n) {
  return 0.5 * static_cast<double>(n) * (static_cast<double>(n) - 1.0);
}

/// The sum of C(n, 2) over the groups of equal values.
template <class T>
double PairsInGroups(std::vector<T> values) {
  std::sort(values.begin(), values.end());
  double sum = 0.0;
  for (auto first = values.begin(); first != values.end();) {
    const auto last = std::upper_bound(first, values.end(), *first);
    sum += Pairs(last - first);
    first = last;
  }
  return sum;
}

double MeanDistanceToCentroid(const Shape& mesh) {
  const FaceFrames frames = BuildFaceFrames(mesh);
  const auto centroid = GroupFrames(frames, Labels(frames.area.size(), 0), 1).center.front();
  double sum = 0.0;
  for (std::size_t f = 0; f < frames.area.size(); ++f) {
    sum += frames.area[f] * (frames.center[f] - centroid).norm();
  }
  return sum / frames.total_area;
}

/// Labels of the faces that were kept from labels of the input's faces.
Labels OfShape(const Shape& shape, const Labels& of_input) {
  Labels labels(shape.Elements(), 0);
  for (std::size_t i = of_input.size(); i-- > 0;) {
    const std::int32_t element = shape.element_of_input[i];
    if (element >= 0) labels[element] = of_input[i];
  }
  return labels;
}

}  // namespace

double RandError(std::span<const std::int32_t> a, std::span<const std::int32_t> b) {
  std::vector<std::pair<std::int32_t, std::int32_t>> both;
  both.reserve(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) both.emplace_back(a[i], b[i]);
  return (PairsInGroups(std::vector(a.begin(), a.end())) +
          PairsInGroups(std::vector(b.begin(), b.end())) - 2.0 * PairsInGroups(std::move(both))) /
         Pairs(std::ssize(a));
}

CutMeasure::CutMeasure(const Shape& mesh)
    : points_(mesh.points),
      faces_(BuildFaceGraph(mesh)),
      vertices_(BuildVertexGraph(mesh)),
      radius_(MeanDistanceToCentroid(mesh)) {}

Indices CutMeasure::CutVertices(std::span<const std::int32_t> label) const {
  std::vector<bool> on_cut(points_.size(), false);
  ForEachLink(faces_, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    if (label[g] == label[f]) return;
    for (const std::uint32_t v : faces_.edge[k]) on_cut[v] = true;
  });
  return geometry::PositionsOf(on_cut);
}

double CutMeasure::SumOfDistances(const Indices& from, const Indices& to) const {
  const std::vector<double> distance = geometry::DistancesFrom(to, vertices_.Links());
  Points targets;
  std::optional<geometry::KdTree> tree;
  std::vector<geometry::KdTree::Neighbor> nearest;
  double sum = 0.0;
  for (const std::uint32_t v : from) {
    if (distance[v] < geometry::kFar) {
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
  const Indices cut_a = CutVertices(a);
  const Indices cut_b = CutVertices(b);
  if (cut_a.empty() || cut_b.empty()) return std::nullopt;
  const double sum = SumOfDistances(cut_a, cut_b) + SumOfDistances(cut_b, cut_a);
  return sum / static_cast<double>(cut_a.size() + cut_b.size()) / radius_;
}

std::filesystem::path ModelFile(const std::filesystem::path& folder, int id) {
  return folder / "off" / fmt::format("{}.off", id);
}

std::vector<std::filesystem::path> HumanFiles(const std::filesystem::path& folder, int id) {
  const std::string name = fmt::format("{}", id);
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "seg" / name, error)) {
    const std::string file = entry.path().filename().string();
    if (file.starts_with(name + "_") && file.ends_with(".seg")) files.push_back(entry.path());
  }
  // By length first, so that 9 comes before 10.
  std::ranges::sort(files, {}, [](const std::filesystem::path& file) {
    return std::pair(file.filename().string().size(), file.filename().string());
  });
  return files;
}

HumanModel ReadHumanModel(const std::filesystem::path& folder, int id) {
  const auto file = ModelFile(folder, id);
  geometry::PolygonMesh input = ReadPolygons(file);
  Shape shape = ShapeOf(input, file);
  if (!shape.IsMesh()) throw base::InputError(file.string() + ": has no faces; a mesh is needed");
  HumanModel model{std::move(input), std::move(shape), {}};
  for (const auto& human : HumanFiles(folder, id)) {
    model.humans.push_back(ValuesAt(ReadLabels(human, model.input.polygons), model.input.polygon));
  }
  if (model.humans.empty()) {
    throw base::InputError(fmt::format("{}: contains no human segmentation {}_<k>.seg of the model",
                                       (folder / "seg" / fmt::format("{}", id)).string(), id));
  }
  return model;
}

int MeanHumanSegments(const std::filesystem::path& folder, std::span<const int> ids) {
  double sum = 0.0;
  int files = 0;
  for (const int id : ids) {
    for (const auto& file : HumanFiles(folder, id)) {
      try {
        const Labels labels = ReadLabels(file);
        sum += static_cast<double>(std::set(labels.begin(), labels.end()).size());
        ++files;
      } catch (const base::InputError&) {
        // The rows of that model report the error.
      }
    }
  }
  return files > 0 ? std::max(1, static_cast<int>(std::lround(sum / files))) : 1;
}

HumanScore ScoreAgainstHumans(const HumanModel& model, const Segmentation& found) {
  const Labels labels = LabelsOfInput(model.shape, model.input.mesh, found);
  const CutMeasure cuts(model.shape);
  HumanScore score;
  double discrepancy = 0.0;
  int defined = 0;
  for (const Labels& human : model.humans) {
    score.rand_error += RandError(labels, human);
    const auto one = cuts.Discrepancy(found.label, OfShape(model.shape, human));
    discrepancy += one.value_or(0.0);
    defined += one ? 1 : 0;
  }
  score.rand_error /= static_cast<double>(model.humans.size());
  if (defined > 0) score.cut_discrepancy = discrepancy / defined;
  return score;
}

}  // namespace rangegrasp::parts
