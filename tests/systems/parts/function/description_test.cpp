#include "parts/function/description.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "parts/hierarchy/hierarchy.h"
#include "parts/solids.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;

Shape DescriptionMug() {
  return samples::Isosurface(
      Vector3d(-1.1, -1.1, -0.2), Vector3d(1.8, 1.1, 2.2), 0.06,
      [](const Vector3d& p) { return std::min(samples::ToCup(p), samples::ToHandle(p, 0.12)); });
}
/// The true parts: 0 the cup, 1 the handle.
Segmentation CupAndHandle(const Shape& mug) {
  Segmentation found;
  for (std::size_t i = 0; i < mug.Elements(); ++i) {
    const Vector3d center = mug.IsMesh() ? samples::FaceCenter(mug, i) : mug.points[i];
    found.label.push_back(center.head<2>().norm() > samples::kMugOuter + 0.05 ? 1 : 0);
  }
  found.parts = 2;
  found.has_core = true;
  return found;
}

TEST(HeldWater, ACupHoldsItsHollowUprightAndNothingUpsideDown) {
  const Shape cup = samples::Isosurface(Vector3d(-1.1, -1.1, -0.2), Vector3d(1.1, 1.1, 2.2), 0.05,
                                        samples::ToCup);
  const double hollow = std::numbers::pi * samples::kMugInner * samples::kMugInner *
                        (samples::kMugTall - samples::kMugFloor);
  // A cell that the wall touches counts as wall: up to one cell of 1.8 / 24 less all around.
  const double wall_cells = 2.0 * std::numbers::pi * samples::kMugInner *
                            (samples::kMugTall - samples::kMugFloor) * 1.8 / 24.0;
  EXPECT_NEAR(HeldWater(cup.points, Vector3d::UnitZ()), hollow, wall_cells);
  EXPECT_LT(HeldWater(cup.points, -Vector3d::UnitZ()), 0.01 * hollow);
  EXPECT_LT(HeldWater(cup.points, Vector3d::UnitX()), 0.05 * hollow);
  EXPECT_EQ(HeldWater(geometry::Points(5, Vector3d::Ones()), Vector3d::UnitZ()), 0.0);
}

TEST(DescribeParts, AMugIsAContainerWithAHandle) {
  Shape mug = DescriptionMug();
  const auto parts = DescribeParts(mug, CupAndHandle(mug));
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].function, PartFunction::kContainer);
  EXPECT_EQ(parts[1].function, PartFunction::kHandle);
  ASSERT_EQ(parts[1].neighbors.size(), 1u);
  EXPECT_EQ(parts[1].neighbors[0].joints, 2);
  // Two rings of radius 0.12, cut along mesh edges: up to a third longer, more if oblique.
  EXPECT_NEAR(parts[1].neighbors[0].border, 4.0 * std::numbers::pi * 0.12, 0.8);
  // The same mug as points.
  mug.faces.clear();
  const auto of_points = DescribeParts(mug, CupAndHandle(mug));
  EXPECT_EQ(of_points[0].function, PartFunction::kContainer);
  EXPECT_EQ(of_points[1].function, PartFunction::kHandle);
}

TEST(DescribeParts, WhatTheHierarchyFindsOfAMugHasItsFunctionsToo) {
  const Shape mug = DescriptionMug();
  const auto parts = DescribeParts(mug, SegmentHierarchy(mug, {}));
  int containers = 0, handles = 0;
  for (const auto& part : parts) {
    containers += part.function == PartFunction::kContainer;
    handles += part.function == PartFunction::kHandle;
  }
  EXPECT_EQ(containers, 1);
  EXPECT_EQ(handles, 1);
}

// Seen from the side, upside down: half of the outside, and a handle with its ends hidden.
TEST(DescribeParts, OfOneViewTheBodyNeedHaveNoInsideAndTheHandleNoJoint) {
  Shape seen;
  Segmentation found;
  const auto add = [&](const Vector3d& p, std::int32_t label) {
    seen.points.push_back(p);
    found.label.push_back(label);
  };
  for (double height = 0.0; height <= 0.095; height += 0.002) {
    for (double angle = 0.0; angle <= std::numbers::pi; angle += 0.05) {
      add({0.041 * std::cos(angle), 0.041 * std::sin(angle), height}, 0);
    }
  }
  for (double height = 0.03; height <= 0.07; height += 0.002) {
    for (double x = 0.06; x < 0.07; x += 0.002) add({x, 0.0, height}, 1);
  }
  found.parts = 2;
  for (const auto& part : DescribeParts(seen, found)) {
    EXPECT_EQ(part.function, PartFunction::kOther);
  }
  const auto parts = DescribeParts(seen, found, {.one_view = true, .up = {}});
  EXPECT_EQ(parts[0].function, PartFunction::kOther);
  EXPECT_EQ(parts[1].function, PartFunction::kHandle);
}

TEST(DescribeParts, AHandHoldsNoWaterAndHasNoHandle) {
  const samples::Hand hand = samples::BentHand();
  for (const auto& part : DescribeParts(hand.shape, SegmentHierarchy(hand.shape, {}))) {
    EXPECT_EQ(part.function, PartFunction::kOther) << part.label;
  }
}

TEST(DescribeParts, ABallIsMeasured) {
  const Shape ball = samples::Ball(12, [](const Vector3d&) { return 2.0; });
  Segmentation whole;
  whole.label.assign(ball.faces.size(), 0);
  whole.parts = 1;
  const auto parts = DescribeParts(ball, whole);
  // With facets of 2 * pi / 48 the area is within 1 % of the sphere's.
  EXPECT_NEAR(parts[0].area, 16.0 * std::numbers::pi, 0.6);
  EXPECT_NEAR(parts[0].center.norm(), 0.0, 1e-6);
  EXPECT_NEAR(parts[0].extents.minCoeff(), 4.0, 0.1);
  EXPECT_TRUE(parts[0].neighbors.empty());
}

// A can of strips: 30 million samples if a strip were sampled as densely across as along.
TEST(DescribeParts, StripsAreMeasuredAsSquares) {
  constexpr std::uint32_t kSides = 400;
  const auto can = [](std::uint32_t rings) {
    Shape shape;
    for (std::uint32_t ring = 0; ring <= rings; ++ring) {
      for (std::uint32_t k = 0; k < kSides; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / kSides;
        shape.points.emplace_back(std::cos(angle), std::sin(angle), 4.0 * ring / rings);
      }
    }
    for (std::uint32_t ring = 0; ring < rings; ++ring) {
      for (std::uint32_t k = 0; k < kSides; ++k) {
        const std::uint32_t a = ring * kSides + k, b = ring * kSides + (k + 1) % kSides;
        shape.faces.push_back({a, b, b + kSides});
        shape.faces.push_back({a, b + kSides, a + kSides});
      }
    }
    return shape;
  };
  const auto described = [](const Shape& shape) {
    Segmentation whole;
    whole.label.assign(shape.faces.size(), 0);
    whole.parts = 1;
    return DescribeParts(shape, whole).front();
  };
  const PartDescription strips = described(can(1)), squares = described(can(80));
  EXPECT_NEAR(strips.area, squares.area, 1e-9 * squares.area);
  EXPECT_TRUE(strips.center.isApprox(squares.center, 1e-9));
  // Samples are at most a 240th of the diagonal apart.
  EXPECT_TRUE(strips.extents.isApprox(squares.extents, 0.02));
  EXPECT_EQ(strips.function, squares.function);
}

}  // namespace
}  // namespace rangegrasp::parts
