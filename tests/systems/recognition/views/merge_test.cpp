#include "recognition/views/merge.h"

#include <gtest/gtest.h>

#include "base/units.h"
#include "geometry/box_scan.h"
#include "geometry/random_points.h"

namespace rangegrasp::views {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using geometry::samples::LookFrom;
using geometry::samples::ScanBox;

const AlignedBox3d kBox(Vector3d(-0.05, -0.04, 0.0), Vector3d(0.05, 0.04, 0.12));
const AlignedBox3d kNothing(Vector3d(9.0, 9.0, 9.0), Vector3d(9.1, 9.1, 9.1));
const AlignedBox3d kRegion(Vector3d(-0.25, -0.25, -0.05), Vector3d(0.25, 0.25, 0.3));
const Vector3d kMiddle(0.0, 0.0, 0.06);
constexpr double kSigma_m = 0.0003;

base::Pose Offset(const base::Pose& X_CS, const Vector3d& shift, const Vector3d& turn) {
  const base::Pose by = base::MakePose(
      Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()).toRotationMatrix(), shift);
  return X_CS * by * X_CS.inverse();
}

/// Maximum displacement of the region's corners by a correction.
double WorstOf(const base::Pose& X_left) {
  double worst = 0.0;
  for (const double z : {0.0, 0.12}) {
    for (const double x : {-0.05, 0.05}) {
      for (const double y : {-0.04, 0.04}) {
        const Vector3d p(x, y, z);
        worst = std::max(worst, (X_left * p - p).norm());
      }
    }
  }
  return worst;
}

class SeededMerge : public testing::TestWithParam<std::uint64_t> {};

// Two views of a box share its top, two of its sides and the table, which determine all directions.
// The second is off by the stated error: 2 mm, 0.4 deg; 1 / sqrt(3) of it per direction.
TEST_P(SeededMerge, FindsAGivenOffsetOfAViewOfABox) {
  base::Rng rng(GetParam());
  const base::Pose X_first = LookFrom({0.45, 0.25, 0.35}, kMiddle);
  const base::Pose X_second = LookFrom({0.20, 0.40, 0.30}, kMiddle);
  geometry::Observation earlier;
  earlier.views.push_back(ScanBox(X_first, kBox, kSigma_m, rng));
  const geometry::View view = ScanBox(X_second, kBox, kSigma_m, rng);
  const auto draw = [&rng](double sigma) {
    return Vector3d(geometry::samples::RandomVector(rng) * sigma / std::sqrt(3.0));
  };
  RefineOptions options;
  options.shift_error_m = 0.002;
  options.turn_error_rad = base::Deg(0.4);
  const Vector3d shift = draw(options.shift_error_m);
  const Vector3d turn = draw(options.turn_error_rad);
  const base::Pose X_off = Offset(X_second, shift, turn);
  const Refinement found = Refine(earlier, Moved(view, X_off), kRegion, options);
  ASSERT_TRUE(found.refined);
  EXPECT_LT(WorstOf(found.X_by * X_off), 0.0006);
  EXPECT_LE(WorstOf(found.X_by * X_off), std::max(0.0004, WorstOf(X_off)));
}
INSTANTIATE_TEST_SUITE_P(Seeds, SeededMerge, testing::Range<std::uint64_t>(1, 13));

// A table alone does not determine a shift along it, so the arm's value is kept. It fully
// determines a shift perpendicular to it.
TEST(Merge, LeavesOpenWhatATableLeavesOpen) {
  base::Rng rng(3);
  const base::Pose X_first = LookFrom({0.45, 0.25, 0.35}, kMiddle);
  const base::Pose X_second = LookFrom({-0.20, 0.30, 0.30}, kMiddle);
  geometry::Observation earlier;
  earlier.views.push_back(ScanBox(X_first, kNothing, kSigma_m, rng));
  const geometry::View view = ScanBox(X_second, kNothing, kSigma_m, rng);
  base::Pose X_off = base::Pose::Identity();
  X_off.translation() = Vector3d(0.001, -0.001, 0.001);
  const Refinement found = Refine(earlier, Moved(view, X_off), kRegion, {});
  ASSERT_TRUE(found.refined);
  const Vector3d left = found.X_by * X_off * Vector3d::Zero();
  EXPECT_NEAR(left.z(), 0.0, 0.0002);
  EXPECT_NEAR(left.x(), 0.001, 0.0003);
  EXPECT_NEAR(left.y(), -0.001, 0.0003);
}

// The view is 5 mm off, but the stated error of the arm is at most 0.2 mm.
TEST(Merge, GoesNoFurtherThanTheErrorAllows) {
  base::Rng rng(4);
  const base::Pose X_second = LookFrom({0.20, 0.40, 0.30}, kMiddle);
  geometry::Observation earlier;
  earlier.views.push_back(ScanBox(LookFrom({0.45, 0.25, 0.35}, kMiddle), kBox, kSigma_m, rng));
  RefineOptions strict;
  strict.shift_error_m = 0.0002;
  strict.turn_error_rad = base::Deg(0.02);
  base::Pose X_off = base::Pose::Identity();
  X_off.translation() = Vector3d(0.004, 0.0, 0.003);
  const auto view = Moved(ScanBox(X_second, kBox, kSigma_m, rng), X_off);
  const Refinement found = Refine(earlier, view, kRegion, strict);
  const Vector3d sensor = view.X_CV.translation();
  EXPECT_LE((found.X_by * sensor - sensor).norm(), strict.max_deviations * 0.0002 / std::sqrt(3.0));
  EXPECT_EQ(found.refined, found.deviations <= strict.max_deviations);
}

// A wall of 4 mm on a table, seen from both sides, like a cup's: the second view sees the other
// side. The correction stays within what a tenth of the points and the arm's stated error allow.
TEST(Merge, DoesNotLayTheTwoSidesOfAWallOntoEachOther) {
  base::Rng rng(7);
  const AlignedBox3d wall(Vector3d(-0.002, -0.08, 0.0), Vector3d(0.002, 0.08, 0.12));
  geometry::Observation earlier;
  earlier.views.push_back(ScanBox(LookFrom({0.40, 0.0, 0.35}, kMiddle), wall, kSigma_m, rng));
  const auto view = ScanBox(LookFrom({-0.40, 0.0, 0.35}, kMiddle), wall, kSigma_m, rng);
  const Refinement found = Refine(earlier, view, kRegion, {});
  ASSERT_TRUE(found.refined);
  EXPECT_LT((found.X_by * kMiddle - kMiddle).norm(), 0.001);
}

TEST(Merge, TellsWhatHasNothingInCommon) {
  base::Rng rng(5);
  geometry::Observation nothing;
  const auto view = ScanBox(LookFrom({0.45, 0.25, 0.35}, kMiddle), kBox, kSigma_m, rng);
  EXPECT_FALSE(Refine(nothing, view, kRegion, {}).refined);
}

// Opposite faces are 0.08 and 0.10 m apart, whichever side each was seen from: two views from
// opposite corners, the second off by 1 mm and corrected.
TEST(Merge, AMergedBoxHasItsTrueSize) {
  base::Rng rng(6);
  const base::Pose X_second = LookFrom({-0.35, -0.30, 0.35}, kMiddle);
  geometry::Observation merged;
  merged.views.push_back(ScanBox(LookFrom({0.40, 0.30, 0.35}, kMiddle), kBox, kSigma_m, rng));
  // Both views see the top and the table.
  base::Pose X_off = base::Pose::Identity();
  X_off.translation() = Vector3d(0.0, 0.0, 0.001);
  const auto view = Moved(ScanBox(X_second, kBox, kSigma_m, rng), X_off);
  const Refinement found = Refine(merged, view, kRegion, {});
  ASSERT_TRUE(found.refined);
  merged.views.push_back(Moved(view, found.X_by));
  double sums[2] = {0.0, 0.0};
  int counts[2] = {0, 0};
  double tops = 0.0;
  int top = 0;
  for (std::size_t v = 0; v < 2; ++v) {
    for (const Vector3d& p : merged.views[v].image.points_C) {
      const double x = v == 0 ? 0.05 : -0.05;
      if (std::abs(p.x() - x) < 0.004 && std::abs(p.y()) < 0.03 && p.z() > 0.02 && p.z() < 0.10) {
        sums[v] += p.x();
        ++counts[v];
      }
      if (v == 1 && std::abs(p.x()) < 0.04 && std::abs(p.y()) < 0.03 && p.z() > 0.11) {
        tops += p.z();
        ++top;
      }
    }
  }
  ASSERT_GT(counts[0], 50);
  ASSERT_GT(counts[1], 50);
  ASSERT_GT(top, 50);
  EXPECT_NEAR(sums[0] / counts[0] - sums[1] / counts[1], 0.10, 0.0005);
  EXPECT_NEAR(tops / top, 0.12, 0.0002);
}

TEST(Merge, MovesPointsOriginsAndPoseAlike) {
  base::Rng rng(7);
  const base::Pose X_CS = LookFrom({0.45, 0.25, 0.35}, kMiddle);
  const auto view = ScanBox(X_CS, kBox, 0.0, rng, 8);
  const base::Pose X_by = Offset(X_CS, {0.1, 0.2, 0.3}, {0.2, -0.1, 0.4});
  const auto moved = Moved(view, X_by);
  EXPECT_TRUE(moved.X_CV.isApprox(X_by * X_CS));
  EXPECT_TRUE(moved.image.origins_C[0].isApprox(moved.X_CV.translation()));
  for (std::size_t i = 0; i < view.image.points_C.size(); ++i) {
    if (!view.image.points_C[i].allFinite()) continue;
    const Vector3d before = X_CS.inverse() * view.image.points_C[i];
    EXPECT_TRUE((moved.X_CV.inverse() * moved.image.points_C[i]).isApprox(before, 1e-9));
  }
}

}  // namespace
}  // namespace rangegrasp::views
