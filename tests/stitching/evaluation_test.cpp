#include "stitching/evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "temp_folder.h"

namespace rangegrasp::stitching {
namespace {

using core::InputError;
using testing::HasSubstr;
using testing_support::TempFolder;

const std::filesystem::path kSource = RANGEGRASP_SOURCE_DIR;

Evaluation Shipped(const std::string& name) {
  return ReadEvaluation(kSource / "experiments" / (name + ".yaml"));
}

// A small one, of a seed that nothing is reported on.
Evaluation Small(const std::string& name, int seams) {
  Evaluation evaluation = Shipped(name);
  evaluation.seed = 4711;
  evaluation.seams = seams;
  evaluation.profiles_per_seam = 40;
  return evaluation;
}

void ExpectSame(const SeamResult& a, const SeamResult& b) {
  EXPECT_EQ(a.seam, b.seam);
  EXPECT_EQ(a.shape, b.shape);
  EXPECT_EQ(a.height_m, b.height_m);
  EXPECT_EQ(a.profiles, b.profiles);
  EXPECT_EQ(a.no_edge, b.no_edge);
  for (std::size_t m = 0; m < kMethods; ++m) {
    EXPECT_EQ(a.all[m].profiles, b.all[m].profiles);
    EXPECT_EQ(a.all[m].within, b.all[m].within);
  }
}

TEST(Evaluate, RatesAreTheSameForAnyNumberOfThreadsAndInAnyOrder) {
  const Evaluation evaluation = Small("seam_base", 7);
  const auto one = Evaluate(evaluation, 1, {});
  const auto three = Evaluate(evaluation, 3, {});
  const StripeSensor sensor(evaluation.sensor);
  const auto calibration = CalibrationOf(evaluation, sensor);
  ASSERT_EQ(one.seams.size(), 7U);
  ASSERT_EQ(three.seams.size(), 7U);
  for (int seam = 6; seam >= 0; --seam) {
    const auto s = static_cast<std::size_t>(seam);
    ExpectSame(one.seams[s], three.seams[s]);
    ExpectSame(one.seams[s], EvaluateSeam(evaluation, sensor, calibration, seam));
  }
}

TEST(Evaluate, RunsAreTheSameForAnyNumberOfThreads) {
  const Evaluation evaluation = Small("seam_hazards", 3);
  const auto one = Evaluate(evaluation, 1, {});
  const auto two = Evaluate(evaluation, 2, {});
  ASSERT_EQ(one.runs.size(), 6U);
  ASSERT_EQ(two.runs.size(), 6U);
  for (std::size_t i = 0; i < one.runs.size(); ++i) {
    EXPECT_EQ(one.runs[i].run, two.runs[i].run);
    EXPECT_EQ(one.runs[i].method, two.runs[i].method);
    EXPECT_EQ(one.runs[i].end, two.runs[i].end);
    EXPECT_EQ(one.runs[i].settled_m, two.runs[i].settled_m);
    EXPECT_EQ(one.runs[i].mean_error_m, two.runs[i].mean_error_m);
  }
}

TEST(Evaluate, CountsEveryProfileOnceAndNestsTolerancesAndPlaces) {
  const Evaluation evaluation = Small("seam_three_lines", 13);
  int calls = 0;
  const auto result = Evaluate(evaluation, 2, [&](int done, int total) {
    ++calls;
    EXPECT_LE(done, total);
    EXPECT_EQ(total, 13);
  });
  EXPECT_EQ(calls, 13);
  std::set<EdgeShape> shapes;
  for (const SeamResult& seam : result.seams) {
    shapes.insert(seam.shape);
    EXPECT_EQ(seam.profiles, 40);
    for (std::size_t m = 0; m < kMethods; ++m) {
      const Tally& all = seam.all[m];
      EXPECT_EQ(all.profiles, seam.shape == EdgeShape::kNone ? 0 : 40);
      EXPECT_TRUE(std::ranges::is_sorted(all.within));
      EXPECT_LE(all.within.back(), all.profiles);
      EXPECT_EQ(all.profiles, seam.centre[m].profiles + seam.boundary[m].profiles);
      for (std::size_t t = 0; t < kTolerances_px.size(); ++t) {
        EXPECT_EQ(all.within[t], seam.centre[m].within[t] + seam.boundary[m].within[t]);
      }
    }
  }
  EXPECT_EQ(shapes.size(), 6U);
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

// The label is where the recorded heights rise: an independent look at a clean seam.
TEST(Record, LabelsAreWhereTheHeightsRise) {
  Evaluation evaluation = Small("seam_base", 5);
  evaluation.shapes = {EdgeShape::kStep};
  evaluation.texture = {};
  evaluation.texture.weave_relief_m = 0.0;
  evaluation.texture.fuzz_m = 0.0;
  evaluation.texture.filaments_per_m = 0.0;
  evaluation.texture.loose_filaments_per_m2 = 0.0;
  evaluation.texture.gloss = 0.0;
  evaluation.texture.darkness = 0.0;
  evaluation.sensor.row_sigma_px = 0.02;
  evaluation.sensor.outlier_share = 0.0;
  evaluation.sensor.lost_return = 0.0;
  const StripeSensor sensor(evaluation.sensor);
  const auto calibration = CalibrationOf(evaluation, sensor);
  for (int number = 0; number < 5; ++number) {
    const Recording recording = Record(evaluation, sensor, number);
    ASSERT_EQ(recording.raw.size(), recording.label_column.size());
    for (std::size_t i = 0; i < recording.raw.size(); ++i) {
      const auto z = seam::Calibrate(recording.raw[i], calibration).height_m;
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
  const Evaluation evaluation = Small("seam_hazards", 200);
  int ends = 0;
  for (int run = 0; run < 200; ++run) {
    const MatOptions mats = MatsOf(evaluation, run);
    const bool end = mats.end_y_m < 1.0;
    ends += end ? 1 : 0;
    ASSERT_NE(end, mats.obstacles.size() == 1);
    const double y = end ? mats.end_y_m : mats.obstacles[0].y_m;
    EXPECT_GE(y, 0.15);
    EXPECT_LE(y, 0.25);
    if (end) continue;
    EXPECT_GE(mats.obstacles[0].height_m, 3e-3);
    // In the way of the needle, or nearly.
    const double needle = mats.course.XAt(y) - evaluation.track.wanted_distance_m;
    EXPECT_LE(std::abs(mats.obstacles[0].x_m - needle), 0.01);
  }
  EXPECT_GT(ends, 60);
  EXPECT_LT(ends, 140);
}

TEST(MatsOf, AHalfCircleIsStraightButForIt) {
  const Evaluation evaluation = Shipped("seam_half_circle");
  const MatOptions mats = MatsOf(evaluation, 3);
  EXPECT_EQ(mats.course.XAt(0.1), 0.0);
  EXPECT_DOUBLE_EQ(mats.course.XAt(0.5 * evaluation.track.length_m), -0.02);
}

TEST(ReadEvaluation, EveryShippedFileIsRead) {
  EXPECT_EQ(Shipped("seam_base").kind, EvaluationKind::kRates);
  EXPECT_GE(Shipped("seam_base").seams * Shipped("seam_base").profiles_per_seam, 30'000);
  EXPECT_GE(Shipped("seam_three_lines").seams * Shipped("seam_three_lines").profiles_per_seam,
            10'000);
  EXPECT_EQ(Shipped("seam_track").kind, EvaluationKind::kTracks);
  EXPECT_EQ(Shipped("seam_hazards").kind, EvaluationKind::kHazards);
  EXPECT_GE(Shipped("seam_hazards").seams, 1000);
}

TEST(ReadEvaluation, NamesWhatIsWrong) {
  const TempFolder folder;
  const std::string sensor =
      "sensor: " + (kSource / "models/sensors/stripe_base.yaml").string() + "\n";
  const auto refused = [&](const std::string& text, const std::string& says) {
    const auto file = folder.Write("e.yaml", text);
    try {
      ReadEvaluation(file);
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(file.string()));
      EXPECT_THAT(error.what(), HasSubstr(says));
    }
  };
  refused("name: x\n", "sensor");
  refused("sensor: none.yaml\n", "none.yaml");
  refused(sensor + "kind: walks\n", "kind");
  refused(sensor + "shapes: [stepp]\n", "nearest: 'step'");
  refused(sensor + "seems: 4\n", "seems");
  refused(sensor + "seams: 0\n", "seams");
  refused(sensor + "texture:\n  gloss: 2\n", "gloss");
  refused(sensor + "monitor:\n  window: 2\n", "window");
  refused(sensor + "track:\n  length_mm: -4\n", "length_mm");
  refused(sensor + "half_circle_radius_mm: x\n", "half_circle_radius_mm");
}

}  // namespace
}  // namespace rangegrasp::stitching
