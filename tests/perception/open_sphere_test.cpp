#include "perception/internal/open_sphere.h"

#include <gtest/gtest.h>

#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using samples::Analytic;

/// A top of 300 points whose rim is an ellipse: the nearest rim point is 30 mm from the center.
struct Cup {
  Analytic shape;
  TopSurface top;
  Indices points;

  Cup() {
    for (int k = 0; k < 300; ++k) {
      const double a = 2.0 * base::kPi * k / 300;
      shape.Add({0.04 * std::cos(a), 0.03 * std::sin(a), 0.1}, Vector3d::UnitZ());
      points.push_back(static_cast<std::uint32_t>(k));
    }
    top.points = points;
    top.rim = points;
    top.center_C = {0.0, 0.0, 0.1};
  }
  bool IsOpenWith(const Vector3d& p, int times, const FeatureOptions& options) {
    Indices all = points;
    for (int i = 0; i < times; ++i) {
      all.push_back(static_cast<std::uint32_t>(shape.cloud.size()));
      shape.Add(p, Vector3d::UnitZ());
    }
    return IsOpen(shape.cloud, all, top, options);
  }
};

TEST(IsOpen, HasASphereOfTwoThirdsOfTheDistanceToTheNearestRimPoint) {
  Cup cup;
  EXPECT_NEAR(OpenSphereRadius(cup.shape.cloud, cup.top, {}), 0.020, 1e-12);  // eq. 5.9
  cup.top.rim.clear();
  EXPECT_EQ(OpenSphereRadius(cup.shape.cloud, cup.top, {}), 0.0);
}

TEST(IsOpen, AsPublishedOnePointInTheSphereCloses) {
  FeatureOptions published;
  published.open_stray_share = 0.0;
  base::Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const double x = rng.Normal();
    const double y = rng.Normal();
    const Vector3d direction = Vector3d(x, y, rng.Normal()).normalized();
    const Vector3d center(0.0, 0.0, 0.1);
    EXPECT_TRUE(Cup().IsOpenWith(center + 0.0201 * direction, 1, published));
    EXPECT_FALSE(Cup().IsOpenWith(center + 0.0199 * direction, 1, published));
  }
}

TEST(IsOpen, ForgivesTwoPercentOfTheTop) {
  EXPECT_TRUE(Cup().IsOpenWith({0.0, 0.0, 0.09}, 6, {}));
  EXPECT_FALSE(Cup().IsOpenWith({0.0, 0.0, 0.09}, 7, {}));
}

TEST(IsOpen, WithoutARimNothingIs) {
  Cup cup;
  cup.top.rim.clear();
  EXPECT_FALSE(cup.IsOpenWith({1.0, 0.0, 0.0}, 1, {}));
}

}  // namespace
}  // namespace rangegrasp::perception::internal
