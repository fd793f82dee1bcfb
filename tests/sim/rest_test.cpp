#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "sim/resting_poses.h"
#include "sim/scene_files.h"
#include "sim/world.h"

namespace rangegrasp::sim {
namespace {

class EveryObject : public ::testing::TestWithParam<const char*> {};

// An object placed 1 mm above the table keeps each pose: the upward axis turns by less than 3
// degrees (a mug's handle and round flanks settle a little), and the height stays.
TEST_P(EveryObject, StaysInItsRestingPoses) {
  const ObjectModel object = samples::RepositoryObject(GetParam());
  const auto poses = StableRestingPoses(object);
  ASSERT_FALSE(poses.empty());
  double total = 0.0;
  World world(samples::Tabletop(), {object}, {});
  for (const RestingPose& pose : poses) {
    total += pose.probability;
    const RestingFace& face = pose.faces.front();
    const Eigen::Matrix3d R = face.R_WO.toRotationMatrix();
    world.PlaceObject(0, base::MakePose(R, {0, 0, face.height_m + 0.001}));
    EXPECT_TRUE(world.Settle()) << pose.label;
    const base::Pose X = world.ObjectPose(0);
    const Eigen::Vector3d up_O = R.transpose() * Eigen::Vector3d::UnitZ();
    EXPECT_GT((X.linear() * up_O).z(), std::cos(base::Deg(3.0))) << pose.label;
    EXPECT_NEAR(X.translation().z(), face.height_m, 0.002) << pose.label;
  }
  EXPECT_NEAR(total, 1.0, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Objects, EveryObject,
                         ::testing::Values("salt_cylinder", "sweets_cylinder", "spread",
                                           "sweets_half_cylinder", "melba_toast", "dextrose",
                                           "salt_cuboid", "sweets_pentagon", "coffee_cup",
                                           "shower_gel", "cleaner", "sweets_prism"),
                         [](const auto& tested) { return std::string(tested.param); });

}  // namespace
}  // namespace rangegrasp::sim
