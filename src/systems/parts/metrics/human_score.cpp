#include "parts/metrics/human_score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "parts/metrics/rand_error.h"
#include "parts/shape/shape_file.h"

namespace rangegrasp::parts {
namespace {

using Labels = std::vector<std::int32_t>;

/// From labels of the input's faces to labels of the faces that were kept.
Labels OfShape(const Shape& shape, const Labels& of_input) {
  Labels labels(shape.Elements(), 0);
  for (std::size_t i = of_input.size(); i-- > 0;) {
    const std::int32_t element = shape.element_of_input[i];
    if (element >= 0) labels[static_cast<std::size_t>(element)] = of_input[i];
  }
  return labels;
}

}  // namespace

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
  // By length first, so that 9 stands before 10.
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
    const std::string x = a.filename().string(), y = b.filename().string();
    return x.size() != y.size() ? x.size() < y.size() : x < y;
  });
  return files;
}

HumanModel ReadHumanModel(const std::filesystem::path& folder, int id) {
  const auto file = ModelFile(folder, id);
  geometry::PolygonMesh input = ReadPolygons(file);
  Shape shape = MakeShape(input.mesh);
  if (!shape.IsMesh()) throw base::InputError(file.string() + ": has no faces; a mesh is needed");
  CutMeasure cuts(shape);
  HumanModel model{std::move(input), std::move(shape), std::move(cuts), {}, {}};
  for (const auto& human : HumanFiles(folder, id)) {
    model.humans.push_back(LabelsOfTriangles(model.input, ReadLabels(human, model.input.polygons)));
    model.humans_of_shape.push_back(OfShape(model.shape, model.humans.back()));
  }
  if (model.humans.empty()) {
    throw base::InputError(fmt::format("{}: holds no human segmentation {}_<k>.seg of the model",
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
        // The rows of that model tell it.
      }
    }
  }
  return files > 0 ? std::max(1, static_cast<int>(std::lround(sum / files))) : 1;
}

HumanScore ScoreAgainstHumans(const HumanModel& model, const Segmentation& found) {
  const Labels labels = LabelsOfInput(model.shape, model.input.mesh, found);
  HumanScore score;
  double discrepancy = 0.0;
  int defined = 0;
  for (std::size_t h = 0; h < model.humans.size(); ++h) {
    score.rand_error += RandError(labels, model.humans[h]);
    const auto one = model.cuts.Discrepancy(found.label, model.humans_of_shape[h]);
    discrepancy += one.value_or(0.0);
    defined += one ? 1 : 0;
  }
  score.rand_error /= static_cast<double>(model.humans.size());
  if (defined > 0) score.cut_discrepancy = discrepancy / defined;
  return score;
}

}  // namespace rangegrasp::parts
