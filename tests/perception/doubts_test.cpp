// Tests the reasons to doubt a scene, on scenes that are made by hand.
#include "perception/doubts.h"

#include <gmock/gmock.h>

namespace rangegrasp::perception {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const Cures kCuresForTest = {.smaller_unit = "smaller",
                             .larger_unit = "larger",
                             .upper_side = "side",
                             .other_things = "others"};

/// A scene of 100 points 2 mm apart with one object of 100 mm that has 20 of them. The table is
/// 0.5 m below the sensor.
Scene SceneToDoubt() {
  Scene scene;
  scene.points_C.resize(100, Eigen::Vector3d::Zero());
  scene.sampling.spacing_m = 0.002;
  scene.table.plane = {Eigen::Vector3d::UnitZ(), 0.5};
  scene.objects.resize(1);
  scene.objects[0].points.resize(20);
  scene.objects[0].size_m.setConstant(0.1);
  return scene;
}

std::vector<std::string> DoubtsOf(const Scene& scene, const std::string& of_origin = "") {
  return Doubts(scene, of_origin, kCuresForTest);
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

}  // namespace
}  // namespace rangegrasp::perception
