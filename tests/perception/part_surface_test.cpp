#include "perception/internal/part_surface.h"

#include <gtest/gtest.h>

#include <limits>

#include "base/rng.h"

namespace rangegrasp::perception::internal {
namespace {

Eigen::Vector3d Draw(base::Rng& rng) {
  const double x = rng.Uniform();
  const double y = rng.Uniform();
  const double z = rng.Uniform();
  return {x, y, z};
}

// Against every distance: the cube of side 1 has points of the part in one half only, so that
// queries lie within and beyond the gap, and within and beyond the box.
TEST(PartSurface, GivesTheNearestPointWithinTheGapAndNoOther) {
  base::Rng rng(7);
  geometry::Points part;
  for (int i = 0; i < 200; ++i) part.push_back(Draw(rng).cwiseProduct(Eigen::Vector3d(0.5, 1, 1)));
  PartSurface surface(part);
  constexpr double kGap_m = 0.1;
  int within = 0;
  constexpr int kQueries = 500;
  for (int k = 0; k < kQueries; ++k) {
    const Eigen::Vector3d p = Draw(rng);
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      if ((part[i] - p).norm() < (part[nearest] - p).norm()) nearest = i;
    }
    const bool is_within = (part[nearest] - p).norm() <= kGap_m;
    within += is_within ? 1 : 0;
    const auto found = surface.NearestWithin(p, kGap_m);
    ASSERT_EQ(found.has_value(), is_within) << k;
    if (found) {
      EXPECT_EQ(*found, nearest) << k;
    }
  }
  EXPECT_GT(within, 0);
  EXPECT_LT(within, kQueries);
}

TEST(PartSurface, APartWithoutPointsIsNearNothing) {
  PartSurface surface({});
  EXPECT_FALSE(
      surface.NearestWithin(Eigen::Vector3d::Zero(), std::numeric_limits<double>::infinity()));
}

}  // namespace
}  // namespace rangegrasp::perception::internal
