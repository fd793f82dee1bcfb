#include "grasp/unseen.h"

#include <gtest/gtest.h>

#include "geometry/bounds.h"
#include "geometry/hull.h"
#include "recognition/views/box_scan.h"

namespace rangegrasp::views {
namespace {

using grasp::UnseenByAll;

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr double kCell_m = 0.01;
const AlignedBox3d kBox(Vector3d(-0.03, -0.03, 0.0), Vector3d(0.03, 0.03, 0.12));

geometry::Observation SeenFrom(const std::vector<Vector3d>& places_C) {
  base::Rng rng(1);
  geometry::Observation observation;
  for (const Vector3d& place_C : places_C) {
    observation.views.push_back(ScanBox(LookFrom(place_C, {0.0, 0.0, 0.0}), kBox, 0.0, rng));
  }
  return observation;
}

geometry::TriangleMesh HullOf(const AlignedBox3d& box) {
  geometry::Points corners;
  for (int k = 0; k < 8; ++k)
    corners.push_back(box.corner(static_cast<AlignedBox3d::CornerType>(k)));
  return geometry::ConvexHull(corners);
}

double VolumeOf(const geometry::TriangleMesh& mesh) {
  double six = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    six += mesh.vertices[a].dot(mesh.vertices[b].cross(mesh.vertices[c]));
  }
  return six / 6.0;
}

// Space behind the box as the sensor at +x sees it.
const AlignedBox3d kBehind(Vector3d(-0.09, -0.03, 0.0), Vector3d(-0.04, 0.03, 0.06));

TEST(UnseenByAll, OneViewsShadowStays) {
  const std::vector<geometry::TriangleMesh> shadows = {HullOf(kBehind)};
  const auto unseen = UnseenByAll(SeenFrom({{0.5, 0.0, 0.5}}), shadows, kCell_m);
  // At 45 deg the shadow reaches as far as the box is high: all of kBehind is dark but the cells
  // that its bounds cut, one on each side at most.
  EXPECT_GT(VolumeOf(unseen), 0.03 * 0.04 * 0.05);
  EXPECT_LE(VolumeOf(unseen), kBehind.volume() + 1e-9);
  const Vector3d rounding = Vector3d::Constant(1e-9);
  EXPECT_TRUE(AlignedBox3d(kBehind.min() - rounding, kBehind.max() + rounding)
                  .contains(geometry::BoundsOf(unseen.vertices)));
}

TEST(UnseenByAll, WhatAnotherViewLooksIntoIsSeen) {
  const std::vector<geometry::TriangleMesh> shadows = {HullOf(kBehind)};
  const auto unseen = UnseenByAll(SeenFrom({{0.5, 0.0, 0.5}, {-0.5, 0.0, 0.5}}), shadows, kCell_m);
  // The table's own cells are a surface; nothing else is left.
  EXPECT_LT(VolumeOf(unseen), 0.02 * kBehind.volume());
}

TEST(UnseenByAll, WhatNoShadowHoldsDoesNotCount) {
  EXPECT_TRUE(UnseenByAll(SeenFrom({{0.5, 0.0, 0.5}}), {}, kCell_m).triangles.empty());
}

}  // namespace
}  // namespace rangegrasp::views
