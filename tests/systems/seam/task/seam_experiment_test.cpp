#include "seam/task/seam_experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "base/error.h"
#include "error_of.h"
#include "seam/task/small_experiment.h"
#include "temp_folder.h"

namespace rangegrasp::seam {
namespace {

using testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::kSource;
using testing_support::Shipped;
using testing_support::Small;
using testing_support::TempFolder;

// Checks the labels independently on a clean seam: a label is where the recorded heights rise.
TEST(RecordSeam, LabelsAreWhereTheHeightsRise) {
  SeamExperiment experiment = Small("seam_base", 5);
  experiment.shapes = {EdgeShape::kStep};
  experiment.texture = {};
  experiment.texture.weave_relief_m = 0.0;
  experiment.texture.fuzz_m = 0.0;
  experiment.texture.waviness_m = 0.0;
  experiment.texture.filaments_per_m = 0.0;
  experiment.texture.loose_filaments_per_m2 = 0.0;
  experiment.texture.gloss = 0.0;
  experiment.texture.darkness = 0.0;
  experiment.sensor.row_sigma_px = 0.02;
  experiment.sensor.outlier_share = 0.0;
  experiment.sensor.lost_return = 0.0;
  const StripeSensor sensor(experiment.sensor);
  const auto calibration = CalibrationOf(experiment, sensor);
  for (int number = 0; number < 5; ++number) {
    const Recording recording = RecordSeam(experiment, sensor, number);
    ASSERT_EQ(recording.raw.size(), recording.label_column.size());
    for (std::size_t i = 0; i < recording.raw.size(); ++i) {
      const auto z = Calibrate(recording.raw[i], calibration).height_m;
      // The steepest rise over three columns.
      std::size_t best = 3;
      for (std::size_t c = 3; c + 3 < z.size(); ++c) {
        if (z[c + 1] - z[c - 2] > z[best + 1] - z[best - 2]) best = c;
      }
      EXPECT_NEAR(static_cast<double>(best), recording.label_column[i], 4.0) << number << " " << i;
    }
  }
}

TEST(MatsOf, HazardsLieWhereTheLoopHasSettled) {
  const SeamExperiment experiment = Small("seam_hazards", 200);
  int ends = 0;
  for (int run = 0; run < 200; ++run) {
    const MatOptions mats = MatsOf(experiment, run);
    const bool end = mats.end_y_m < 1.0;
    ends += end ? 1 : 0;
    ASSERT_NE(end, mats.obstacles.size() == 1);
    const double y = end ? mats.end_y_m : mats.obstacles[0].y_m;
    EXPECT_GE(y, 0.15);
    EXPECT_LE(y, 0.25);
    if (end) continue;
    EXPECT_GE(mats.obstacles[0].height_m, 3e-3);
    // In the needle's path, or nearly.
    const double needle = mats.course.XAt(y) - experiment.track.wanted_distance_m;
    EXPECT_LE(std::abs(mats.obstacles[0].x_m - needle), 0.01);
  }
  EXPECT_GT(ends, 60);
  EXPECT_LT(ends, 140);
}

TEST(MatsOf, AHalfCircleIsStraightButForIt) {
  const SeamExperiment experiment = Shipped("seam_half_circle");
  const MatOptions mats = MatsOf(experiment, 3);
  EXPECT_EQ(mats.course.XAt(0.1), 0.0);
  EXPECT_DOUBLE_EQ(mats.course.XAt(0.5 * experiment.track.length_m), -0.02);
}

TEST(ReadSeamExperiment, EveryShippedFileIsRead) {
  EXPECT_EQ(Shipped("seam_base").kind, SeamKind::kRates);
  EXPECT_GE(Shipped("seam_base").seams * Shipped("seam_base").record.profiles, 30'000);
  EXPECT_GE(Shipped("seam_three_lines").seams * Shipped("seam_three_lines").record.profiles,
            10'000);
  EXPECT_EQ(Shipped("seam_track").kind, SeamKind::kTracks);
  EXPECT_EQ(Shipped("seam_hazards").kind, SeamKind::kHazards);
  EXPECT_GE(Shipped("seam_hazards").seams, 1000);
}

TEST(ReadSeamExperiment, NamesWhatIsWrong) {
  const TempFolder folder;
  const std::string sensor =
      "task: seam\nsensor: " + (kSource / "models/sensors/stripe_base.yaml").string() + "\n";
  const auto refused = [&](const std::string& text, const std::string& says) {
    const auto file = folder.Write("e.yaml", text);
    EXPECT_THAT(ErrorOf([&] { ReadSeamExperiment(file); }),
                testing::AllOf(HasSubstr(file.string()), HasSubstr(says)))
        << text;
  };
  refused("task: seam\n", "sensor");
  refused("task: parts\n", "task 'parts'");
  refused("name: x\n", "task 'grasping'");
  refused("task: seam\nsensor: none.yaml\n", "none.yaml");
  refused(sensor + "kind: walks\n", "kind");
  refused(sensor + "shapes: [stepp]\n", "nearest: step");
  refused(sensor + "seems: 4\n", "seems");
  refused(sensor + "seams: 0\n", "seams");
  refused(sensor + "decisions: [steps, voting, steps]\n", "'steps' twice");
  refused(sensor + "decisions: [voting_as_published]\n", "voting, weights, steps");
  refused(sensor + "texture:\n  gloss: 2\n", "gloss");
  refused(sensor + "monitor:\n  window: 2\n", "window");
  refused(sensor + "track:\n  length_mm: -4\n", "length_mm");
  refused(sensor + "half_circle_radius_mm: x\n", "half_circle_radius_mm");
}

TEST(HazardOf, IsAnObstacleOrAnEndBeforeTheTracks) {
  MatOptions mats;
  EXPECT_EQ(HazardOf(mats, 1.0), Hazard::kNone);
  mats.end_y_m = 1.5;
  EXPECT_EQ(HazardOf(mats, 1.0), Hazard::kNone);
  mats.end_y_m = 0.5;
  EXPECT_EQ(HazardOf(mats, 1.0), Hazard::kMatEnd);
  mats.obstacles = {{0.0, 0.3, 4e-3, 4e-3, 5e-3}};
  EXPECT_EQ(HazardOf(mats, 1.0), Hazard::kObstacle);
}

TEST(SeamSeed, DiffersForEveryExperimentSeedAndSeam) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SeamExperiment experiment;
    experiment.seed = seed;
    for (int number = 0; number < 100; ++number) seeds.insert(SeamSeed(experiment, number));
  }
  EXPECT_EQ(seeds.size(), 10000u);
}

}  // namespace
}  // namespace rangegrasp::seam
