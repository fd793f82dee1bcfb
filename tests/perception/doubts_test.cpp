// Tests the reasons to doubt a scene, on scenes that are made by hand.
#include "perception/doubts.h"

#include <gmock/gmock.h>

#include <array>

#include "base/error.h"

namespace rangegrasp::perception {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const Cures kCuresForTest = {.smaller_unit = "smaller",
                             .larger_unit = "larger",
                             .sensor = "sensor",
                             .upper_side = "side",
                             .other_things = "others",
                             .noise = "noise"};

/// A scene of 100 points 2 mm apart with 0.3 mm noise and one object of 100 mm that has 20 of them.
/// The table is 0.5 m below 0,0,0.
Scene SceneToDoubt() {
  Scene scene;
  scene.points_C.resize(100, Eigen::Vector3d::Zero());
  scene.sampling.spacing_m = 0.002;
  scene.sampling.noise_m = 0.0003;
  scene.table.plane = {Eigen::Vector3d::UnitZ(), 0.5};
  scene.objects.resize(1);
  scene.objects[0].points.resize(20);
  scene.objects[0].size_m.setConstant(0.1);
  return scene;
}

/// A sensor whose position is known is 1 m above 0,0,0.
std::vector<std::string> DoubtsOf(const Scene& scene, const std::string& of_origin = "") {
  const Eigen::Vector3d sensor_C(0.0, 0.0, of_origin.empty() ? 1.0 : 0.0);
  return Doubts(scene, sensor_C, of_origin, /*noise_is_given=*/false, kCuresForTest);
}

TEST(Doubts, AreNoneOfAnObjectOnATable) { EXPECT_THAT(DoubtsOf(SceneToDoubt()), IsEmpty()); }

TEST(Doubts, NameTheUnitAndThenJudgeNoSizes) {
  Scene scene = SceneToDoubt();
  scene.objects[0].size_m.setConstant(100.0);
  scene.sampling.spacing_m = 2.0;
  EXPECT_THAT(DoubtsOf(scene), ElementsAre("the points are 2.0 m apart: smaller"));
  scene.sampling.spacing_m = 2e-6;
  EXPECT_THAT(DoubtsOf(scene), ElementsAre("the points are 0.0020 mm apart: larger"));
}

TEST(Doubts, ComeWithTheCallersCures) {
  Scene scene = SceneToDoubt();
  scene.objects[0].size_m.x() = 0.7;
  scene.objects[0].points.resize(40);
  EXPECT_THAT(
      DoubtsOf(scene),
      ElementsAre("object 1 is 0.70 m long: too large for a hand or a table; others",
                  "object 1 has 40 % of all points: too many for an object on a table; others"));
  scene.objects.clear();
  EXPECT_THAT(DoubtsOf(scene), ElementsAre("no objects: 0 of 100 points are above the table"));
}

TEST(Doubts, NameAnAssumedOriginAndWhetherItLiesInTheTable) {
  Scene scene = SceneToDoubt();
  EXPECT_THAT(DoubtsOf(scene, "assumed"), ElementsAre("assumed"));
  scene.table.plane.offset_m = 0.01;
  EXPECT_THAT(DoubtsOf(scene), IsEmpty());
  EXPECT_THAT(DoubtsOf(scene, "assumed"),
              ElementsAre("assumed",
                          "0,0,0 lies in the table's plane, so its upper side is not known: side"));
}

TEST(Doubts, NameAKnownSensorThatLiesInTheTable) {
  Scene scene = SceneToDoubt();
  scene.table.plane.offset_m = -0.99;
  EXPECT_THAT(DoubtsOf(scene),
              ElementsAre("0,0,1 lies in the table's plane, so its upper side is not known: side"));
}

TEST(Doubts, NameASensorTooFarAwayUnlessTheUnitIsInDoubt) {
  Scene scene = SceneToDoubt();
  const auto doubts_from = [&](double height_m) {
    return Doubts(scene, {0.0, 0.0, height_m}, "", /*noise_is_given=*/false, kCuresForTest);
  };
  EXPECT_THAT(doubts_from(15.0), IsEmpty());
  EXPECT_THAT(doubts_from(900.0), ElementsAre("the sensor is 900 m from the cloud: sensor"));
  scene.sampling.spacing_m = 2.0;
  EXPECT_THAT(doubts_from(900.0), ElementsAre("the points are 2.0 m apart: smaller"));
}

TEST(Doubts, NameASensorBelowTheTable) {
  Scene scene = SceneToDoubt();
  scene.table.plane.offset_m = -1.5;
  EXPECT_THAT(DoubtsOf(scene),
              ElementsAre("the sensor at 0,0,1 lies 0.50 m below the table: side"));
}

TEST(Doubts, NameATableFlatterThanAnySensorMeasuresUnlessTheNoiseIsGiven) {
  Scene scene = SceneToDoubt();
  scene.sampling.noise_m = 1e-7;
  EXPECT_THAT(DoubtsOf(scene), ElementsAre("the table is exactly flat (computed?): its noise says "
                                           "nothing about the objects; noise"));
  EXPECT_THAT(Doubts(scene, Eigen::Vector3d::UnitZ(), "", /*noise_is_given=*/true, kCuresForTest),
              IsEmpty());
  scene.sampling = {};  // too few points to measure
  EXPECT_THAT(DoubtsOf(scene), IsEmpty());
}

TEST(LeaveOutUnmeasured, PointsAtZeroAtTheSensorAndAllButOneOfManyInOnePlace) {
  const Eigen::Vector3d sensor_C(0.0, 0.0, 1.0), crowded(0.1, 0.2, 0.3), pair(0.3, 0.2, 0.1);
  geometry::Points points_C(30, Eigen::Vector3d::Zero());
  points_C.push_back(sensor_C);
  points_C.insert(points_C.end(), 65, crowded);
  points_C.insert(points_C.end(), 2, pair);
  EXPECT_THAT(LeaveOutUnmeasured(sensor_C, points_C),
              ElementsAre("30 points at 0,0,0 are left out as not measured",
                          "1 point at 0,0,1 is left out as not measured",
                          "64 points are left out: each has exactly the coordinates of another"));
  EXPECT_EQ(points_C.size(), 30u + 1u + 65u + 2u);
  std::erase_if(points_C, [](const Eigen::Vector3d& p) { return !p.allFinite(); });
  EXPECT_THAT(points_C, ElementsAre(crowded, pair, pair));
  EXPECT_THAT(LeaveOutUnmeasured(sensor_C, points_C), IsEmpty());
}

TEST(Crop, KeepsWhatIsInTheBoxOfAnyCloud) {
  const Eigen::Vector3d inside(0.1, 0.2, 0.3), corner(0.0, 0.0, 0.0), outside(0.1, 0.2, 1.1);
  geometry::Points one{outside, inside}, other{corner};
  const std::vector<double> corners_m{0.0, 0.0, 0.0, 0.5, 0.5, 1.0};
  Crop(corners_m, {.name = "crop", .unit = "unit"}, std::array{&one, &other});
  EXPECT_TRUE(one[0].array().isNaN().all());
  EXPECT_EQ(one[1], inside);
  EXPECT_THAT(other, ElementsAre(corner));
}

TEST(Crop, NamesWhatIsWrong) {
  const auto error = [](const std::vector<double>& corners_m) {
    geometry::Points points{{0.1, 0.2, 0.3}};
    try {
      Crop(corners_m, {.name = "crop", .unit = "unit"}, std::array{&points});
    } catch (const base::InputError& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(error({1, 2, 3}), testing::StartsWith("crop must be six numbers"));
  EXPECT_EQ(error({1, 0, 0, 0, 1, 1}),
            "crop: the first three numbers must be below the last three");
  EXPECT_EQ(error({1, 1, 1, 2, 2, 2}),
            "crop: the box contains none of the 1 points, which are from 0.1,0.2,0.3 to "
            "0.1,0.2,0.3 m (unit)");
}

}  // namespace
}  // namespace rangegrasp::perception
