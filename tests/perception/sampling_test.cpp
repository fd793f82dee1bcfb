// Tests the measured noise and spacing of clouds with known noise and spacing.
#include "perception/sampling.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "perception/perceive.h"

namespace rangegrasp::perception {
namespace {

using geometry::Points;

/// A regular scan of a tilted plane with `along` by `across` metres between points.
Points TiltedPlane(double along_m, double across_m, double noise_m, double wave_m = 0.0) {
  const Eigen::Vector3d u = Eigen::Vector3d(1.0, 0.2, 0.3).normalized();
  const Eigen::Vector3d n = u.cross(Eigen::Vector3d(0.1, 1.0, -0.4)).normalized();
  const Eigen::Vector3d v = n.cross(u);
  base::Rng rng(7);
  Points points;
  for (int row = 0; row < 80; ++row) {
    for (int column = 0; column < 120; ++column) {
      const double wave = wave_m * std::sin(column * along_m / 0.02);
      points.push_back(column * along_m * u + row * across_m * v +
                       (wave + noise_m * rng.Normal()) * n);
    }
  }
  return points;
}

TEST(Sampling, MeasuresNoiseAndBothSpacingsOfAPlane) {
  struct Case {
    double along_m, across_m, noise_m;
  };
  for (const Case& c : {Case{0.002, 0.002, 0.0005}, Case{0.002, 0.005, 0.0003},
                        Case{0.005, 0.011, 0.0003}, Case{0.0015, 0.002, 0.0002}}) {
    const Sampling sampling =
        MeasureSampling(TiltedPlane(c.along_m, c.across_m, c.noise_m), SamplingOptions{});
    // 64 points per neighborhood: 9 %; the median of 32 neighborhoods: 2 %; three times that.
    EXPECT_NEAR(sampling.noise_m, c.noise_m, 0.06 * c.noise_m);
    // Neighborhoods at the border are cut, and the count in a disc depends on its position.
    EXPECT_NEAR(sampling.spacing_m, std::sqrt(c.along_m * c.across_m), 0.1 * sampling.spacing_m);
    EXPECT_NEAR(sampling.gap_m, c.across_m, 0.2 * c.across_m);
  }
}

TEST(Sampling, OfTooFewPointsNothingIsKnown) {
  const Sampling sampling = MeasureSampling(Points(64, {0.0, 0.0, 0.0}), SamplingOptions{});
  EXPECT_EQ(sampling.noise_m, 0.0);
  EXPECT_EQ(sampling.spacing_m, 0.0);
}

TEST(Sampling, ManyPointsInOnePlaceDoNotMatter) {
  Points points(2000, {0.0, 0.0, 0.0});
  const Points plane = TiltedPlane(0.002, 0.002, 0.0005);
  points.insert(points.end(), plane.begin(), plane.end());
  EXPECT_NEAR(MeasureSampling(points, SamplingOptions{}).spacing_m, 0.002, 0.0003);
}

TEST(FitNoisy, OfATableWithoutNoiseIsItsPlane) {
  for (const double height_m : {0.1, 0.2, 0.7, -0.013, 0.0}) {
    Points points;
    for (int row = 0; row < 90; ++row) {
      for (int column = 0; column < 90; ++column) {
        points.emplace_back(0.003 * column - 0.1, 0.003 * row - 0.1, height_m);
      }
    }
    const geometry::Plane near{Eigen::Vector3d::UnitZ(), -height_m + 0.001};
    const NoisyPlane fit = FitNoisy(near, points, 0.005, SamplingOptions{});
    EXPECT_LT(fit.noise_m, 1e-9);
    EXPECT_NEAR(fit.plane.Distance({0.0, 0.0, height_m}), 0.0, 1e-9);
  }
}

TEST(FitNoisy, CentersAPlaneThatWasFoundAtTheLowerSideOfANoisyTable) {
  base::Rng rng(3);
  Points points;
  for (int i = 0; i < 9000; ++i) {
    const double x = rng.Uniform(-0.3, 0.3);
    const double y = rng.Uniform(-0.3, 0.3);
    points.push_back({x, y, 0.002 * rng.Normal()});
    // An object on it.
    if (i % 9 == 0) points.push_back({0.1 * x, 0.1 * y, rng.Uniform(0.0, 0.1)});
  }
  // A plane found with distances for a laser is 5 mm too low.
  const geometry::Plane low{Eigen::Vector3d::UnitZ(), 0.005};
  const NoisyPlane fit = FitNoisy(low, points, 0.005, SamplingOptions{});
  EXPECT_NEAR(fit.noise_m, 0.002, 0.0002);
  // The object's points within five deviations, 10 mm, are 1 % of the table's points: 0.05 mm.
  EXPECT_NEAR(fit.plane.offset_m, 0.0, 0.00015);
  EXPECT_GT(fit.plane.normal.z(), 0.9999);
}

TEST(AdaptiveLength, GrowsWithWhatItStandsForAndIsNeverBelowThePublishedValue) {
  AdaptiveLength length{0.002, {.noises = 2.0, .gaps = 0.5}};
  length.AdaptTo({.noise_m = 0.0005, .spacing_m = 0.1, .gap_m = 0.003});
  EXPECT_EQ(length, 0.002);
  length.AdaptTo({.noise_m = 0.003, .spacing_m = 0.0, .gap_m = 0.003});
  EXPECT_EQ(length, 0.006);
  length.AdaptTo({.noise_m = 0.001, .spacing_m = 0.0, .gap_m = 0.02});
  EXPECT_EQ(length, 0.010);
  length.AdaptTo({});
  EXPECT_EQ(length, 0.002);
  length = 0.004;
  length.AdaptTo({.noise_m = 0.01, .spacing_m = 0.01, .gap_m = 0.01});
  EXPECT_EQ(length, 0.004) << "what is given stays";
}

TEST(AdaptLengths, SegmentsOfACoarserScannerHaveFewerPoints) {
  PerceptionOptions options;
  for (const auto& [spacing_m, points] : {std::pair{0.001, 40}, {0.005, 13}, {0.02, 8}}) {
    AdaptLengths({.spacing_m = spacing_m}, options);
    EXPECT_EQ(options.segment.min_points, points);
  }
}

// This is the scanner that the published lengths were chosen for, so no published length may
// change. Five lengths do: filter_keep_m is 0 as published, and the four of convexity and of
// containers, whose method is not published, begin with values for a finer scanner.
TEST(AdaptLengths, LeavesThePublishedLengthsToThePublishedScanner) {
  PerceptionOptions adapted;
  AdaptLengths({.noise_m = 0.0003, .spacing_m = 0.0028, .gap_m = 0.0044}, adapted);
  const PerceptionOptions published;
  const auto& a = adapted.features;
  const auto& p = published.features;
  EXPECT_EQ(adapted.preprocess.preselection_m, published.preprocess.preselection_m);
  EXPECT_EQ(adapted.preprocess.plane_distance_m, published.preprocess.plane_distance_m);
  EXPECT_EQ(adapted.preprocess.table_clearance_m, published.preprocess.table_clearance_m);
  EXPECT_EQ(adapted.preprocess.normal_radius_m, published.preprocess.normal_radius_m);
  EXPECT_EQ(adapted.preprocess.filter_unit_m, published.preprocess.filter_unit_m);
  EXPECT_EQ(adapted.preprocess.smooth_radius_m, published.preprocess.smooth_radius_m);
  EXPECT_EQ(adapted.segment.min_alpha_m, published.segment.min_alpha_m);
  EXPECT_EQ(adapted.segment.max_alpha_m, published.segment.max_alpha_m);
  EXPECT_EQ(adapted.segment.min_points, published.segment.min_points);
  EXPECT_EQ(a.top.plane_distance_m, p.top.plane_distance_m);
  EXPECT_EQ(a.top.slab_m, p.top.slab_m);
  EXPECT_EQ(a.top.rim_alpha_m, p.top.rim_alpha_m);
  EXPECT_EQ(a.top.bridged_rim_alpha_m, p.top.bridged_rim_alpha_m);
  EXPECT_EQ(a.circle.distance_m, p.circle.distance_m);
  EXPECT_EQ(a.axis.section_m, p.axis.section_m);
  EXPECT_EQ(a.axis.max_sunk_m, p.axis.max_sunk_m);
  EXPECT_EQ(a.axis.lid_distance_m, p.axis.lid_distance_m);
  EXPECT_EQ(a.merge.fragment_gap_m, p.merge.fragment_gap_m);
  EXPECT_EQ(a.merge.footprint_margin_m, p.merge.footprint_margin_m);
  EXPECT_EQ(a.merge.height_margin_m, p.merge.height_margin_m);
  EXPECT_EQ(a.merge.max_in_front_m, p.merge.max_in_front_m);
  EXPECT_EQ(a.container.rim_margin_m, p.container.rim_margin_m);
  EXPECT_EQ(a.completion.free_margin_m, p.completion.free_margin_m);
  EXPECT_EQ(a.completion.end_band_m, p.completion.end_band_m);
  EXPECT_EQ(a.completion.wall_outline_m, p.completion.wall_outline_m);
  EXPECT_EQ(a.completion.lean_margin_m, p.completion.lean_margin_m);
  EXPECT_EQ(a.completion.cell_m, p.completion.cell_m);
  EXPECT_EQ(a.completion.attached_m, p.completion.attached_m);
  EXPECT_EQ(a.completion.link_m, p.completion.link_m);
  EXPECT_EQ(a.completion.on_table_m, p.completion.on_table_m);
}

}  // namespace
}  // namespace rangegrasp::perception
