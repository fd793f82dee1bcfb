#include "seam/profile.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/rng.h"

namespace rangegrasp::seam {
namespace {

using base::Rng;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::uint64_t kPreprocessSeeds = 100;

// These options are set here because the defaults may be tuned.
constexpr FilterOptions kOptions = {8, 0.2e-3, 6};

// Equal to the last bit, including NaNs.
bool SameBits(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](float x, float y) {
    return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y);
  });
}

std::vector<float> PreprocessRandomProfile(std::size_t m, Rng& rng) {
  const double missing = 0.4 * rng.Uniform();
  std::vector<float> z(m);
  for (float& height : z) {
    height = static_cast<float>(1e-4 * rng.Normal());
    if (rng.Uniform() < 0.1) height += static_cast<float>(1e-3 * rng.Normal());
    if (rng.Uniform() < missing) height = kNaN;
    if (rng.Uniform() < 0.01) height = rng.Index(2) == 0 ? kInfinity : -kInfinity;
  }
  return z;
}

double U(std::size_t i, std::size_t m) {
  return m < 2 ? 0.0 : 2.0 * static_cast<double>(i) / static_cast<double>(m - 1) - 1.0;
}

double Curve(const std::array<double, 3>& c, double u) { return c[0] + u * c[1] + u * u * c[2]; }

std::vector<float> Parabola(std::size_t m, const std::array<double, 3>& c) {
  std::vector<float> z(m);
  for (std::size_t i = 0; i < m; ++i) z[i] = static_cast<float>(Curve(c, U(i, m)));
  return z;
}

std::vector<float> DirectFilter(const std::vector<float>& z, const FilterOptions& options) {
  const auto m = static_cast<int>(z.size());
  const auto half_height = static_cast<float>(options.half_height_m);
  std::vector<float> kept(z.size(), kNaN);
  for (int i = 0; i < m; ++i) {
    const float height = z[static_cast<std::size_t>(i)];
    if (!std::isfinite(height)) continue;
    int others = 0;
    for (int j = 0; j < m; ++j) {
      if (j == i || std::abs(j - i) > options.half_width_columns) continue;
      if (std::abs(z[static_cast<std::size_t>(j)] - height) <= half_height) ++others;
    }
    if (others >= options.min_neighbors) kept[static_cast<std::size_t>(i)] = height;
  }
  return kept;
}

TEST(GeometricFilter, CountsTheNeighboursInTheRectangle) {
  for (std::uint64_t seed = 0; seed < kPreprocessSeeds; ++seed) {
    Rng rng(seed);
    auto z = PreprocessRandomProfile(rng.Index(150), rng);
    FilterOptions options{static_cast<int>(1 + rng.Index(40)), 3e-4 * rng.Uniform() + 1e-6,
                          static_cast<int>(rng.Index(20))};
    if (seed % 2 == 0) {  // a grid, so that heights lie on the rectangle's border, which is in
      for (float& height : z) height = std::ldexp(std::round(std::ldexp(height, 14)), -14);
      options.half_height_m = std::ldexp(1.0, -13);
    }
    EXPECT_TRUE(SameBits(FilterGeometric(z, options), DirectFilter(z, options))) << seed;
  }
}

TEST(GeometricFilter, AWindowWiderThanTheProfileIsTheWholeProfile) {
  Rng rng(1);
  const auto z = PreprocessRandomProfile(50, rng);
  FilterOptions options;
  options.half_width_columns = std::numeric_limits<int>::max();
  EXPECT_TRUE(SameBits(FilterGeometric(z, options), DirectFilter(z, options)));
}

TEST(GeometricFilter, DropsFilamentsAndKeepsAStep) {
  std::vector<float> step(1024, 0.0F);
  std::fill(step.begin() + 400, step.end(), 1e-3F);
  EXPECT_TRUE(SameBits(FilterGeometric(step, kOptions), step));
  auto frayed = step;
  for (std::size_t i = 100; i < 106; ++i) frayed[i] = 2e-3F;  // five neighbors are too few
  const auto kept = FilterGeometric(frayed, kOptions);
  for (std::size_t i = 0; i < frayed.size(); ++i) {
    EXPECT_EQ(std::isnan(kept[i]), i >= 100 && i < 106) << i;
  }
}

// Solves the fit by a Householder QR decomposition of the powers of the column coordinates.
std::array<double, 3> DirectQuadratic(const std::vector<float>& z) {
  std::vector<std::size_t> there;
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (std::isfinite(z[i])) there.push_back(i);
  }
  Eigen::MatrixX3d powers(static_cast<Eigen::Index>(there.size()), 3);
  Eigen::VectorXd heights(powers.rows());
  for (Eigen::Index row = 0; row < powers.rows(); ++row) {
    const std::size_t i = there[static_cast<std::size_t>(row)];
    const double u = U(i, z.size());
    powers.row(row) << 1.0, u, u * u;
    heights(row) = static_cast<double>(z[i]);
  }
  const Eigen::Vector3d c = powers.colPivHouseholderQr().solve(heights);
  return {c(0), c(1), c(2)};
}

TEST(QuadraticFit, IsTheLeastSquaresFitOfAnotherSolver) {
  for (std::uint64_t seed = 0; seed < kPreprocessSeeds; ++seed) {
    Rng rng(seed);
    const std::size_t m = 40 + rng.Index(1000);
    auto z = Parabola(m, {rng.Normal(), rng.Normal(), rng.Normal()});
    const auto noise = PreprocessRandomProfile(m, rng);
    for (std::size_t i = 0; i < m; ++i) z[i] += noise[i];
    // A hole at one end that covers up to half of the profile.
    std::fill_n(z.begin(), rng.Index(m / 2), kNaN);
    const auto c = FitQuadratic(z);
    const auto direct = DirectQuadratic(z);
    // Over the range of the points, the normal equations have a condition number below 1e3. If half
    // a profile is expressed in the u of the whole one, errors grow by (1 + |q| + p)^2 < 25, where
    // p and q are the coefficients of the substitution.
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(c[k], direct[k], 1e3 * 25 * 1e-15) << seed;
  }
}

TEST(QuadraticFit, GivesBackAParabola) {
  for (std::uint64_t seed = 0; seed < kPreprocessSeeds; ++seed) {
    Rng rng(seed);
    const std::array<double, 3> truth{rng.Normal(), rng.Normal(), rng.Normal()};
    const auto c = FitQuadratic(Parabola(3 + rng.Index(1000), truth));
    // Heights are floats of at most about 10, so each is off by up to 5e-7. With three points the
    // curve's coefficients are off by at most twice that.
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(c[k], truth[k], 1e-6) << seed;
  }
}

TEST(QuadraticFit, FewPointsGiveTheCurveOfLeastOrderThroughThem) {
  EXPECT_EQ(FitQuadratic({}), (std::array<double, 3>{}));
  EXPECT_EQ(FitQuadratic(std::vector<float>(20, kNaN)), (std::array<double, 3>{}));
  EXPECT_EQ(FitQuadratic(std::vector<float>{0.5F}), (std::array<double, 3>{0.5, 0.0, 0.0}));
  for (std::uint64_t seed = 0; seed < kPreprocessSeeds; ++seed) {
    Rng rng(seed);
    const std::size_t m = 8 + rng.Index(1000);
    std::vector<float> z(m, kNaN);
    const std::size_t at = rng.Index(m);
    z[at] = 0.25F;
    EXPECT_EQ(FitQuadratic(z), (std::array<double, 3>{0.25, 0.0, 0.0}));
    z[(at + 1 + rng.Index(m - 1)) % m] = -0.5F;
    for (int points = 2; points <= 3; ++points) {
      const auto c = FitQuadratic(z);
      if (points == 2) {
        EXPECT_EQ(c[2], 0.0) << seed;
      }
      // The largest value that cancels is that of the steepest curve, which passes through
      // neighbouring columns: 0.75 (m/2)^2 < 2e5, times 2^-52.
      for (std::size_t i = 0; i < m; ++i) {
        if (!std::isfinite(z[i])) continue;
        EXPECT_NEAR(Curve(c, U(i, m)), z[i], 1e-9) << seed;
      }
      std::size_t third = 0;
      while (std::isfinite(z[third])) ++third;
      z[third] = 1.0F;
    }
  }
}

TEST(Holes, EndHalfwayBetweenTheirNeighbours) {
  std::vector<float> z{kNaN, kNaN, 1.0F, kNaN, kNaN, kNaN, kNaN, 2.0F, kNaN, 3.0F, kNaN};
  FillHoles(z);
  EXPECT_EQ(z, (std::vector<float>{1, 1, 1, 1, 1, 2, 2, 2, 3, 3, 3}));
}

TEST(Holes, AreFilledWithTheNearestHeightsAndNothingElseChanges) {
  for (std::uint64_t seed = 0; seed < kPreprocessSeeds; ++seed) {
    Rng rng(seed);
    const auto m = static_cast<int>(1 + rng.Index(120));
    const auto z = PreprocessRandomProfile(static_cast<std::size_t>(m), rng);
    auto filled = z;
    FillHoles(filled);
    if (std::none_of(z.begin(), z.end(), [](float height) { return std::isfinite(height); })) {
      EXPECT_TRUE(SameBits(filled, z)) << seed;
      continue;
    }
    for (int i = 0; i < m; ++i) {
      int distance = 0;
      bool matches = false;
      for (; distance < m; ++distance) {
        bool found = false;
        for (const int j : {i - distance, i + distance}) {
          if (j < 0 || j >= m || !std::isfinite(z[static_cast<std::size_t>(j)])) continue;
          found = true;
          matches |= filled[static_cast<std::size_t>(i)] == z[static_cast<std::size_t>(j)];
        }
        if (found) break;
      }
      EXPECT_TRUE(matches) << "seed " << seed << " column " << i;
    }
  }
}

TEST(Prepare, KeepsTheOriginalToTheLastBit) {
  for (std::uint64_t seed = 0; seed < kPreprocessSeeds; ++seed) {
    Rng rng(seed);
    const Profile profile{PreprocessRandomProfile(300, rng), 1.5};
    const auto prepared = Prepare(profile, kOptions);
    EXPECT_TRUE(SameBits(prepared.original_m, profile.height_m)) << seed;
    EXPECT_EQ(prepared.time_s, 1.5);
  }
}

TEST(Prepare, IsFilterThenNormalisationThenFilling) {
  for (std::uint64_t seed = 0; seed < kPreprocessSeeds; ++seed) {
    Rng rng(seed);
    Profile profile{Parabola(400, {1e-2, 1e-3 * rng.Normal(), 1e-3 * rng.Normal()}), 0.0};
    const auto noise = PreprocessRandomProfile(400, rng);
    for (std::size_t i = 0; i < noise.size(); ++i) profile.height_m[i] += noise[i];
    // For a profile with holes, the required number of neighbours is reduced in proportion.
    FilterOptions filter = kOptions;
    const auto there = std::count_if(profile.height_m.begin(), profile.height_m.end(),
                                     [](float height) { return std::isfinite(height); });
    filter.min_neighbors =
        static_cast<int>(std::ceil(filter.min_neighbors * static_cast<double>(there) / 400.0));
    const auto filtered = FilterGeometric(profile.height_m, filter);
    const auto prepared = Prepare(profile, kOptions);
    ASSERT_TRUE(prepared.Usable()) << seed;
    const auto curve = FitQuadratic(filtered);
    auto expected = filtered;
    std::vector<int> points;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      expected[i] -= static_cast<float>(Curve(curve, U(i, expected.size())));
      if (std::isfinite(filtered[i])) points.push_back(static_cast<int>(i));
    }
    EXPECT_EQ(prepared.first_column, points.front()) << seed;
    EXPECT_EQ(prepared.last_column, points.back()) << seed;
    FillHoles(expected);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_TRUE(std::isfinite(prepared.height_m[i]));
      // Heights are at most 0.03 m. The difference may round to the neighbouring float, 2^-29 away.
      ASSERT_NEAR(prepared.height_m[i], expected[i], 4e-9) << "seed " << seed << " column " << i;
    }
  }
}

TEST(Prepare, FlattensACurveAndKeepsItsStep) {
  // Mats on a cylinder of radius 30 mm, seen over 20 mm (sag 1.7 mm), with an edge of 0.5 mm.
  Profile profile;
  for (int i = 0; i < 1024; ++i) {
    const double x = 20e-3 * (i / 1023.0 - 0.5);
    profile.height_m.push_back(
        static_cast<float>(std::sqrt(30e-3 * 30e-3 - x * x) + (i >= 500 ? 5e-4 : 0.0)));
  }
  const auto prepared = Prepare(profile, kOptions);
  ASSERT_TRUE(prepared.Usable());
  // The curve is smooth. Between two columns it changes by its slope, (x/30 + the share of the
  // 0.5 mm) times 20 um.
  EXPECT_NEAR(prepared.height_m[500] - prepared.height_m[499], 5e-4, 1e-5);
  const auto [low, high] = std::minmax_element(prepared.height_m.begin(), prepared.height_m.end());
  EXPECT_LT(*high - *low, 1e-3);
}

TEST(Prepare, TooFewPointsAreUnusable) {
  Profile profile{std::vector<float>(200, kNaN), 0.0};
  std::fill_n(profile.height_m.begin() + 50, 127, 1e-3F);
  const auto few = Prepare(profile, kOptions);
  EXPECT_FALSE(few.Usable());
  EXPECT_EQ(few.original_m.size(), 200u);
  profile.height_m[177] = 1e-3F;
  EXPECT_TRUE(Prepare(profile, kOptions).Usable());
  EXPECT_FALSE(Prepare({{}, 0.0}, kOptions).Usable());
}

}  // namespace
}  // namespace rangegrasp::seam
