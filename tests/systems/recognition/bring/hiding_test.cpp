#include "recognition/bring/hiding.h"

#include <gtest/gtest.h>

#include <cmath>

#include "recognition/views/box_scan.h"

namespace rangegrasp::bring {
namespace {

using Eigen::Vector3d;

/// A closed box about its middle.
geometry::TriangleMesh BoxMesh(const Vector3d& size_m) {
  geometry::TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Vector3d sign(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
    mesh.vertices.push_back(sign.cwiseProduct(size_m));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

recognition::Library Shelf() {
  return recognition::Library(
      {recognition::MakeKnownObject("box", "Box", BoxMesh({0.08, 0.10, 0.12}))});
}

// The box stands in the middle; seen from one side or from all four.
geometry::Observation LookFromSides(int sides) {
  const Eigen::AlignedBox3d box(Vector3d(-0.04, -0.05, 0.0), Vector3d(0.04, 0.05, 0.12));
  base::Rng rng(3);
  geometry::Observation observation;
  for (int side = 0; side < sides; ++side) {
    const double angle = 1.5707963 * side + 0.4;
    const Vector3d from(0.7 * std::cos(angle), 0.7 * std::sin(angle), 0.6);
    observation.views.push_back(
        views::ScanBox(views::LookFrom(from, Vector3d::Zero()), box, 0.0005, rng, 200));
  }
  return observation;
}

Understanding Knowing(bool known) {
  Understanding understanding;
  understanding.found.resize(1);
  if (!known) return understanding;
  recognition::FoundObject found;
  found.object = "box";
  found.X_CB.translation() = Vector3d(0.0, 0.0, 0.06);
  understanding.found.front() = found;
  return understanding;
}

TEST(HidingArea, IsBehindAnObjectUntilItIsSeenFromAllSides) {
  const auto library = Shelf();
  const auto area = [&](int sides, bool known) {
    return HidingArea(LookFromSides(sides), Knowing(known), library, Vector3d::Zero(), 0.16);
  };
  EXPECT_GT(area(1, true), 0.5 * 0.08 * 0.10) << "as large as the box, at this slant";
  EXPECT_LT(area(4, true), 0.001);
  // The inside of what is not known may be anything.
  EXPECT_GT(area(4, false), 0.5 * 0.08 * 0.10);
}

TEST(HidingArea, OfAnEmptyTableIsNone) {
  const Eigen::AlignedBox3d nothing(Vector3d(5.0, 5.0, 0.0), Vector3d(5.1, 5.1, 0.1));
  base::Rng rng(3);
  geometry::Observation observation;
  observation.views.push_back(views::ScanBox(
      views::LookFrom(Vector3d(0.5, 0.0, 0.7), Vector3d::Zero()), nothing, 0.0005, rng, 200));
  EXPECT_EQ(HidingArea(observation, {}, Shelf(), Vector3d::Zero(), 0.12), 0.0);
}

TEST(SmallestFootprint, IsThatOfTheBoxOnItsSmallestFace) {
  EXPECT_NEAR(SmallestFootprint(Shelf().Find("box")), 0.08 * 0.10, 1e-9);
}

}  // namespace
}  // namespace rangegrasp::bring
