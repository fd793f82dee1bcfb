#include "parts/hierarchy/internal/patches.h"

#include <Eigen/Core>
#include <cmath>

#include "geometry/union_find.h"

namespace rangegrasp::parts {

Patches CutByGrid(const FaceGraph& faces, const FaceFrames& frames, double side) {
  const auto count = static_cast<std::uint32_t>(frames.area.size());
  std::vector<Eigen::Vector3i> cube(count);
  for (std::uint32_t f = 0; f < count; ++f) {
    cube[f] = (frames.center[f] / side).array().floor().cast<int>();
  }
  geometry::UnionFind sets(count);
  for (std::uint32_t f = 0; f < count; ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      if (faces.neighbor[k] > f && cube[faces.neighbor[k]] == cube[f]) {
        sets.Unite(f, faces.neighbor[k]);
      }
    }
  }
  Patches patches;
  std::vector<std::int32_t> number(count, -1);
  patches.of_face.reserve(count);
  for (std::uint32_t f = 0; f < count; ++f) {
    std::int32_t& own = number[sets.Find(f)];
    if (own < 0) {
      own = static_cast<std::int32_t>(patches.size());
      patches.area.push_back(0.0);
      patches.center.emplace_back(Eigen::Vector3d::Zero());
      patches.normal.emplace_back(Eigen::Vector3d::Zero());
    }
    const auto p = static_cast<std::size_t>(own);
    patches.of_face.push_back(own);
    patches.area[p] += frames.area[f];
    patches.center[p] += frames.area[f] * frames.center[f];
    patches.normal[p] += frames.area[f] * frames.normal[f];
  }
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (patches.area[p] > 0.0) patches.center[p] /= patches.area[p];
    patches.normal[p].normalize();
  }
  return patches;
}

}  // namespace rangegrasp::parts
