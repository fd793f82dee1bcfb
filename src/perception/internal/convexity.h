#pragma once

#include <cstdint>
#include <vector>

#include "geometry/union_find.h"
#include "perception/internal/patches.h"

namespace rangegrasp::perception::internal {

/// The border of two patches.
struct Border {
  std::uint32_t a = 0;  ///< < b, positions of patches
  std::uint32_t b = 0;
  std::uint32_t links = 0;                           ///< how many cross it: its length
  Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< mean of the links from a to b [m]
};

/// All borders, ascending by (a, b).
std::vector<Border> FindBorders(const geometry::PointCloud& cloud, const Links& links,
                                const Patches& patches);

/// How much a border speaks for its patches being of one body, -1 .. 1: see SegmentByConvexity.
double Togetherness(const Patch& a, const Patch& b, const Border& border,
                    const ConvexityOptions& options);

/// Bodies that are smaller than the options' specks, or slivers along their borders, join the
/// neighbor that they share the longest border with, the smallest first.
void JoinSpecks(const Links& links, const Patches& patches, const ConvexityOptions& options,
                geometry::UnionFind& bodies);

}  // namespace rangegrasp::perception::internal
