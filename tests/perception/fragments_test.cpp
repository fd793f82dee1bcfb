#include "perception/internal/fragments.h"

#include <gtest/gtest.h>

#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using testing::Analytic;
using testing::Given;
using testing::Joined;

/// What a sensor towards +x sees of a box about (x, y): its top and its front face, the latter down
/// from `gap_m` under the top.
struct BoxFaces {
  Indices top;
  Indices front;
};
BoxFaces AddBox(Analytic& shape, double x, double y, double height_m, double gap_m = 0.0) {
  BoxFaces faces;
  faces.top = shape.AddRectangle({x, y, height_m}, {0.03, 0.0, 0.0}, {0.0, 0.03, 0.0});
  const double low = 0.01;
  const double high = height_m - gap_m;
  faces.front = shape.AddRectangle({x + 0.03, y, 0.5 * (low + high)}, {0.0, 0.03, 0.0},
                                   {0.0, 0.0, 0.5 * (high - low)});
  return faces;
}

Kinship KinshipOf(const Given& given, const Indices& fragment, const Indices& host) {
  return FindKinship(given.Context(), given.Describe(fragment), given.Describe(host));
}

TEST(FindKinship, AFrontFaceUnderItsTopIsWithinTheBox) {
  for (const auto& [gap, kinship] :
       {std::pair(0.002, Kinship::kWithin), std::pair(0.010, Kinship::kWithin),
        std::pair(0.014, Kinship::kNone)}) {  // the gap is 12 mm
    Analytic shape;
    const BoxFaces box = AddBox(shape, 0.0, 0.0, 0.1, gap);
    const Given given(shape.cloud);
    EXPECT_EQ(KinshipOf(given, box.front, box.top), kinship) << gap;
  }
}

TEST(FindKinship, ACapIsAboveItsBottleAndAnotherBoxIsNot) {
  Analytic shape;
  const Indices body = Joined(shape.AddDisc({0.0, 0.0, 0.1}, 0.04),
                              shape.AddWall({0.0, 0.0}, 0.04, 0.02, 0.1, -1.2, 1.2));
  const Indices cap = Joined(shape.AddDisc({0.0, 0.0, 0.13}, 0.015),
                             shape.AddWall({0.0, 0.0}, 0.015, 0.106, 0.13, -1.2, 1.2));
  const Indices high = Joined(shape.AddDisc({0.0, 0.0, 0.15}, 0.015),
                              shape.AddWall({0.0, 0.0}, 0.015, 0.12, 0.15, -1.2, 1.2));
  const Indices wide = shape.AddDisc({0.0, 0.0, 0.105}, 0.036);
  const Indices aside = shape.AddDisc({0.05, 0.0, 0.105}, 0.015);
  const Given given(shape.cloud);
  EXPECT_EQ(KinshipOf(given, cap, body), Kinship::kAbove);
  EXPECT_EQ(KinshipOf(given, high, body), Kinship::kNone);   // 20 mm over the top
  EXPECT_NE(KinshipOf(given, wide, body), Kinship::kAbove);  // 81 % of the footprint
  EXPECT_NE(KinshipOf(given, aside, body), Kinship::kAbove);
}

TEST(FindKinship, ASlopeGoesOnAcrossAGapUpwardsAndNotSideways) {
  // A slope of 45 deg towards the sensor in three pieces, 10 mm apart.
  Analytic shape;
  const Vector3d y(0.0, 0.03, 0.0);
  const Vector3d up = 0.02 * Vector3d(-1.0, 0.0, 1.0).normalized();
  const Vector3d low_center(0.0, 0.0, 0.03);
  const Indices low = shape.AddRectangle(low_center, y, up);
  const Indices high = shape.AddRectangle(low_center + 2.5 * up, y, up);
  const Indices beside = shape.AddRectangle(low_center + Vector3d(0.0, 0.07, 0.0), y, up);
  const Given given(shape.cloud);
  EXPECT_EQ(KinshipOf(given, high, low), Kinship::kSurface);
  EXPECT_EQ(KinshipOf(given, beside, low), Kinship::kNone);
}

TEST(FindKinship, AConcaveJunctionIsTwoObjects) {
  // The foot of a wall that stands behind a lower box's top, 10 mm from it.
  Analytic shape;
  const Indices top = shape.AddRectangle({0.04, 0.0, 0.05}, {0.03, 0.0, 0.0}, {0.0, 0.03, 0.0});
  const Indices wall = shape.AddRectangle({0.0, 0.0, 0.09}, {0.0, 0.03, 0.0}, {0.0, 0.0, 0.035});
  const Given given(shape.cloud);
  EXPECT_EQ(KinshipOf(given, wall, top), Kinship::kNone);
  EXPECT_EQ(KinshipOf(given, top, wall), Kinship::kNone);
}

TEST(FindKinship, BoxesBesideEachOtherHaveNone) {
  for (int step = 0; step < 12; ++step) {
    const double a = core::kPi * step / 6;
    Analytic shape;
    const BoxFaces one = AddBox(shape, 0.0, 0.0, 0.08);
    const BoxFaces other = AddBox(shape, 0.09 * std::cos(a), 0.09 * std::sin(a), 0.06);
    const Given given(shape.cloud);
    EXPECT_EQ(KinshipOf(given, Joined(other.top, other.front), Joined(one.top, one.front)),
              Kinship::kNone)
        << step;
  }
}

TEST(MergeFragments, JoinsWhatIsKinAndLeavesTheRest) {
  Analytic shape;
  const BoxFaces one = AddBox(shape, 0.0, -0.06, 0.1, 0.008);
  const BoxFaces two = AddBox(shape, 0.0, 0.06, 0.08, 0.008);
  const Given given(shape.cloud);
  std::vector<Part> parts;
  for (const Indices& points : {one.top, two.front, two.top, one.front}) {
    parts.push_back(given.Describe(points));
  }
  core::Rng rng(1);
  MergeFragments(given.Context(), parts, rng);
  ASSERT_EQ(parts.size(), 2u);
  for (const Part& part : parts) {
    const BoxFaces& box = part.points.front() == one.top.front() ? one : two;
    Indices expected = Joined(box.top, box.front);
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(part.points, expected);
    EXPECT_TRUE(part.top);
  }
}

}  // namespace
}  // namespace rangegrasp::perception::internal
