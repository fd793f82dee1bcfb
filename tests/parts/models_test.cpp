// Models of the benchmark by Chen et al. (2009), where they are at hand.

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "parts/hierarchy/hierarchy.h"
#include "parts/metrics/cut_discrepancy.h"
#include "parts/metrics/rand_error.h"
#include "parts/mirror/inside.h"
#include "parts/mirror/mirroring.h"
#include "parts/mirror/spherical_mirror.h"
#include "parts/shape/segmentation.h"
#include "parts/shape/shape_file.h"
#include "parts/solids.h"
#include "parts/stretched/pose_invariant.h"

namespace rangegrasp::parts {
namespace {

const std::filesystem::path kData =
    std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "../shared/data/psb";

// Four legs or two arms and two legs, the head, and a tail; that of 381 lies at a hind leg and 382
// has none. Of the head of 283 only a piece comes off.
TEST(PoseInvariant, LimbsOfFourLeggedAndArmadilloModelsComeApart) {
  if (!std::filesystem::exists(kData)) GTEST_SKIP() << "no benchmark models in " << kData;
  for (const int id : {281, 282, 283, 284, 381, 382, 383, 384}) {
    const Shape shape = ReadShape(kData / "off" / (std::to_string(id) + ".off"));
    const int limbs = SegmentPoseInvariant(shape, {}).parts - 1;
    if (id == 283) {
      EXPECT_GE(limbs, 6) << id;
    } else {
      EXPECT_EQ(limbs, id == 381 || id == 382 ? 5 : 6) << id;
    }
  }
}

// Of the half that no option was set by.
TEST(Hierarchy, IsNearThePeopleOnTheBenchmark) {
  if (!std::filesystem::exists(kData)) GTEST_SKIP() << "no benchmark models in " << kData;
  double sum = 0.0;
  const std::vector<int> ids = {164, 243, 344};
  for (const int id : ids) {
    const std::string name = std::to_string(id);
    const Shape shape = ReadShape(kData / "off" / (name + ".off"));
    const std::vector<std::int32_t> human =
        ReadLabels(kData / "seg" / name / (name + "_0.seg"), shape.faces.size());
    sum += RandError(SegmentHierarchy(shape, {}).label, human);
  }
  EXPECT_LT(sum / static_cast<double>(ids.size()), 0.1);
}

}  // namespace
}  // namespace rangegrasp::parts
