#include "cylinders/demo/demo_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/units.h"
#include "experiment/experiment.h"
#include "experiment/kinds.h"

namespace rangegrasp::demo {
namespace {

using testing::HasSubstr;

experiment::Experiment Open(const std::vector<std::string>& set) {
  return experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/cylinder_demo.yaml",
                                    experiment::AllKinds(), {.set = set});
}

std::string ErrorOf(const std::vector<std::string>& set) {
  try {
    Open(set);
  } catch (const base::InputError& e) {
    return e.what();
  }
  return "";
}

TEST(DemoOptions, TheCylindersAreWantedInTurn) {
  const auto experiment = Open({"runs=5"});
  ASSERT_EQ(experiment.cases.size(), 5u);
  EXPECT_EQ(experiment.cases[0].group, "demo_tube");
  EXPECT_EQ(experiment.cases[1].group, "demo_can");
  EXPECT_EQ(experiment.cases[4].group, "demo_tube");
}

TEST(DemoOptions, ShapesThatAreNoneAreNamed) {
  EXPECT_THAT(ErrorOf({"cylinders=[25.75x173, 26.75]"}), HasSubstr("26.75"));
  EXPECT_THAT(ErrorOf({"cylinders=[25.75x173, 0x134]"}), HasSubstr("0x134"));
  EXPECT_THAT(ErrorOf({"cylinders=[25.75x173]"}), HasSubstr("names 1 shapes, objects names 2"));
  EXPECT_THAT(ErrorOf({"trials_per_object=4"}), HasSubstr("runs"));
}

TEST(DemoOptions, AnObjectBesideThemThatIsNoneIsNamed) {
  EXPECT_THAT(
      ErrorOf({"clutter.others=[spread, spraed, dextrose, melba_toast, coffee_cup, cleaner]"}),
      HasSubstr("spraed"));
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

}  // namespace
}  // namespace rangegrasp::demo
