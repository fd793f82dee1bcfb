#include "cylinders/task/demo_detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "cylinders/task/tabletop_scan.h"
#include "error_of.h"
#include "experiment/experiment.h"

namespace rangegrasp::cylinders {
namespace {

using testing::HasSubstr;

experiment::Experiment OpenDemo(const std::vector<std::string>& set) {
  return experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/cylinder_demo.yaml",
                                    {.set = set});
}

std::string ErrorOf(const std::vector<std::string>& set) {
  return testing_support::ErrorOf([&] { OpenDemo(set); });
}

TEST(DemoOptions, TheCylindersAreWantedInTurn) {
  const auto experiment = OpenDemo({"runs=5"});
  ASSERT_EQ(experiment.cases.size(), 5u);
  EXPECT_EQ(experiment.cases[0].group, "demo_tube");
  EXPECT_EQ(experiment.cases[1].group, "demo_can");
  EXPECT_EQ(experiment.cases[4].group, "demo_tube");
}

TEST(DemoOptions, AnObjectWhoseTurnDoesNotComeNeedsMoreTrials) {
  const auto open = [](int trials) {
    experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/cylinder_demo.yaml",
                               {.trials = trials, .groups = {"demo_can"}});
  };
  EXPECT_THAT(testing_support::ErrorOf([&] { open(1); }),
              HasSubstr("or more trials if the objects take turns"));
  EXPECT_NO_THROW(open(2));
}

TEST(DemoOptions, ShapesThatAreNoneAreNamed) {
  EXPECT_THAT(ErrorOf({"cylinders=[25.75x173, 26.75]"}), HasSubstr("26.75"));
  EXPECT_THAT(ErrorOf({"cylinders=[25.75x173, 0x134]"}), HasSubstr("0x134"));
  EXPECT_THAT(ErrorOf({"cylinders=[25.75x173]"}),
              HasSubstr("has 1 shape, but objects has 2 names"));
  EXPECT_THAT(ErrorOf({"trials_per_object=4"}), HasSubstr("runs"));
}

TEST(DemoOptions, ShapesThatAreNotTheirObjectsAreNamed) {
  EXPECT_THAT(
      ErrorOf({"cylinders=[26.75x134, 25.75x173]"}),
      HasSubstr("key 'cylinders': demo_tube is 51.5 x 51.5 x 173 mm, but 26.75x134 is given "
                "(RADIUSxHEIGHT, in the order of `objects`)"));
  EXPECT_THAT(ErrorOf({"cylinders=[25.75x173, 53.5x134]"}), HasSubstr("but 53.5x134 is given"));
}

TEST(DemoOptions, AnObjectBesideThemThatIsNoneIsNamed) {
  EXPECT_THAT(
      ErrorOf({"clutter.others=[spread, spraed, dextrose, melba_toast, coffee_cup, cleaner]"}),
      HasSubstr("spraed"));
}

// Every key of the demo with its default value for a method.
std::map<std::string, std::string> DemoDefaults(const std::string& method, DemoOptions& options) {
  auto map = base::YamlMap::FromFile(RANGEGRASP_SOURCE_DIR "/experiments/cylinder_demo.yaml",
                                     {"method=" + method});
  std::string task;
  experiment::Common common;
  map.Read("task", task);
  experiment::ReadCommon(map, common);
  options = ReadDemo(map, 1);
  std::map<std::string, std::string> defaults;
  for (const base::KeyDoc& key : map.Keys()) defaults[key.path] = key.default_value;
  return defaults;
}

TEST(DemoOptions, TheMethodsDifferInTheListedKeysOnly) {
  DemoOptions improved, published;
  const auto ours = DemoDefaults("improved", improved);
  const auto theirs = DemoDefaults("published", published);
  std::set<std::string> differ, listed = {"demo.max_tries"};
  for (const auto& difference : trial::MethodDifferences()) listed.insert(difference.key);
  for (const auto& row : base::AdditionsTable<DemoAdditions>()) {
    listed.insert("demo." + std::string(row.key));
  }
  for (const auto& [path, value] : ours) {
    if (theirs.at(path) != value) differ.insert(path);
  }
  EXPECT_EQ(differ, listed);
  EXPECT_EQ(theirs.at("demo.max_tries"), "1");
  EXPECT_FALSE(improved.detection.as_published);
  EXPECT_TRUE(published.detection.as_published);
}

TEST(DemoLooks, TheSecondAsksForLess) {
  const DemoOptions options;
  const auto first = FirstLook(options).accept;
  const auto second = SecondLook(options).accept;
  EXPECT_LT(second.min_arc_rad, first.min_arc_rad);
  EXPECT_LT(second.min_length_share, first.min_length_share);
  EXPECT_LT(second.min_seen_share, first.min_seen_share);
  EXPECT_EQ(second.min_agreement, first.min_agreement);
  EXPECT_EQ(double{second.max_radius_error_m}, double{first.max_radius_error_m});
}

TEST(DemoLooks, WithoutTheSwitchTheFirstIsTheDetectionsOwn) {
  DemoOptions options;
  options.thorough = false;
  EXPECT_EQ(FirstLook(options).search.draws, options.detection.search.draws);
  options.thorough = true;
  EXPECT_GT(FirstLook(options).search.draws, options.detection.search.draws);
}

using Eigen::Vector3d;
namespace scans = cylinders::samples;

const Cylinder kTube{{0.05, 0.06, 0.0865}, Vector3d::UnitZ(), 0.02575, 0.173};
const Cylinder kCan{{-0.02, -0.08, 0.02675}, Vector3d::UnitY(), 0.02675, 0.134};

const robot::Robot& TheRobot() {
  static const robot::Robot robot =
      robot::Robot::Load(RANGEGRASP_SOURCE_DIR "/scenes/tabletop.xml");
  return robot;
}

DemoOptions Given() {
  DemoOptions options;
  options.given = {{kTube.radius_m, kTube.height_m}, {kCan.radius_m, kCan.height_m}};
  return options;
}

geometry::Observation Look(const std::vector<Cylinder>& standing) {
  base::Rng rng(5);
  scans::Tabletop tabletop;
  tabletop.cylinders = standing;
  tabletop.boxes = {
      {base::MakePose(Eigen::Matrix3d::Identity(), {-0.12, 0.08, 0.04}), {0.06, 0.09, 0.08}}};
  return scans::Scan(tabletop, {}, rng);
}

trial::Detected Detect(std::size_t wanted, const std::vector<Cylinder>& standing) {
  const DemoOptions options = Given();
  base::Rng rng(7);
  return MakeDemoDetector(options, TheRobot(), wanted)->Detect(Look(standing), rng);
}

/// The place where the pads will meet the object.
Vector3d MiddleOfPads(const grasp::DetectedGrasp& grasp) {
  const auto& state = TheRobot().hand().AtGap(grasp.width_m);
  return grasp.X_CH * (0.5 * (state.thumb_pad_H + state.finger_pad_H));
}

TEST(DemoDetector, TheWantedOneIsFirstWithItsKnownShape) {
  for (const auto& [wanted, truth] : {std::pair(0u, kTube), std::pair(1u, kCan)}) {
    const auto detected = Detect(wanted, {kTube, kCan});
    const auto& objects = detected.detection.objects;
    ASSERT_EQ(objects.size(), 3u) << wanted;  // the other cylinder and the box are obstacles
    EXPECT_FALSE(objects.front().open);
    Vector3d middle = Vector3d::Zero();
    const auto& vertices = objects.front().surface_C.vertices;
    for (const Vector3d& p : vertices) middle += p / static_cast<double>(vertices.size());
    EXPECT_LT((middle - truth.center).norm(), 0.003) << wanted;  // a row of points at the end
    ASSERT_FALSE(detected.detection.grasps.empty());
    EXPECT_FALSE(detected.detection.grasps.front().collides);
  }
}

TEST(DemoDetector, AStandingOneIsGraspedAtItsCentreOfGravityAlongItsAxisFromManySides) {
  const auto detected = Detect(0, {kTube, kCan});
  std::vector<double> turns;
  for (const auto& grasp : detected.detection.grasps) {
    if (grasp.type != grasp::GraspType::kCylindrical || grasp.collides) continue;
    EXPECT_GT(grasp.approach_C.dot(-Vector3d::UnitZ()), 0.999);
    const Vector3d off = MiddleOfPads(grasp) - kTube.center;
    EXPECT_LT(off.head<2>().norm(), 0.02);  // the hand closes on the cylinder
    EXPECT_LT(std::abs(off.z()), 0.05);
    const Vector3d x_C = grasp.X_CH.linear().col(0);
    turns.push_back(std::atan2(x_C.y(), x_C.x()));
  }
  ASSERT_GE(turns.size(), 4u);
  const auto [low, high] = std::ranges::minmax(turns);
  EXPECT_GT(high - low, 1.0);  // [rad]
}

TEST(DemoDetector, ALyingOneIsGraspedAcrossItsAxisAtItsMiddle) {
  const auto detected = Detect(1, {kTube, kCan});
  ASSERT_FALSE(detected.detection.grasps.empty());
  const auto& grasp = detected.detection.grasps.front();
  const Vector3d off = MiddleOfPads(grasp) - kCan.center;
  EXPECT_LT(std::abs(off.dot(kCan.axis)), 0.03);
  EXPECT_LT(std::abs(grasp.approach_C.dot(kCan.axis)), 0.1);
}

TEST(DemoDetector, OneThatIsNotThereIsNotFound) {
  const auto detected = Detect(0, {kCan});
  EXPECT_TRUE(detected.detection.objects.empty());
  EXPECT_TRUE(detected.detection.grasps.empty());
}

TEST(PutFirst, TakesThePlaceOfWhatPerceptionMadeOfIt) {
  perception::Scene scene;
  scene.table.plane = {Vector3d::UnitZ(), 0.0};
  scene.cloud.points = {kTube.center + Vector3d(kTube.radius_m, 0, 0),
                        kTube.center + Vector3d(0, kTube.radius_m, 0.02), Vector3d(-0.2, 0, 0.05)};
  perception::PerceivedObject part, other;
  part.points = {0, 1};
  other.points = {2};
  scene.objects = {other, part};
  PutFirst(kTube, false, scene);
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.objects[0].points, (geometry::Indices{0, 1}));
  EXPECT_EQ(scene.objects[0].kind, perception::ObjectKind::kRotational);
  EXPECT_NEAR(scene.objects[0].height_m, kTube.height_m, 1e-9);
  EXPECT_NEAR(scene.objects[0].base_m, 0.0, 1e-9);
  EXPECT_EQ(scene.objects[1].points, (geometry::Indices{2}));
}

}  // namespace
}  // namespace rangegrasp::cylinders
