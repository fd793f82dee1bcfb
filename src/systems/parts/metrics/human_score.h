#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "parts/metrics/cut_discrepancy.h"
#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// A model of a benchmark laid out as Chen et al. 2009: off/ID.off with any number of human
/// segmentations seg/ID/ID_K.seg.
struct HumanModel {
  geometry::PolygonMesh input;
  Shape shape;
  CutMeasure cuts;
  std::vector<std::vector<std::int32_t>> humans;           ///< labels of the input's triangles
  std::vector<std::vector<std::int32_t>> humans_of_shape;  ///< of the shape's faces
};

/// Where a model stands.
std::filesystem::path ModelFile(const std::filesystem::path& folder, int id);
/// Its human segmentations, in the order of their numbers; none where there is no folder of them.
std::vector<std::filesystem::path> HumanFiles(const std::filesystem::path& folder, int id);

/// @throws base::InputError naming the file if the model or a segmentation cannot be read, if it is
/// no mesh, or if there is no segmentation.
HumanModel ReadHumanModel(const std::filesystem::path& folder, int id);

/// The mean number of segments of all human segmentations of some models, rounded, at least 1;
/// those that cannot be read do not count.
int MeanHumanSegments(const std::filesystem::path& folder, std::span<const int> ids);

/// How far a segmentation is from those of people; lower is better in both.
struct HumanScore {
  double rand_error = 0.0;                ///< mean over the humans
  std::optional<double> cut_discrepancy;  ///< mean over those where it is defined
};
HumanScore ScoreAgainstHumans(const HumanModel& model, const Segmentation& found);

}  // namespace rangegrasp::parts
