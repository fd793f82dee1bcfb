#include "seam/stitching/mats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "base/units.h"
#include "base/words.h"
#include "seam/stitching/smooth_mats.h"

namespace rangegrasp::seam {
namespace {

constexpr EdgeShape kShapes[] = {EdgeShape::kStep,   EdgeShape::kDouble,  EdgeShape::kSlant,
                                 EdgeShape::kConvex, EdgeShape::kConcave, EdgeShape::kNone};

double HeightAt(const Mats& mats, double x, double y) { return mats.At(x, y).height_m; }

TEST(Mats, WithoutEdgeAndTextureIsATiltedBrightPlane) {
  MatOptions options = Smooth(EdgeShape::kNone);
  options.tilt_rad = 0.05;
  const Mats mats(options, 1);
  for (double x = -0.05; x <= 0.05; x += 0.0037) {
    EXPECT_NEAR(HeightAt(mats, x, 3.0 * x), std::tan(0.05) * x, 1e-15);
    EXPECT_DOUBLE_EQ(mats.At(x, 0.1).return_strength, 1.0);
  }
  EXPECT_TRUE(std::isnan(mats.EdgeX(0.0)));
}

TEST(Mats, AStepIsAsHighAsAskedAndHalfAsHighAtItsEdge) {
  const Mats mats(Smooth(EdgeShape::kStep), 1);
  const MatOptions& o = mats.options();
  EXPECT_DOUBLE_EQ(HeightAt(mats, -0.51 * o.edge_width_m, 0.0), 0.0);
  EXPECT_NEAR(HeightAt(mats, 0.0, 0.0), 0.5 * o.height_m, 1e-12);
  EXPECT_DOUBLE_EQ(HeightAt(mats, 0.51 * o.edge_width_m, 0.0), o.height_m);
}

TEST(Mats, ASlantRisesInAStraightLine) {
  const Mats mats(Smooth(EdgeShape::kSlant), 1);
  const MatOptions& o = mats.options();
  for (const double t : {0.0, 0.1, 0.5, 0.8, 1.0}) {
    EXPECT_NEAR(HeightAt(mats, (t - 0.5) * o.slant_width_m, 0.0), t * o.height_m, 1e-12);
  }
}

TEST(Mats, ADoubleEdgeHasItsMinorStepOnTheLowSide) {
  const Mats mats(Smooth(EdgeShape::kDouble), 1);
  const MatOptions& o = mats.options();
  EXPECT_DOUBLE_EQ(HeightAt(mats, -1.1 * o.double_gap_m, 0.0), 0.0);
  EXPECT_NEAR(HeightAt(mats, -0.5 * o.double_gap_m, 0.0), o.double_share * o.height_m, 1e-12);
  EXPECT_NEAR(HeightAt(mats, o.edge_width_m, 0.0), o.height_m, 1e-12);
  EXPECT_DOUBLE_EQ(mats.EdgeX(0.0), 0.0);
}

// Points of the arc are one radius away from its centre. Beyond 45 degrees the surface continues
// straight with a slope of 1.
TEST(Mats, MouldsAreCylindersUpTo45DegreesThenStraight) {
  for (const EdgeShape shape : {EdgeShape::kConvex, EdgeShape::kConcave}) {
    MatOptions options = Smooth(shape);
    options.height_m = 0.0;
    options.mould_x_m = 0.004;
    const Mats mats(options, 1);
    const double sign = shape == EdgeShape::kConvex ? 1.0 : -1.0;
    const double r = options.radius_m;
    for (double dx = -0.7 * r; dx <= 0.7 * r; dx += 0.05 * r) {
      const double z = HeightAt(mats, options.mould_x_m + dx, 0.0);
      EXPECT_NEAR(std::hypot(dx, z + sign * r), r, 1e-12);
    }
    const double beyond = HeightAt(mats, options.mould_x_m + r, 0.0);
    EXPECT_NEAR(HeightAt(mats, options.mould_x_m + r + 0.01, 0.0) - beyond, -sign * 0.01, 1e-12);
    EXPECT_NEAR(HeightAt(mats, options.mould_x_m - r - 0.01, 0.0) - beyond, -sign * 0.01, 1e-12);
    EXPECT_DOUBLE_EQ(mats.At(options.mould_x_m, 0.0).return_strength, 1.0);
    EXPECT_DOUBLE_EQ(mats.At(options.mould_x_m + r, 0.0).return_strength, 0.0);
  }
}

// On a convex mould, the side facing away from the tilt is later too steep to return light.
TEST(Mats, TiltAddsToTheSlopeOfAMould) {
  MatOptions options = Smooth(EdgeShape::kConvex);
  options.tilt_rad = 0.1;
  const Mats mats(options, 1);
  EXPECT_GT(mats.At(0.016, 0.0).return_strength, mats.At(-0.016, 0.0).return_strength + 0.05);
}

TEST(Mats, EdgeXIsWhereTheHeightCrossesHalfTheStep) {
  MatOptions options = Smooth(EdgeShape::kStep);
  options.texture.fray_m = 0.2e-3;
  options.course.slope = 0.1;
  options.course.waves = {{0.01, 0.3, 1.0}, {0.002, 0.1, 2.0}};
  const Mats mats(options, 5);
  for (double y = -0.1; y < 0.4; y += 0.00173) {
    double low = options.course.XAt(y) - 2e-3;
    double high = low + 4e-3;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (low + high);
      (HeightAt(mats, middle, y) < 0.5 * options.height_m ? low : high) = middle;
    }
    ASSERT_NEAR(mats.EdgeX(y), low, 1e-9) << "y = " << y;
  }
}

// With 10,000 stretches of fray, the standard error of the estimate is below 1.5 %.
TEST(Mats, FrayWandersByItsStandardDeviation) {
  MatOptions options = Smooth(EdgeShape::kStep);
  options.texture.fray_m = 0.2e-3;
  const Mats mats(options, 3);
  double sum = 0.0;
  int count = 0;
  for (double y = 0.0; y < 1e4 * options.texture.fray_length_m; y += 0.37e-3, ++count) {
    sum += mats.EdgeX(y) * mats.EdgeX(y);
  }
  EXPECT_NEAR(std::sqrt(sum / count), options.texture.fray_m, 0.05 * options.texture.fray_m);
}

TEST(Mats, FuzzHasItsStandardDeviation) {
  MatOptions options = Smooth(EdgeShape::kNone);
  options.texture.fuzz_m = 0.02e-3;
  const Mats mats(options, 3);
  base::Rng rng(1);
  double sum = 0.0;
  constexpr int kPoints = 100'000;
  for (int i = 0; i < kPoints; ++i) {
    const double x = rng.Uniform(-0.5, 0.5);
    const double z = HeightAt(mats, x, rng.Uniform(-0.5, 0.5));
    sum += z * z;
  }
  EXPECT_NEAR(std::sqrt(sum / kPoints), options.texture.fuzz_m, 0.03 * options.texture.fuzz_m);
}

TEST(Mats, DependOnOptionsAndSeedAlone) {
  const MatOptions options = RandomMats(EdgeShape::kStep, MatTexture{}, true, 4);
  const Mats a(options, 1);
  const Mats b(options, 1);
  const Mats c(options, 2);
  int differ = 0;
  for (int i = 0; i < 1000; ++i) {
    const double x = -0.03 + 6e-5 * i;
    ASSERT_EQ(HeightAt(a, x, 0.02), HeightAt(b, x, 0.02));
    ASSERT_EQ(a.At(x, 0.02).return_strength, b.At(x, 0.02).return_strength);
    differ += HeightAt(a, x, 0.02) != HeightAt(c, x, 0.02) ? 1 : 0;
  }
  EXPECT_GT(differ, 990);
}

// The steepest features are a filament 0.8 mm high and 0.1 mm wide that leans by 0.9 (a slope of 22
// along y), and a step of 1.1 mm within 0.05 mm on a fray. A jump of a tenth of the relief fails.
TEST(Mats, AreContinuousAlongY) {
  constexpr double kStep_m = 0.05e-6;
  constexpr double kSteepest = 80.0;
  for (const EdgeShape shape : kShapes) {
    for (const Weave weave : {Weave::kUniDirectional, Weave::kWoven, Weave::kPlaited}) {
      MatOptions options = RandomMats(shape, MatTexture{}, false, 9);
      options.texture.weave = weave;
      options.texture.detached_share = 0.4;
      options.texture.filaments_per_m = 1000.0;
      const Mats mats(options, 11);
      base::Rng rng(2);
      for (int i = 0; i < 4000; ++i) {
        const double x = options.course.offset_m + rng.Uniform(-0.01, 0.01);
        // A whole number of steps, so that cell boundaries are tested as well.
        const double y = static_cast<double>(rng.Index(100)) * 1e-3 - 0.5 * kStep_m;
        ASSERT_NEAR(HeightAt(mats, x, y), HeightAt(mats, x, y + kStep_m), kSteepest * kStep_m)
            << base::Word(shape) << " at " << x << ", " << y;
      }
    }
  }
}

// A tow's steep sides have a slope of 8 relief / period, and two tows cross. Gapless steps of 1 um
// must stay below that. A tow that ends in a jump would not.
TEST(Mats, ReliefIsContinuousAndOfMeanZero) {
  constexpr double kStep_m = 1e-6;
  for (const Weave weave : {Weave::kUniDirectional, Weave::kWoven, Weave::kPlaited}) {
    MatOptions options = Smooth(EdgeShape::kNone);
    options.texture.weave = weave;
    options.texture.weave_relief_m = 0.04e-3;
    const double relief = options.texture.weave_relief_m;
    const double bound = 2.0 * 16.0 * relief / options.texture.weave_period_m * kStep_m;
    const Mats mats(options, 5);
    for (int i = 0; i < 20'000; ++i) {
      const double t = i * kStep_m;
      if (weave != Weave::kUniDirectional) {  // unidirectional threads are steeper
        ASSERT_NEAR(HeightAt(mats, t, 0.001), HeightAt(mats, t + kStep_m, 0.001), bound) << t;
        ASSERT_NEAR(HeightAt(mats, 0.001, t), HeightAt(mats, 0.001, t + kStep_m), bound) << t;
      }
      ASSERT_LE(std::abs(HeightAt(mats, t, t)), 1.5 * relief);
    }
    base::Rng rng(1);
    double sum = 0.0;
    constexpr int kPoints = 40'000;
    for (int i = 0; i < kPoints; ++i) {
      const double x = rng.Uniform(-0.5, 0.5);
      sum += HeightAt(mats, x, rng.Uniform(-0.5, 0.5));
    }
    // The heights lie within one relief of each other: 5 standard errors, and 3 % for threads.
    EXPECT_NEAR(sum / kPoints, 0.0, (5.0 * 0.5 / std::sqrt(kPoints) + 0.03) * relief);
  }
}

TEST(Mats, BundlesEndSmoothly) {
  constexpr double kStep_m = 5e-6;
  MatOptions options = Smooth(EdgeShape::kStep);
  options.texture.detached_share = 0.5;
  const Mats mats(options, 5);
  double highest = 0.0;
  for (double y = 0.0; y < 0.5; y += kStep_m) {
    const double height = HeightAt(mats, -2e-3, y);
    // The slope of an end is 1.5 times its height over its length of 1.5 mm; wandering adds 2.
    ASSERT_NEAR(height, HeightAt(mats, -2e-3, y + kStep_m), 4.0 * kStep_m) << y;
    highest = std::max(highest, height);
  }
  EXPECT_GT(highest, 0.3 * options.height_m);
}

// Most filaments seen at y are seen nearby at y + 0.3 mm, because they are 1 to 8 mm long.
TEST(Mats, NeighbouringProfilesSeeTheSameFilaments) {
  MatOptions options = Smooth(EdgeShape::kStep);
  options.texture.filaments_per_m = 300.0;
  options.texture.loose_filaments_per_m2 = 3000.0;
  options.texture.filament_height_m = 0.4e-3;
  const Mats mats(options, 7);
  int seen = 0;
  int again = 0;
  for (double y = 0.0; y < 0.3; y += 2e-3) {
    for (double x = -0.02; x < -0.1e-3; x += 0.05e-3) {
      if (HeightAt(mats, x, y) < 0.2e-3) continue;
      ++seen;
      double highest = 0.0;
      for (double dx = -0.4e-3; dx <= 0.4e-3; dx += 0.04e-3) {
        highest = std::max(highest, HeightAt(mats, std::min(x + dx, -0.06e-3), y + 0.3e-3));
      }
      again += highest > 0.1e-3 ? 1 : 0;
    }
  }
  EXPECT_GT(seen, 50);
  EXPECT_GT(again, 0.8 * seen);
}

// Measures the share of the edge's length that has a ridge next to it. The smooth ends of a ridge
// count in part.
TEST(Mats, BundlesAreDetachedAlongTheShareOfTheEdge) {
  for (const double share : {0.05, 0.3, 0.8}) {
    MatOptions options = Smooth(EdgeShape::kStep);
    options.texture.detached_share = share;
    const Mats mats(options, 7);
    int with = 0;
    int count = 0;
    for (double y = 0.0; y < 20.0; y += 5e-3, ++count) {
      double highest = 0.0;
      for (double x = -4e-3; x < -0.5e-3; x += 0.1e-3) {
        highest = std::max(highest, HeightAt(mats, x, y));
      }
      with += highest > 0.05 * options.height_m ? 1 : 0;
    }
    const double found = static_cast<double>(with) / count;
    EXPECT_GT(found, 0.7 * share);
    EXPECT_LT(found, 1.15 * share);
  }
}

// A woven mat shows equal parts of warp and weft, at right angles to each other. Half of the gloss
// therefore reflects the light away, at any angle of the mat.
TEST(Mats, GlossIsHowOftenTowsSendTheLightElsewhere) {
  for (const double gloss : {0.0, 0.4, 1.0}) {
    MatOptions options = Smooth(EdgeShape::kNone);
    options.texture.gloss = gloss;
    const Mats mats(options, 17);
    base::Rng rng(3);
    int dark = 0;
    constexpr int kPoints = 20'000;
    for (int i = 0; i < kPoints; ++i) {
      const double x = rng.Uniform(-2.0, 2.0);
      dark += mats.At(x, rng.Uniform(-2.0, 2.0)).return_strength < 0.53 ? 1 : 0;
    }
    // The tolerance is five standard errors of a share.
    EXPECT_NEAR(dark / static_cast<double>(kPoints), 0.5 * gloss, 5.0 * 0.5 / std::sqrt(kPoints));
  }
}

TEST(Mats, DarkMatsReturnLessLight) {
  double last = 1.1;
  for (const double darkness : {0.0, 0.3, 0.7, 1.0}) {
    MatOptions options = Smooth(EdgeShape::kNone);
    options.texture.darkness = darkness;
    const double strength = Mats(options, 1).At(0.0, 0.0).return_strength;
    EXPECT_LT(strength, last);
    EXPECT_GT(strength, 0.0);
    last = strength;
  }
}

TEST(Mats, BeyondTheEndTheBaseMatGoesOn) {
  MatOptions options = Smooth(EdgeShape::kStep);
  options.end_y_m = 0.1;
  const Mats mats(options, 1);
  EXPECT_NEAR(HeightAt(mats, 0.01, 0.099), options.height_m, 1e-12);
  EXPECT_DOUBLE_EQ(HeightAt(mats, 0.01, 0.101), 0.0);
  EXPECT_DOUBLE_EQ(HeightAt(mats, -0.01, 0.101), 0.0);
  EXPECT_TRUE(std::isfinite(mats.EdgeX(0.1)));
  EXPECT_TRUE(std::isnan(mats.EdgeX(0.1001)));
}

TEST(Mats, ObstaclesRiseAboveTheSurfaceTheyLieOn) {
  MatOptions options = Smooth(EdgeShape::kStep);
  options.obstacles = {{-0.01, 0.05, 0.004, 0.006, 0.003}, {0.01, 0.05, 0.004, 0.006, 0.005}};
  const Mats mats(options, 1);
  EXPECT_NEAR(HeightAt(mats, -0.01, 0.05), 0.003, 1e-12);
  EXPECT_NEAR(HeightAt(mats, 0.01, 0.05), 0.005 + options.height_m, 1e-12);
  EXPECT_DOUBLE_EQ(HeightAt(mats, -0.01 + 0.00201, 0.05), 0.0);
  EXPECT_DOUBLE_EQ(HeightAt(mats, -0.01, 0.05 - 0.00301), 0.0);
  EXPECT_GT(mats.At(-0.01, 0.05).return_strength, 0.8);
}

// A sine with a phase of a quarter period is a cosine.
TEST(EdgeCourse, IsALineWithWaves) {
  EdgeCourse course;
  course.offset_m = 0.001;
  course.slope = 0.1;
  course.waves.push_back({.amplitude_m = 0.004, .length_m = 0.2, .phase_rad = 0.5 * base::kPi});
  for (double y = -0.3; y < 0.3; y += 0.01) {
    EXPECT_NEAR(course.XAt(y), 0.001 + 0.1 * y + 0.004 * std::cos(2.0 * base::kPi * y / 0.2),
                1e-12);
  }
}

TEST(EdgeCourse, AHalfCircleBulgesToTheLowSide) {
  EdgeCourse course;
  course.offset_m = 0.002;
  course.half_circle_radius_m = 0.01;
  course.half_circle_y_m = 0.1;
  EXPECT_DOUBLE_EQ(course.XAt(0.1), 0.002 - 0.01);
  EXPECT_NEAR(course.XAt(0.106), 0.002 - 0.008, 1e-12);
  EXPECT_DOUBLE_EQ(course.XAt(0.111), 0.002);
}

TEST(RandomMats, StayWithinWhatAProductionShows) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const EdgeShape shape = kShapes[seed % 6];
    const MatOptions o = RandomMats(shape, MatTexture{}, false, seed);
    EXPECT_EQ(o.shape, shape);
    const bool soft = shape == EdgeShape::kSlant || shape == EdgeShape::kDouble;
    EXPECT_GE(o.height_m, soft ? 0.5e-3 : 0.3e-3);
    EXPECT_LE(o.height_m, 1.1e-3);
    EXPECT_LE(std::abs(o.course.offset_m), 0.3 * 57e-3);
    EXPECT_LE(std::abs(o.course.slope), 0.05);
    EXPECT_GE((1.0 - o.double_share) * o.height_m, soft ? 0.3e-3 : 0.0);
    EXPECT_LE(o.texture.gloss, 1.0);
    EXPECT_LE(o.texture.darkness, 1.0);
    EXPECT_LE(std::abs(o.mould_x_m - o.course.offset_m), 0.1 * o.radius_m);
    EXPECT_NO_THROW(Mats(o, seed));
  }
}

// The largest deviation from the planned track and the steepest slope, over half a metre.
struct Extent {
  double deviation_m = 0.0;
  double slope = 0.0;
};
Extent ExtentOf(const EdgeCourse& course) {
  Extent extent;
  constexpr double kStep_m = 1e-3;
  for (double y = 0.0; y <= 0.5; y += kStep_m) {
    extent.deviation_m = std::max(extent.deviation_m, std::abs(course.XAt(y)));
    extent.slope =
        std::max(extent.slope, std::abs(course.XAt(y + kStep_m) - course.XAt(y)) / kStep_m);
  }
  return extent;
}

TEST(RandomMats, CurvedSeamsDeviateByCentimetresAndAreNeverSteep) {
  int beyond_two_cm = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const EdgeShape shape = kShapes[seed % 6];
    const MatOptions o = RandomMats(shape, MatTexture{}, true, seed);
    const bool mould = shape == EdgeShape::kConvex || shape == EdgeShape::kConcave;
    const Extent extent = ExtentOf(o.course);
    EXPECT_LT(extent.slope, 0.5);
    EXPECT_GE(extent.deviation_m, mould ? 5e-3 : 7e-3);
    EXPECT_LE(extent.deviation_m, mould ? 12e-3 : 33e-3);
    EXPECT_LE(std::abs(o.course.XAt(0.0)), 3e-3 + 1e-12);
    beyond_two_cm += extent.deviation_m > 0.02 ? 1 : 0;
  }
  EXPECT_GT(beyond_two_cm, 100);
}

TEST(RandomMats, DependOnTheSeedAndScaleWhatIsTypical) {
  MatTexture typical;
  const MatOptions a = RandomMats(EdgeShape::kStep, typical, true, 8);
  const MatOptions b = RandomMats(EdgeShape::kStep, typical, true, 8);
  EXPECT_EQ(a.height_m, b.height_m);
  EXPECT_EQ(a.course.waves.size(), b.course.waves.size());
  EXPECT_NE(a.height_m, RandomMats(EdgeShape::kStep, typical, true, 9).height_m);
  typical.fray_m = 0.0;
  typical.weave_relief_m *= 2.0;
  const MatOptions c = RandomMats(EdgeShape::kStep, typical, true, 8);
  EXPECT_EQ(c.texture.fray_m, 0.0);
  EXPECT_DOUBLE_EQ(c.texture.weave_relief_m, 2.0 * a.texture.weave_relief_m);
}

}  // namespace
}  // namespace rangegrasp::seam
