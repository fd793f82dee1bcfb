// Labelled clouds of a depth camera, where they are at hand: data/kinect in the folder that
// RANGEGRASP_SHARED names, or in ../shared beside the project.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "labelled_cloud.h"
#include "pcl_bridge/local_convexity.h"
#include "separation_score.h"

namespace rangegrasp::pcl_bridge {
namespace {

TEST(Kinect, LocalConvexityFindsTheObjectsOfATable) {
  if (!std::filesystem::exists(labelled::KinectFolder())) {
    GTEST_SKIP() << "no labelled clouds in " << labelled::KinectFolder();
  }
  double sum = 0.0;
  const std::vector<int> numbers = {2, 20, 40};  // boxes, a stack, cylinders
  for (const int number : numbers) {
    const auto [file, label] = labelled::ReadKinect(number);
    // Spacing and noise of a depth camera: voxels of 7.5 mm at 1 m, seeds of 30 mm.
    const LocalConvexityOptions options{.voxel_m = 0.0075, .seed_m = 0.03, .camera_depth = true};
    const LocalConvexity found = SegmentByLocalConvexity(Cloud(file.points), options);
    const double overlap = labelled::Compare(label, found.segment).overlap;
    RecordProperty("weighted_overlap_" + std::to_string(number), std::to_string(overlap));
    EXPECT_GT(overlap, 0.85) << "learn" << number;
    sum += overlap;
  }
  // Measured: 0.993, 0.956 and 0.941, with 3, 3 and 5 segments. A tenth is left for other versions.
  EXPECT_GT(sum / static_cast<double>(numbers.size()), 0.9);
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
