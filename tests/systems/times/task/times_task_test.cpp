#include "times/task/times_task.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "experiment/experiment.h"
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

}  // namespace

}  // namespace rangegrasp::times
