#include "cylinders/ray_noise.h"

#include <gtest/gtest.h>

#include "cylinders/seen_cylinder.h"

namespace rangegrasp::cylinders {
namespace {

const Barrel kBarrel{{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()}, 0.02};

TEST(Incidence, IsThatOfTheNormalWhereTheRayMeetsTheBarrel) {
  const Eigen::Vector3d eye(0.3, 0.0, 0.7);
  for (const double angle : {-1.2, -0.4, 0.0, 0.9}) {
    const Eigen::Vector3d normal(0.0, std::sin(angle), std::cos(angle));
    const Eigen::Vector3d p = kBarrel.radius_m * normal;
    const Eigen::Vector3d ray = (p - eye).normalized();
    const Eigen::Vector3d tangent = Eigen::Vector3d::UnitX().cross(normal);
    const Incidence incidence = IncidenceOf(kBarrel, eye, p);
    EXPECT_NEAR(incidence.radial, std::abs(ray.dot(normal)), 1e-12);
    EXPECT_NEAR(incidence.tangential, std::abs(ray.dot(tangent)), 1e-12);
    // A point that noise moved along the ray has the same.
    EXPECT_NEAR(IncidenceOf(kBarrel, eye, p + 0.003 * ray).radial, incidence.radial, 1e-12);
  }
}

TEST(Incidence, OfARayPastTheBarrelIsThatOfItsOutline) {
  const Incidence incidence = IncidenceOf(kBarrel, {0.0, 0.0, 0.7}, {0.0, 0.05, 0.0});
  EXPECT_EQ(incidence.radial, 0.0);
  EXPECT_NEAR(incidence.tangential, 1.0, 1e-12);
}

TEST(DistanceNoise, IsThatOfDrawnPoints) {
  const Eigen::Vector3d eye(0.3, 0.0, 0.7);
  const RayNoise noise{0.0008, 0.0};
  for (const double angle : {0.0, 0.8, 1.3}) {
    const Eigen::Vector3d p =
        kBarrel.radius_m * Eigen::Vector3d(0.0, std::sin(angle), std::cos(angle));
    const Eigen::Vector3d ray = (p - eye).normalized();
    base::Rng rng(5);
    constexpr int kDraws = 100000;
    double sum = 0.0, squares = 0.0;
    for (int k = 0; k < kDraws; ++k) {
      const double distance = kBarrel.Distance(p + noise.along_m * rng.Normal() * ray);
      sum += distance;
      squares += distance * distance;
    }
    const double mean = sum / kDraws;
    const double variance = squares / kDraws - mean * mean;
    const DistanceNoise expected =
        DistanceNoiseOf(noise, IncidenceOf(kBarrel, eye, p), kBarrel.radius_m);
    // 5 standard errors of the mean, and terms of third order: s^3 / r^2.
    EXPECT_NEAR(expected.mean_m, mean,
                5.0 * std::sqrt(variance / kDraws) + std::pow(0.0008, 3) / std::pow(0.02, 2));
    // 5 standard errors of a variance are 5 sqrt(2 / n) = 2.2 %; next terms: (s / r)^2 = 0.2 %.
    EXPECT_NEAR(expected.variance_m2 / variance, 1.0, 0.03);
  }
}

}  // namespace
}  // namespace rangegrasp::cylinders
