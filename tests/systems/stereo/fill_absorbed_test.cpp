#include "stereo/fill_absorbed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "base/rng.h"

namespace rangegrasp::perception {
namespace {

constexpr double kStep_m = 0.004;
constexpr int kSide = 60;

/// A table of 240 mm, its samples in rows, seen from above; where blind(p) they are not measured.
template <typename Blind>
geometry::View Seen(const Eigen::Vector3d& from, Blind blind) {
  geometry::View view;
  view.image.profiles = view.image.samples = kSide;
  view.image.origins_C = {from};
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      Eigen::Vector3d p(i * kStep_m, j * kStep_m, 0.0);
      if (blind(p)) p.setConstant(std::numeric_limits<double>::quiet_NaN());
      view.image.points_C.push_back(p);
    }
  }
  return view;
}

bool InPatch(const Eigen::Vector3d& p) {
  return p.x() > 0.08 && p.x() < 0.14 && p.y() > 0.08 && p.y() < 0.14;
}
bool Nowhere(const Eigen::Vector3d&) { return false; }

const Eigen::Vector3d kLaser(0.1, 0.1, 0.9);
const Eigen::Vector3d kCamera(0.2, 0.1, 0.9);

TEST(FillsAbsorbed, WhatNoRayOfTheLaserThatCameBackPassesBy) {
  const geometry::View stereo = Seen(kCamera, Nowhere);
  const auto kept = FillsAbsorbed(Seen(kLaser, InPatch), stereo);
  ASSERT_EQ(kept.size(), stereo.image.points_C.size());
  int inside = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const Eigen::Vector3d& p = stereo.image.points_C[i];
    EXPECT_TRUE(!kept[i] || InPatch(p)) << p.transpose();
    // A border of one step, in which a ray that came back passes by, may be left out.
    const bool deep = p.x() > 0.086 && p.x() < 0.134 && p.y() > 0.086 && p.y() < 0.134;
    EXPECT_TRUE(!deep || kept[i]) << p.transpose();
    inside += kept[i] ? 1 : 0;
  }
  EXPECT_GT(inside, 100);
}

TEST(FillsAbsorbed, NothingBehindOrInFrontOfWhatTheLaserSees) {
  for (const double height : {-0.05, 0.05}) {
    geometry::View stereo = Seen(kCamera, Nowhere);
    for (Eigen::Vector3d& p : stereo.image.points_C) p.z() = height;
    const auto kept = FillsAbsorbed(Seen(kLaser, Nowhere), stereo);
    // Only what lies out of the laser's view, beside the table's rim, is left.
    for (std::size_t i = 0; i < kept.size(); ++i) {
      const Eigen::Vector3d p = kLaser + (stereo.image.points_C[i] - kLaser) * 0.9 / (0.9 - height);
      const bool in_view = p.head<2>().minCoeff() > 0.0 && p.head<2>().maxCoeff() < 0.236;
      EXPECT_FALSE(in_view && kept[i]) << p.transpose();
    }
  }
}

TEST(FillsAbsorbed, NoStraysOfTheStereoPair) {
  geometry::View stereo = Seen(kCamera, [](const Eigen::Vector3d& p) { return !InPatch(p); });
  const std::size_t corner = stereo.image.Index(0, 0);
  const Eigen::Vector3d middle(0.11, 0.11, 0.0);
  stereo.image.points_C[corner] = kLaser + 0.8 * (middle - kLaser);
  const auto kept = FillsAbsorbed(Seen(kLaser, InPatch), stereo);
  EXPECT_FALSE(kept[corner]);
  EXPECT_GT(std::count(kept.begin(), kept.end(), true), 100);
}

TEST(FillsAbsorbed, AllWhereTheLaserIsBlindEverywhere) {
  const auto everywhere = [](const Eigen::Vector3d&) { return true; };
  const auto kept = FillsAbsorbed(Seen(kLaser, everywhere), Seen(kCamera, Nowhere));
  EXPECT_EQ(std::count(kept.begin(), kept.end(), true), kSide * kSide);
}

}  // namespace
}  // namespace rangegrasp::perception
