#include "recognition/symmetry.h"

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

// The groups of turns, counted by hand: of a box 4, a square prism 8, a cube 24, a regular
// triangle's prism 6, a pentagon's 10.
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

}  // namespace
}  // namespace rangegrasp::recognition
