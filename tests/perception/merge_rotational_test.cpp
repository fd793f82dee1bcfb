#include "perception/internal/merge_rotational.h"

#include <gtest/gtest.h>

#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector2d;
using geometry::Indices;
using testing::Analytic;
using testing::Given;

/// A can about (x, y) as a sensor towards +x sees it, and which side of the line y = middle each
/// point is on; points within 5 mm of the line are lost.
void AddCan(Analytic& shape, const Vector2d& center, double radius_m, double middle, Indices& left,
            Indices& right) {
  const auto lid = shape.AddDisc({center.x(), center.y(), 0.1}, radius_m);
  const auto wall = shape.AddWall(center, radius_m, 0.01, 0.096, -1.3, 1.3);
  for (const auto i : testing::Joined(lid, wall)) {
    const double offset = shape.cloud.points[i].y() - middle;
    if (std::abs(offset) > 0.005) (offset < 0.0 ? left : right).push_back(i);
  }
}

std::vector<Part> Merged(const Given& given, const std::vector<Indices>& segments,
                         std::uint64_t seed) {
  std::vector<Part> parts;
  for (const Indices& points : segments) parts.push_back(given.Describe(points, seed));
  core::Rng rng(seed);
  MergeRotational(given.Context(), parts, rng);
  return parts;
}

TEST(MergeRotational, JoinsTheHalvesOfACanWhereverItIsCut) {
  for (int step = -2; step <= 2; ++step) {
    Analytic shape;
    Indices left, right;
    AddCan(shape, {0.01, 0.02}, 0.04, 0.02 + 0.006 * step, left, right);
    const Given given(shape.cloud);
    const auto parts = Merged(given, {left, right}, 1);
    ASSERT_EQ(parts.size(), 1u) << step;
    ASSERT_TRUE(parts[0].axis);
    EXPECT_EQ(parts[0].points.size(), left.size() + right.size());
    EXPECT_NEAR((parts[0].axis->center_C.head<2>() - Vector2d(0.01, 0.02)).norm(), 0.0, 1e-6);
    EXPECT_NEAR(parts[0].axis->radius_m, 0.04, 1e-6);
  }
}

TEST(MergeRotational, LeavesTwoCansApart) {
  Analytic shape;
  std::vector<Indices> cans(2);
  AddCan(shape, {0.0, -0.045}, 0.04, 1.0, cans[0], cans[0]);
  AddCan(shape, {0.0, 0.045}, 0.04, 1.0, cans[1], cans[1]);
  EXPECT_EQ(Merged(Given(shape.cloud), cans, 1).size(), 2u);
}

TEST(MergeRotational, LeavesHalvesOfDifferentCansApart) {
  // The halves face each other; they are of one height, but on two circles.
  Analytic shape;
  Indices left, right, other_left, other_right;
  AddCan(shape, {0.0, 0.0}, 0.040, 0.0, left, right);
  AddCan(shape, {0.015, 0.0}, 0.030, 0.0, other_left, other_right);
  EXPECT_EQ(Merged(Given(shape.cloud), {left, other_right}, 1).size(), 2u);
}

TEST(MergeRotational, LeavesABoxBesideACan) {
  Analytic shape;
  Indices can;
  AddCan(shape, {0.0, 0.0}, 0.04, 1.0, can, can);
  const Indices box =
      testing::Joined(shape.AddRectangle({0.0, 0.075, 0.1}, {0.03, 0.0, 0.0}, {0.0, 0.03, 0.0}),
                      shape.AddRectangle({0.03, 0.075, 0.05}, {0.0, 0.03, 0.0}, {0.0, 0.0, 0.045}));
  const auto parts = Merged(Given(shape.cloud), {can, box}, 1);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_TRUE(parts[0].axis);
  EXPECT_FALSE(parts[1].axis);
}

}  // namespace
}  // namespace rangegrasp::perception::internal
