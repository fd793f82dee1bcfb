#include "seam/task/seam_score.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "seam/task/small_experiment.h"

namespace rangegrasp::seam {
namespace {
using testing_support::Small;

TEST(ScoreSeam, CountsEveryProfileOnceAndNestsTolerancesAndPlaces) {
  const SeamExperiment experiment = Small("seam_three_lines", 13);
  const StripeSensor sensor(experiment.sensor);
  const auto calibration = CalibrationOf(experiment, sensor);
  std::set<EdgeShape> shapes;
  Tallies whole;
  for (int number = 0; number < 13; ++number) {
    const SeamResult seam =
        ScoreSeam(experiment, calibration, RecordSeam(experiment, sensor, number), number);
    shapes.insert(seam.params.shape);
    EXPECT_EQ(seam.profiles, 40);
    for (std::size_t m = 0; m < kMethods; ++m) {
      const Tally& all = seam.all[m];
      EXPECT_EQ(all.profiles, seam.params.shape == EdgeShape::kNone ? 0 : 40);
      EXPECT_TRUE(std::ranges::is_sorted(all.within));
      whole[m] += all;
      EXPECT_LE(all.within.back(), all.profiles);
      EXPECT_EQ(all.profiles, seam.center[m].profiles + seam.boundary[m].profiles);
      for (std::size_t t = 0; t < kTolerances_px.size(); ++t) {
        EXPECT_EQ(all.within[t], seam.center[m].within[t] + seam.boundary[m].within[t]);
      }
    }
  }
  EXPECT_EQ(shapes.size(), 6U);
  // With this sensor's noise no method finds all edges, and each method finds some.
  for (const Tally& tally : whole) {
    EXPECT_GT(tally.within.front(), 0);
    EXPECT_LT(tally.within.front(), tally.profiles);
  }
}

// Scores a track whose end is set by hand. The score depends only on where the head came to rest.
class ScoreRunTest : public testing::Test {
 protected:
  // Scores a head that rests at y, with its line `ahead` = 80 mm before it.
  RunResult At(double y_m, TrackEnd end, const MatOptions& mats) const {
    TrackedRun run{Mats(mats, 1), {}};
    run.result.path = {{0.0, -0.005, 0.0, 0.0, 0.005}, {9.0, -0.005, y_m, 0.0, 0.005}};
    run.result.end = end;
    return ScoreRun(experiment_, run);
  }
  SeamExperiment experiment_ = Small("seam_hazards", 1);
};

TEST_F(ScoreRunTest, AHeadThatRestsBeforeItsLineReachesTheHazardStoppedEarly) {
  MatOptions mats;
  mats.end_y_m = 0.2;
  for (const double y : {0.05, 0.11, 0.117}) {
    EXPECT_TRUE(At(y, TrackEnd::kMatEnd, mats).stopped_early) << y;
  }
  for (const double y : {0.119, 0.15, 0.195}) {
    EXPECT_FALSE(At(y, TrackEnd::kMatEnd, mats).stopped_early) << y;
  }
  // An obstacle begins at its near edge, here at 195 mm.
  mats.end_y_m = 1e9;
  mats.obstacles.push_back({-0.005, 0.2, 0.01, 0.01, 0.01});
  EXPECT_TRUE(At(0.112, TrackEnd::kObstacle, mats).stopped_early);
  EXPECT_FALSE(At(0.114, TrackEnd::kObstacle, mats).stopped_early);
}

TEST_F(ScoreRunTest, AHeadThatCameToTheEndDidNotStopEarlyAndFollowedWhatIsBehindTheFirst100Mm) {
  const RunResult done = At(0.4, TrackEnd::kDone, {});
  EXPECT_FALSE(done.stopped_early);
  EXPECT_DOUBLE_EQ(done.settled_m, 0.3);
  EXPECT_EQ(At(0.08, TrackEnd::kLost, {}).settled_m, 0.0);
  EXPECT_TRUE(At(0.08, TrackEnd::kLost, {}).stopped_early);
}

TEST(Tally, CountsErrorsUpToAndWithATolerance) {
  Tally tally;
  for (const double error : {0.0, 3.0, 3.01, 12.0, 18.0, 18.01, std::nan("")}) tally.Count(error);
  EXPECT_EQ(tally.profiles, 7);
  EXPECT_EQ(tally.within, (std::array{2, 3, 4, 5}));
  Tally sum = tally;
  sum += tally;
  EXPECT_EQ(sum.profiles, 14);
  EXPECT_EQ(sum.within, (std::array{4, 6, 8, 10}));
}

}  // namespace
}  // namespace rangegrasp::seam
