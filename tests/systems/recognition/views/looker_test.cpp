#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "error_of.h"
#include "experiment/experiment.h"
#include "recognition/views/wrist_scanner.h"
#include "sensing/hand_eye.h"
#include "temp_folder.h"
#include "trial/grasping_task.h"
#include "trial/trial.h"

namespace rangegrasp::trial {
namespace {

/// A single cup, seen by the fixed scanner and then from the wrist, as in a trial.
LookedAround LookTwice() {
  const auto experiment = experiment::OpenExperiment(
      RANGEGRASP_SOURCE_DIR "/experiments/views_single.yaml", {.set = {"views=2"}});
  const Cell& cell = CellOf(*experiment.task);
  const TrialSpec spec{"coffee_cup", 0, TrialSeed(11, "coffee_cup", 0)};
  Arrangement arranged = *ArrangeTrial(cell, spec);
  return views::AddWristViews(cell, Look(cell, arranged.world, spec.seed), arranged.world,
                              spec.seed);
}

const LookedAround& Twice() {
  static const LookedAround around = LookTwice();
  return around;
}

TEST(Looker, TheArmGoesThereAndAddsAView) {
  const LookedAround& around = Twice();
  ASSERT_EQ(around.looks.size(), 1u);
  EXPECT_TRUE(around.looks[0].arrived);
  EXPECT_GT(around.looks[0].way_s, 0.5);
  ASSERT_EQ(around.sensed.observation.views.size(), 2u);
  ASSERT_EQ(around.sensed.truth.size(), 2u);
  // The views have different origins and noise: the wrist is nearer and elsewhere.
  const auto& views = around.sensed.observation.views;
  EXPECT_GT((views[0].X_CV.translation() - views[1].X_CV.translation()).norm(), 0.3);
  EXPECT_EQ(views[1].noise_m.size(), views[1].image.points_C.size());
  EXPECT_TRUE(views[1].image.origins_C[0].isApprox(views[1].X_CV.translation(), 1e-9));
}

TEST(Looker, SeesOfTheCupWhatTheFirstViewDidNot) {
  const auto& truth = Twice().sensed.truth;
  const auto& views = Twice().sensed.observation.views;
  geometry::Points cup, of_view[2];
  for (std::size_t v = 0; v < 2; ++v) {
    for (std::size_t i = 0; i < truth[v].label.size(); ++i) {
      const Eigen::Vector3d& p = views[v].image.points_C[i];
      if (truth[v].label[i] == 1 && p.allFinite()) of_view[v].push_back(p);
    }
    cup.insert(cup.end(), of_view[v].begin(), of_view[v].end());
  }
  ASSERT_GT(cup.size(), 1000u);
  const Eigen::Vector3d middle = geometry::Centroid(cup);
  // For the fixed scanner, points on the cup's far side are behind its middle.
  const Eigen::Vector2d away = (middle - views[0].X_CV.translation()).head<2>().normalized();
  const auto behind = [&](const Eigen::Vector3d& p) {
    return (p - middle).head<2>().dot(away) > 0.02 && p.z() < 0.07;
  };
  EXPECT_GT(std::ranges::count_if(of_view[1], behind), std::ranges::count_if(of_view[0], behind));
}

// Noise, arm and mount: a sample's range is the true one except for the noise along its ray.
TEST(Looker, ItsRangesAreTrueButForTheNoise) {
  const auto& truth = Twice().sensed.truth[1];
  const auto& view = Twice().sensed.observation.views[1];
  std::vector<double> errors_m;
  for (std::size_t i = 0; i < truth.label.size(); ++i) {
    const Eigen::Vector3d& p = view.image.points_C[i];
    if (truth.state[i] != sensing::SampleState::kMeasured) continue;
    errors_m.push_back(std::abs((p - view.image.origins_C.front()).norm() - truth.true_range_m[i]));
  }
  ASSERT_GT(errors_m.size(), 5000u);
  EXPECT_LT(base::MedianOf(errors_m), 0.0005);  // 0.2 mm at 0.4 m, more at greater distances
}

TEST(Looker, BelievesACalibrationInPlaceOfADraw) {
  const auto experiment =
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/views_single.yaml", {});
  const Cell& cell = CellOf(*experiment.task);
  const testing_support::TempFolder folder;
  const auto file = folder / "hand_eye.yaml";
  Options options = cell.options;
  Of<views::WristViewOptions>(options, views::kWristViews).hand_eye = file;
  const base::Pose& X_HS = *cell.robot.X_HWristScanner;
  Arrangement arranged = *ArrangeTrial(cell, {"coffee_cup", 0, 11});
  const base::Pose X_WS = arranged.world.SitePose("wrist_scanner");
  const auto stands = [&](const base::Pose& X_HSBelieved, std::uint64_t seed) {
    sensing::WriteHandEye({X_HSBelieved, 0.0002, 0.0005}, file);
    return views::WristScanner(options, cell.robot, seed)
        .Scan(arranged.world)
        .observation.views.front()
        .X_CV.translation();
  };
  // The arm's own error is 0.1 mm and 0.02 deg, with a short lever here.
  EXPECT_LT((stands(X_HS, 1) - X_WS.translation()).norm(), 0.0005);
  base::Pose moved = X_HS;
  moved.translation() += 0.005 * X_HS.linear().col(0);
  const Eigen::Vector3d right_W = X_WS.linear().col(0);
  EXPECT_NEAR((stands(moved, 2) - X_WS.translation()).dot(right_W), 0.005, 0.0005);
  moved.translation() += 0.05 * X_HS.linear().col(0);
  EXPECT_THAT(testing_support::ErrorOf([&] { stands(moved, 3); }),
              testing::HasSubstr("is 55 mm from the one in"));
}

/// The cell's detector, but the grasps get the given probability for each number of views;
/// `segments` is that number.
class Promising : public Detector {
 public:
  Promising(const Cell& cell, std::vector<double> by_views)
      : cell_(cell), by_views_(std::move(by_views)) {}
  Detected Detect(const geometry::Observation& observation, base::Rng& rng,
                  const Turn& turn) const override {
    Detected detected = cell_.detector->Detect(observation, rng, turn);
    detected.segments = static_cast<int>(observation.views.size());
    for (auto& grasp : detected.detection.grasps) {
      grasp.probability = by_views_.at(observation.views.size() - 1);
    }
    return detected;
  }

 private:
  const Cell& cell_;
  std::vector<double> by_views_;
};

TEST(Looker, LooksAgainWhereLittleIsPromisedAndKeepsWhatPromisesMore) {
  const auto experiment =
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/views_single.yaml",
                                 {.set = {"views=2", "look.until_probability=0.8"}});
  const Cell& cell = CellOf(*experiment.task);
  const auto attempt = [&](const std::vector<double>& by_views) {
    const TrialSpec spec{"salt_cuboid", 0, TrialSeed(11, "salt_cuboid", 0)};
    Arrangement arranged = *ArrangeTrial(cell, spec);
    const Promising detector(cell, by_views);
    return RunAttempt(cell, arranged.world,
                      {.seed = spec.seed, .target = arranged.target, .detector = &detector});
  };
  const Attempt sure = attempt({0.8, 0.9});
  EXPECT_EQ(sure.looks.size(), 0u);
  EXPECT_EQ(sure.detected.segments, 1);
  const Attempt better = attempt({0.5, 0.6});
  EXPECT_EQ(better.looks.size(), 1u);
  EXPECT_EQ(better.detected.segments, 2);
  const Attempt worse = attempt({0.5, 0.4});
  EXPECT_EQ(worse.looks.size(), 1u);
  EXPECT_EQ(worse.detected.segments, 1);
  EXPECT_TRUE(worse.accepted) << worse.detail;  // judged by the samples of one view
}

TEST(Looker, TheSameSeedGivesTheSameBytes) {
  const LookedAround again = LookTwice();
  EXPECT_EQ(again.q, Twice().q);
  const auto& a = again.sensed.observation.views[1].image.points_C;
  const auto& b = Twice().sensed.observation.views[1].image.points_C;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!a[i].allFinite() && !b[i].allFinite()) continue;
    ASSERT_EQ(a[i], b[i]) << i;
  }
}

}  // namespace
}  // namespace rangegrasp::trial
