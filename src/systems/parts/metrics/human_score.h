#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "parts/shape/segmentation.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// 1 - Rand index of two labellings of the same elements, unweighted (Chen et al. 2009):
/// (sum_i C(n_i, 2) + sum_j C(m_j, 2) - 2 sum_ij C(n_ij, 2)) / C(N, 2) with the sizes of the
/// segments of one, of the other, and of their intersections. O(n log n).
/// @throws std::invalid_argument if the lengths differ or are below 2.
double RandError(std::span<const std::int32_t> a, std::span<const std::int32_t> b);

/// The vertices and edges of a mesh, kept to compare many labellings of its faces.
class CutMeasure {
 public:
  explicit CutMeasure(const Shape& mesh);

  /// Cut discrepancy (Chen et al. 2009): for every vertex on a cut of one labelling the shortest
  /// distance along edges to a cut of the other (straight, where no edges lead there), both ways,
  /// averaged over all those vertices, divided by the area-weighted mean distance of the surface to
  /// its centroid. nullopt where one of the two has no cut. O(n log n).
  /// @throws std::invalid_argument if a length is not the number of faces.
  std::optional<double> Discrepancy(std::span<const std::int32_t> a,
                                    std::span<const std::int32_t> b) const;

 private:
  Indices CutVertices(std::span<const std::int32_t> label) const;
  double SumOfDistances(const Indices& from, const Indices& to) const;

  Points points_;
  FaceGraph faces_;
  VertexGraph vertices_;
  double radius_ = 0.0;  ///< mean distance of the surface to its centroid
};

/// A model of a benchmark laid out as Chen et al. 2009: off/ID.off with any number of human
/// segmentations seg/ID/ID_K.seg.
struct HumanModel {
  geometry::PolygonMesh input;
  Shape shape;
  CutMeasure cuts;
  std::vector<Labels> humans;           ///< labels of the input's triangles
  std::vector<Labels> humans_of_shape;  ///< of the shape's faces
};

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
