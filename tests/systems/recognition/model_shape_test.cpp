#include "recognition/model_shape.h"

#include <gtest/gtest.h>

#include "base/units.h"
#include "perception/raster_scan.h"
#include "recognition/library.h"

namespace rangegrasp::recognition {
namespace {

using Eigen::Vector3d;

Symmetry SymmetryOfMesh(const geometry::TriangleMesh& mesh) {
  return MakeKnownObject("it", "it", mesh).symmetry;
}

base::Pose Turned(double angle_rad, const Vector3d& axis, const Vector3d& about) {
  return Eigen::Translation3d(about) * Eigen::AngleAxisd(angle_rad, axis.normalized()) *
         Eigen::Translation3d(-about);
}

// Sizes of the rotation groups, counted by hand: box 4, square prism 8, cube 24, regular triangular
// prism 6, pentagonal prism 10.
TEST(Symmetry, HasAllTurnsOfPrismsAndBoxes) {
  EXPECT_EQ(SymmetryOfMesh(synthetic::BoxMesh(0.09, 0.06, 0.135)).rotations.size(), 4u);
  EXPECT_EQ(SymmetryOfMesh(synthetic::BoxMesh(0.06, 0.06, 0.135)).rotations.size(), 8u);
  EXPECT_EQ(SymmetryOfMesh(synthetic::BoxMesh(0.06, 0.06, 0.06)).rotations.size(), 24u);
  const auto prism = [](int n) { return synthetic::Extrude(synthetic::Regular(n, 0.04), 0.16); };
  EXPECT_EQ(SymmetryOfMesh(prism(3)).rotations.size(), 6u);
  EXPECT_EQ(SymmetryOfMesh(prism(5)).rotations.size(), 10u);
}

TEST(Symmetry, OfACylinderIsItsAxisAndAFlip) {
  const Symmetry symmetry = SymmetryOfMesh(synthetic::CylinderMesh(0.035, 0.12));
  ASSERT_TRUE(symmetry.axis_B);
  EXPECT_NEAR(std::abs(symmetry.axis_B->z()), 1.0, 1e-3);
  EXPECT_EQ(symmetry.rotations.size(), 2u);
}

TEST(Symmetry, OfAConeHasNoFlip) {
  const auto cone = synthetic::Turned({{0.0, 0.0}, {0.04, 0.0}, {0.02, 0.1}, {0.0, 0.1}});
  const Symmetry symmetry = SymmetryOfMesh(cone);
  ASSERT_TRUE(symmetry.axis_B);
  EXPECT_EQ(symmetry.rotations.size(), 1u);
}

TEST(Symmetry, AHandleLeavesNone) {
  const Symmetry symmetry = SymmetryOfMesh(synthetic::MugMesh());
  EXPECT_FALSE(symmetry.axis_B);
  EXPECT_EQ(symmetry.rotations.size(), 1u);
}

TEST(Difference, LeavesSymmetryAside) {
  const Symmetry box = SymmetryOfMesh(synthetic::BoxMesh(0.09, 0.06, 0.135));
  const base::Pose X = synthetic::Standing(0.4, {0.1, 0.2, 0.3});
  const base::Pose half = Turned(base::kPi, Vector3d::UnitX(), box.center_B);
  EXPECT_NEAR(Difference(X, X * half, box).angle_rad, 0.0, 1e-6);
  EXPECT_NEAR(Difference(X, X * half, box).distance_m, 0.0, 1e-9);
  const base::Pose off = Turned(0.3, Vector3d::UnitX(), box.center_B);
  EXPECT_NEAR(Difference(X, X * half * off, box).angle_rad, 0.3, 1e-6);
}

TEST(EqualPoses, HaveTheSameCenterAndBeginWithTheGivenOne) {
  const Symmetry box = SymmetryOfMesh(geometry::Transformed(
      synthetic::BoxMesh(0.09, 0.06, 0.135), synthetic::Standing(0, {0.2, 0.0, 0.1})));
  const base::Pose X = synthetic::Standing(0.4, {0.1, 0.2, 0.3});
  const auto poses = EqualPoses(X, box);
  ASSERT_EQ(poses.size(), 4u);
  EXPECT_TRUE(poses.front().isApprox(X));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(Difference(X, poses[i], box).distance_m, 0.0, 1e-9);
    EXPECT_NEAR(Difference(X, poses[i], box).angle_rad, 0.0, 0.01) << "rotations are measured";
    for (std::size_t k = 0; k < i; ++k) EXPECT_FALSE(poses[i].isApprox(poses[k], 0.1));
  }
}

class SeededAxis : public testing::TestWithParam<int> {
 protected:
  base::Pose Drawn() const {
    base::Rng rng(static_cast<std::uint64_t>(GetParam()));
    const Eigen::Quaterniond turn(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal());
    return base::MakePose(turn.normalized().toRotationMatrix(), {rng.Normal(), 0.1, rng.Normal()});
  }
};

// A mug's axis is that of its body, whatever its handle weighs: 96 sides are 0.1 mm off a circle.
TEST_P(SeededAxis, OfAMugIsThatOfItsBody) {
  const base::Pose X = Drawn();
  const auto mesh = geometry::Transformed(synthetic::MugMesh(), X);
  const auto axis = AxisOfRevolution(SampledSurface(mesh, 0.003));
  ASSERT_TRUE(axis);
  const Eigen::Vector3d expected = X.linear().col(2);
  EXPECT_GT(std::abs(axis->direction_B.dot(expected)), std::cos(base::Deg(0.3)));
  const Eigen::Vector3d beside = axis->point_B - X * Eigen::Vector3d(0.0, 0.0, 0.047);
  EXPECT_LT((beside - beside.dot(expected) * expected).norm(), 3e-4);
}

TEST_P(SeededAxis, IsNoneOfBoxesAndPrisms) {
  for (const auto& mesh : {synthetic::BoxMesh(0.09, 0.06, 0.135),
                           synthetic::Extrude(synthetic::Regular(3, 0.035), 0.16)}) {
    EXPECT_FALSE(AxisOfRevolution(SampledSurface(geometry::Transformed(mesh, Drawn()), 0.003)));
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, SeededAxis, testing::Range(1, 11));

}  // namespace
}  // namespace rangegrasp::recognition
