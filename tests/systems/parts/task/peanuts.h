#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "experiment/task.h"
#include "parts/shape/shape_file.h"
#include "parts/solids.h"
#include "parts/task/parts_task.h"
#include "temp_folder.h"

namespace rangegrasp::testing_support {

inline std::string OffOf(const parts::Shape& shape) {
  std::string text = fmt::format("OFF\n{} {} 0\n", shape.points.size(), shape.faces.size());
  for (const auto& p : shape.points) text += fmt::format("{:f} {:f} {:f}\n", p.x(), p.y(), p.z());
  for (const auto& [a, b, c] : shape.faces) text += fmt::format("3 {} {} {}\n", a, b, c);
  return text;
}

/// A small benchmark of peanuts, with the folder layout of the real one. Each model has two human
/// segmentations: halves, and halves with a stripe between them.
class Peanuts {
 public:
  Peanuts() {
    for (const int id : {1, 2, 3, 11}) AddModel(id);
  }

  std::unique_ptr<experiment::Task> Read(const std::string& text) const {
    experiment::Common common;
    common.file = folder / "parts.yaml";
    auto map = base::YamlMap::FromText(text, common.file);
    return parts::PartsTask().read(map, common);
  }

  static constexpr const char* kGood =
      "data: .\nmethods: [kmeans, sdf]\nclasses: [peanut, other]\nmodels:\n"
      "  peanut: {tune: [1], report: [2, 3]}\n  other: {report: [11]}\n";
  TempFolder folder;

 private:
  void AddModel(int id) {
    const parts::Shape shape = parts::samples::Ball(
        6, [&](const Eigen::Vector3d& p) { return 0.6 + (1.0 + 0.1 * id) * p.x() * p.x(); });
    std::vector<std::int32_t> halves, stripe;
    for (const auto& [a, b, c] : shape.faces) {
      const double x = (shape.points[a] + shape.points[b] + shape.points[c]).x();
      halves.push_back(x < 0.0 ? 0 : 1);
      stripe.push_back(x < -0.6 ? 0 : x < 0.6 ? 1 : 2);
    }
    folder.Write(fmt::format("off/{}.off", id), OffOf(shape));
    folder.Write(fmt::format("seg/{}/.keep", id), "");
    parts::WriteLabels(folder / fmt::format("seg/{}/{}_0.seg", id, id), halves);
    parts::WriteLabels(folder / fmt::format("seg/{}/{}_10.seg", id, id), stripe);
  }
};

}  // namespace rangegrasp::testing_support
