#include "times/task/times_task.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "error_of.h"
#include "experiment/experiment.h"
#include "temp_folder.h"
#include "trial/grasping_task.h"
#include "trial/trial.h"

namespace rangegrasp::times {
namespace {

const trial::Cell& TestCell() {
  static const auto experiment =
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", {});
  return trial::CellOf(*experiment.task);
}

TEST(SizedScan, HasAsManyPointsOfEachKindAsItShould) {
  const auto arranged = trial::ArrangeTrial(TestCell(), {"coffee_cup", 0, 3});
  ASSERT_TRUE(arranged);
  // Fewer points and more points than the scanner itself has of one object.
  for (const ScanSize size : {ScanSize{300, 5000}, ScanSize{4000, 9000}}) {
    const auto scan = SizedScan(TestCell(), arranged->world, size, base::Rng(1));
    const geometry::Plane table_W = TestCell().TablePlane();
    const double clearance_m = TestCell().options.perception.preprocess.table_clearance_m;
    int above = 0;
    int on = 0;
    for (const auto& p_W : scan.views[0].image.points_C) {
      if (!p_W.allFinite()) continue;
      ++(table_W.Distance(p_W) > clearance_m ? above : on);
    }
    EXPECT_EQ(above, size.object_points);
    EXPECT_EQ(on, size.table_points);
  }
}

TEST(SizedScan, OfAWorldWithoutObjectsIsRefused) {
  const sim::World empty(TestCell().options.scene, {}, {});
  EXPECT_THROW(SizedScan(TestCell(), empty, {100, 100}, base::Rng(1)), base::InputError);
}

TEST(TimesTask, APublishedNumberOfPointsThatDoesNotFitIsNamed) {
  const testing_support::TempFolder folder;
  const auto file = folder.Write("t.csv", "scene,object_points,table_points\n1,1e12,100\n");
  const std::string experiment = RANGEGRASP_SOURCE_DIR "/experiments/segmentation_times.yaml";
  EXPECT_THAT(testing_support::ErrorOf([&] {
                experiment::OpenExperiment(experiment, {.set = {"reference=" + file.string()}});
              }),
              testing::HasSubstr("t.csv:2: column 'object_points': '1e12' must be a number of "
                                 "points from 1 to 10000000"));
}

}  // namespace
}  // namespace rangegrasp::times
