#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "parts/shape/segmentation.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// 1 - Rand index of two labellings of the same elements, unweighted (Chen et al. 2009): (sum_i
/// C(n_i, 2) + sum_j C(m_j, 2) - 2 sum_ij C(n_ij, 2)) / C(N, 2), where n_i, m_j and n_ij are the
/// sizes of the segments of a, of b and of their intersections. O(n log n).
double RandError(std::span<const std::int32_t> a, std::span<const std::int32_t> b);

/// The vertices and edges of a mesh, kept for comparing many labellings of its faces.
class CutMeasure {
 public:
  explicit CutMeasure(const Shape& mesh);

  /// Cut discrepancy (Chen et al. 2009). It takes the shortest distance along edges (straight if no
  /// edges lead there) from every vertex on a cut of one labelling to a cut of the other, in both
  /// directions. The mean over all those vertices is divided by the area-weighted mean distance of
  /// the surface from its centroid. nullopt if one of the two has no cut. O(n log n).
  std::optional<double> Discrepancy(std::span<const std::int32_t> a,
                                    std::span<const std::int32_t> b) const;

 private:
  Indices CutVertices(std::span<const std::int32_t> label) const;
  double SumOfDistances(const Indices& from, const Indices& to) const;

  Points points_;
  FaceGraph faces_;
  VertexGraph vertices_;
  double radius_ = 0.0;  ///< mean distance of the surface from its centroid
};

/// A model of a benchmark with the file layout of Chen et al. 2009: off/ID.off with any number of
/// human segmentations seg/ID/ID_K.seg.
struct HumanModel {
  geometry::PolygonMesh input;
  Shape shape;
  std::vector<Labels> humans;  ///< labels of the input's triangles
};

std::filesystem::path ModelFile(const std::filesystem::path& folder, int id);
/// Files of its human segmentations in ascending number; empty if their folder does not exist.
std::vector<std::filesystem::path> HumanFiles(const std::filesystem::path& folder, int id);

/// @throws base::InputError naming the file if the model or a segmentation cannot be read, if the
/// model is not a mesh, or if there is no segmentation.
HumanModel ReadHumanModel(const std::filesystem::path& folder, int id);

/// Mean number of segments over all human segmentations of some models, rounded, at least 1;
/// unreadable ones do not count.
int MeanHumanSegments(const std::filesystem::path& folder, std::span<const int> ids);

/// Distance of a segmentation from those of people; lower is better for both metrics.
struct HumanScore {
  double rand_error = 0.0;                ///< mean over the human segmentations
  std::optional<double> cut_discrepancy;  ///< mean over those where it is defined
};
HumanScore ScoreAgainstHumans(const HumanModel& model, const Segmentation& found);

}  // namespace rangegrasp::parts
