#include "geometry/point_cloud.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/range_image.h"

namespace rangegrasp::geometry {
namespace {

TEST(PointCloud, SelectKeepsTheOrderOfTheIndices) {
  const Points points = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {2.0, 0.0, 0.0}};
  const Indices indices = {2, 0, 2};
  EXPECT_EQ(Select(points, indices), (Points{points[2], points[0], points[2]}));
}

TEST(PointCloud, CentroidIsTheMean) {
  const Points points = {{0.0, 0.0, 0.0}, {1.0, 2.0, -4.0}};
  EXPECT_EQ(Centroid(points), Eigen::Vector3d(0.5, 1.0, -2.0));
  EXPECT_THROW(Centroid(Points{}), std::invalid_argument);
}

TEST(RangeImage, ToCloudKeepsTheMeasuredPointsAndTheirPlaces) {
  const double nan = std::nan("");
  RangeImage image;
  image.profiles = 2;
  image.samples = 2;
  image.points_C = {{nan, nan, nan}, {1.0, 0.0, 0.0}, {0.0, 0.0, nan}, {3.0, 0.0, 0.0}};
  Indices source = {9};
  const PointCloud cloud = ToCloud(image, &source);
  EXPECT_EQ(cloud.points, (Points{{1.0, 0.0, 0.0}, {3.0, 0.0, 0.0}}));
  EXPECT_EQ(source, (Indices{1, 3}));
  EXPECT_EQ(image.Index(1, 1), 3u);
}

}  // namespace
}  // namespace rangegrasp::geometry
