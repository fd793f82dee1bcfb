#include "robot/mjcf/hand_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "robot/mjcf/example_hands.h"

namespace rangegrasp::mjcf {
namespace {

using samples::LoadHand;
using ::testing::HasSubstr;

TEST(HandFile, ADriveHasAnOpenAndAClosedEnd) {
  const auto model = LoadHand("parallel_jaw");
  const auto motors = HandMotors(model.get());
  ASSERT_EQ(motors.size(), 1u);
  EXPECT_EQ(motors[0].open, 0.05);
  EXPECT_EQ(motors[0].closed, 0.0);
  EXPECT_TRUE(HasMotors(model.get()));
  EXPECT_FALSE(HasMotors(LoadHand("sensorhand").get()));
}

TEST(HandFile, TheFirstFingertipIsTheThumbs) {
  const auto model = LoadHand("three_fingers");
  const LastSegments last = LastSegmentsOf(model.get());
  ASSERT_EQ(last.thumb.size(), 1u);
  ASSERT_EQ(last.fingers.size(), 2u);
  EXPECT_EQ(std::string(mj_id2name(model.get(), mjOBJ_GEOM, last.thumb[0])), "thumb_2");
}

// Of the geared hand, whose thumb hangs on the first of its joints, the segments nearer to the palm
// are none of the last.
TEST(HandFile, LastSegmentsHaveNoFingertipsFurtherOut) {
  const auto model = LoadHand("sensorhand");
  const LastSegments last = LastSegmentsOf(model.get());
  std::vector<std::string> names;
  for (const int g : last.fingers) names.emplace_back(mj_id2name(model.get(), mjOBJ_GEOM, g));
  EXPECT_THAT(names, ::testing::ElementsAre("index_3", "middle_3"));
}

TEST(HandFile, SaysThatAValueIsMissing) {
  auto model = LoadHand("three_fingers");
  const int id = mj_name2id(model.get(), mjOBJ_NUMERIC, "hand_closed");
  model->numeric_size[id] = 2;
  try {
    HandMotors(model.get());
    FAIL();
  } catch (const base::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("\"hand_closed\" must hold one value for each of the 3"));
  }
}

// The lengths that the engine keeps are those of the last kinematics.
TEST(HandFile, ADrivesLengthIsThatOfTheJointsAsTheyAre) {
  const auto model = LoadHand("sensorhand");
  const samples::DataPtr data(mj_makeData(model.get()), mj_deleteData);
  const int thumb = mj_name2id(model.get(), mjOBJ_JOINT, "thumb");
  const int fingers = mj_name2id(model.get(), mjOBJ_JOINT, "fingers");
  data->qpos[model->jnt_qposadr[thumb]] = 0.2;
  data->qpos[model->jnt_qposadr[fingers]] = 0.4;
  EXPECT_DOUBLE_EQ(DriveLength(model.get(), data.get(), 0), 0.3);
}

}  // namespace
}  // namespace rangegrasp::mjcf
