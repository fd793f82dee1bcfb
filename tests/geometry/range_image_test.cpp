#include "geometry/range_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/rng.h"

namespace rangegrasp::geometry {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A flat grid, samples along_m apart along the profile and profiles across_m.
RangeImage Grid(int profiles, int samples, double along_m, double across_m) {
  RangeImage image{profiles, samples, {}, {Eigen::Vector3d::Zero()}};
  for (int p = 0; p < profiles; ++p) {
    for (int s = 0; s < samples; ++s) image.points_C.emplace_back(along_m * s, across_m * p, 1.0);
  }
  return image;
}

TEST(MedianSpacing, IsTheMeanOfBothDirectionsOfAGrid) {
  EXPECT_NEAR(MedianSpacing(Grid(30, 40, 0.001, 0.003)), 0.002, 1e-12);
  EXPECT_NEAR(MedianSpacing(Grid(1, 40, 0.001, 0.003)), 0.001, 1e-12);
  EXPECT_NEAR(MedianSpacing(Grid(30, 1, 0.001, 0.003)), 0.003, 1e-12);
}

// Neither gaps nor jumps of depth, which a few samples have, move it.
TEST(MedianSpacing, HoldsWithGapsAndSteps) {
  RangeImage image = Grid(60, 60, 0.001, 0.003);
  base::Rng rng(1);
  for (int k = 0; k < 600; ++k) {
    image.points_C[rng.Index(image.points_C.size())] = Eigen::Vector3d::Constant(kNaN);
  }
  for (int p = 0; p < 60; ++p) {
    for (int s = 30; s < 60; ++s) image.points_C[image.Index(p, s)].z() = 2.0;
  }
  EXPECT_NEAR(MedianSpacing(image), 0.002, 1e-12);
}

TEST(RangeImage, AProfileHasItsOrigin) {
  RangeImage image = Grid(2, 5, 0.001, 0.003);
  EXPECT_EQ(image.OriginOf(9), Eigen::Vector3d::Zero());
  image.origins_C = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(image.OriginOf(i), i < 5 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY()) << i;
  }
  image.origins_C.resize(3);
  EXPECT_THROW(image.OriginOf(0), std::invalid_argument);
}

TEST(ToCloud, TakesWhatWasMeasuredAndSaysWhere) {
  RangeImage image = Grid(2, 3, 0.001, 0.003);
  image.points_C[1].setConstant(kNaN);
  image.points_C[4].x() = kNaN;
  Indices source{7, 7};
  const PointCloud cloud = ToCloud(image, &source);
  EXPECT_EQ(source, (Indices{0, 2, 3, 5}));
  ASSERT_EQ(cloud.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(cloud.points[k], image.points_C[source[k]]);
}

TEST(MedianSpacing, IsZeroWithoutNeighbors) {
  EXPECT_EQ(MedianSpacing({}), 0.0);
  EXPECT_EQ(MedianSpacing(Grid(1, 1, 0.001, 0.001)), 0.0);
  RangeImage image = Grid(3, 3, 0.001, 0.001);
  for (std::size_t i = 1; i < 9; i += 2) image.points_C[i].setConstant(kNaN);
  EXPECT_EQ(MedianSpacing(image), 0.0);  // what is left touches at corners only
}

}  // namespace
}  // namespace rangegrasp::geometry
