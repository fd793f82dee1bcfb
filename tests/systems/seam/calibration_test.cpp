#include "seam/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/rng.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::seam {
namespace {

using base::Rng;
using testing::AllOf;
using testing::HasSubstr;
using testing_support::MessageOf;

constexpr int kColumns = 1024;
constexpr double kLowest_m = -0.04;
constexpr double kHighest_m = 0.03;

// A pinhole camera that looks at the origin from `standoff_m` away, at an angle to the laser plane.
// x runs along the line, height points up.
struct Pinhole {
  double standoff_m = 0.2;
  double angle_rad = 0.6;
  double focal_px = 2400.0;  // 12 columns a mm at height 0
  double rows_up = 1.0;      // -1: rows fall with height

  double Depth(double height) const { return standoff_m - height * std::cos(angle_rad); }
  double RowOf(double height) const {
    return 511.5 + rows_up * focal_px * height * std::sin(angle_rad) / Depth(height);
  }
  double ColumnOf(double x, double height) const { return 511.5 + focal_px * x / Depth(height); }
  double LateralAt(double column, double height) const {
    return (column - 511.5) * Depth(height) / focal_px;
  }
  double RowsPerMeter(double height) const {
    return focal_px * standoff_m * std::sin(angle_rad) / (Depth(height) * Depth(height));
  }
};

// The largest error of the best 4th-order polynomial for the camera's function from row to height.
// The function is h = (d / cos a) (1 - 1 / (1 + v cot a)), with v proportional to the row. It has
// one pole, at u0 if the rows are mapped to [-1, 1]. The Chebyshev coefficients of 1 / (u0 - u) are
// 2 / sqrt(u0^2 - 1) r^-k with r = u0 + sqrt(u0^2 - 1). The error is the tail of this series from
// k = 5 on.
double BestError(const Pinhole& camera) {
  const double slope = std::cos(camera.angle_rad) / std::sin(camera.angle_rad);
  const auto v = [&](double height) {
    return height * std::sin(camera.angle_rad) / camera.Depth(height);
  };
  const double middle = 0.5 * (v(kHighest_m) + v(kLowest_m));
  const double half = 0.5 * (v(kHighest_m) - v(kLowest_m));
  const double pole = (1.0 / slope + middle) / half;  // distance from u = 0
  const double root = std::sqrt(pole * pole - 1.0);
  const double amplitude = camera.standoff_m / std::cos(camera.angle_rad) / (slope * half);
  return amplitude * 2.0 / root * std::pow(pole + root, -5.0) / (1.0 - 1.0 / (pole + root));
}

struct LookUp {
  std::vector<HeightSample> heights;
  std::vector<LateralSample> laterals;
};

LookUp Table(const Pinhole& camera) {
  LookUp table;
  for (int i = 0; i <= 40; ++i) {
    const double height = kLowest_m + (kHighest_m - kLowest_m) * i / 40;
    table.heights.push_back({camera.RowOf(height), height});
    for (const double x : {-0.02, 0.01}) {
      table.laterals.push_back({camera.ColumnOf(x, height), height, x});
    }
  }
  return table;
}

Calibration Fit(const Pinhole& camera) {
  const LookUp table = Table(camera);
  return FitCalibration(table.heights, table.laterals, kColumns);
}

TEST(Calibration, AFunctionOfFourthOrderFollowsAPinholeCamera) {
  for (const double rows_up : {1.0, -1.0}) {
    Pinhole camera;
    camera.rows_up = rows_up;
    const Calibration calibration = Fit(camera);
    // The error of a least-squares fit to uniform samples exceeds that of the best polynomial by at
    // most the factor 1 + Lebesgue constant. The constant is below 4 for 5 terms.
    const double tolerance = 5.0 * BestError(camera);
    EXPECT_LT(tolerance, 6e-6);
    for (double height = kLowest_m; height < kHighest_m; height += 1e-4) {
      EXPECT_NEAR(calibration.HeightAt(camera.RowOf(height)), height, tolerance);
    }
  }
}

TEST(Calibration, ColumnsWidenWithTheDistance) {
  // A pinhole's x is linear in height, so only rounding errors remain.
  const Pinhole camera;
  const Calibration calibration = Fit(camera);
  for (double height = kLowest_m; height < kHighest_m; height += 5e-3) {
    for (double column = 0.0; column < kColumns; column += 50.0) {
      EXPECT_NEAR(calibration.LateralAt(column, height), camera.LateralAt(column, height), 1e-13);
    }
  }
}

TEST(Calibration, GivesBackAnyFunctionOfFourthOrder) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Rng rng(seed);
    std::array<double, 5> truth{0.1 * rng.Normal(), 0.05};  // monotone: 0.05 > the others' slopes
    for (std::size_t k = 2; k < 5; ++k) truth[k] = 0.004 * rng.Uniform(-1.0, 1.0);
    std::vector<HeightSample> heights;
    for (int i = 0; i <= 60; ++i) {
      const double u = i / 30.0 - 1.0;
      double height = 0.0;
      for (std::size_t k = 5; k-- > 0;) height = height * u + truth[k];
      heights.push_back({200.0 + 10.0 * i, height});
    }
    const auto calibration = FitCalibration(heights, Table({}).laterals, kColumns);
    EXPECT_EQ(calibration.row_min_px, 200.0);
    EXPECT_EQ(calibration.row_max_px, 800.0);
    // Five well-scaled terms: the condition is about 20.
    for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(calibration.height_m[k], truth[k], 1e-14);
  }
}

TEST(Calibration, RowsThatWereNotSeenHaveNoHeight) {
  const Calibration calibration = Fit({});
  EXPECT_TRUE(std::isfinite(calibration.HeightAt(calibration.row_min_px)));
  EXPECT_TRUE(std::isfinite(calibration.HeightAt(calibration.row_max_px)));
  EXPECT_TRUE(std::isnan(calibration.HeightAt(calibration.row_min_px - 0.01)));
  EXPECT_TRUE(std::isnan(calibration.HeightAt(calibration.row_max_px + 0.01)));
  EXPECT_TRUE(std::isnan(calibration.HeightAt(std::nan(""))));
}

TEST(Calibration, PoorTablesAreRefused) {
  const LookUp table = Table({});
  const auto refusal = [&](const std::vector<HeightSample>& heights,
                           const std::vector<LateralSample>& laterals) {
    return MessageOf([&] { FitCalibration(heights, laterals, kColumns); });
  };
  EXPECT_EQ(refusal(table.heights, table.laterals), "");
  auto few = table.heights;
  few.resize(4);
  few.insert(few.end(), 10, few[0]);
  EXPECT_THAT(refusal(few, table.laterals), HasSubstr("4 distinct rows"));
  auto turning = table.heights;
  for (auto& sample : turning) sample.height_m = std::abs(sample.height_m);
  EXPECT_THAT(refusal(turning, table.laterals), HasSubstr("not monotonic"));
  EXPECT_THAT(refusal(table.heights, {table.laterals[0], table.laterals[2]}),
              HasSubstr("at least 3"));
  const std::vector<LateralSample> one_height{{100, 0, -0.01}, {511, 0, 0}, {900, 0, 0.01}};
  EXPECT_THAT(refusal(table.heights, one_height), HasSubstr("2 heights"));
  auto backwards = table.laterals;
  for (auto& sample : backwards) sample.x_m = -sample.x_m;
  EXPECT_THAT(refusal(table.heights, backwards), HasSubstr("do not increase"));
}

// Each camera ray hits the highest level that the body has at that place.
RawProfile ScanBody(const Pinhole& camera, const CalibrationBody& body, double base) {
  auto levels = body.step_heights_m;
  levels.push_back(0.0);
  std::sort(levels.rbegin(), levels.rend());
  const double left = -0.5 * body.step_width_m * static_cast<double>(body.step_heights_m.size());
  RawProfile profile{std::vector<float>(kColumns), 0.0};
  for (int column = 0; column < kColumns; ++column) {
    for (const double level : levels) {
      const double x = camera.LateralAt(column, base + level);
      const double step = std::floor((x - left) / body.step_width_m);
      const bool beside = step < 0.0 || step >= static_cast<double>(body.step_heights_m.size());
      const double here = beside ? 0.0 : body.step_heights_m[static_cast<std::size_t>(step)];
      if (here < level) continue;
      profile.row_px[static_cast<std::size_t>(column)] =
          static_cast<float>(camera.RowOf(base + level));
      break;
    }
  }
  return profile;
}

constexpr int kScans = 9;

std::vector<CalibrationScan> ScanBodies(const Pinhole& camera, const CalibrationBody& body) {
  std::vector<CalibrationScan> scans;
  for (int i = 0; i < kScans; ++i) {
    const double base = kLowest_m + (kHighest_m - 0.009 - kLowest_m) * i / (kScans - 1);
    scans.push_back({ScanBody(camera, body, base), base});
  }
  return scans;
}

void Disturb(std::vector<CalibrationScan>& scans, double sigma_px, double missing, Rng& rng) {
  for (auto& scan : scans) {
    for (float& row : scan.profile.row_px) {
      row += static_cast<float>(sigma_px * rng.Normal());
      if (rng.Uniform() < missing) row = std::numeric_limits<float>::quiet_NaN();
    }
  }
}

TEST(CalibrationBody, GivesThePinholeCameraBack) {
  for (const double rows_up : {1.0, -1.0}) {
    Pinhole camera;
    camera.rows_up = rows_up;
    const auto scans = ScanBodies(camera, {});
    const Calibration calibration = CalibrateFromBody({}, scans);
    EXPECT_EQ(calibration.columns, kColumns);
    // As above. Rows are floats below 1024, so they are off by at most 3e-5 px, which is 3e-9 m.
    const double tolerance = 5.0 * BestError(camera) + 1e-8;
    for (double height = kLowest_m + 1e-4; height < kHighest_m - 1e-4; height += 1e-4) {
      EXPECT_NEAR(calibration.HeightAt(camera.RowOf(height)), height, tolerance);
    }
    // A riser is located to half a column of 1 / 12 mm. The risers reach 20 mm to either side; the
    // ends of the line are 2.2 times as far out.
    for (const double column : {0.0, 200.0, 511.5, 1023.0}) {
      for (const double height : {kLowest_m, 0.0, kHighest_m}) {
        EXPECT_NEAR(calibration.LateralAt(column, height), camera.LateralAt(column, height),
                    2.2 * 0.5 / 12e3);
      }
    }
  }
}

TEST(CalibrationBody, IsFoundUnderNoiseAndWithMissingColumns) {
  const Pinhole camera;
  const auto clean = ScanBodies(camera, {});
  // The median of the 60 or more points of a plateau has a standard deviation of 1.2533 * 0.5 /
  // sqrt(60) px. A row is at most 1 / RowsPerMeter(lowest). 9 * 7 plateaus determine 5 terms, so
  // the leverage at the ends is at most 25 / 63 (that of a Legendre fit).
  const double plateau_m = 1.2533 * 0.5 / std::sqrt(60.0) / camera.RowsPerMeter(kLowest_m);
  const double tolerance = 5.0 * plateau_m * std::sqrt(25.0 / 63.0) + 5.0 * BestError(camera);
  EXPECT_LT(tolerance, 60e-6);  // a row there is 0.2 mm
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    auto scans = clean;
    Disturb(scans, 0.5, 0.03, rng);
    const Calibration calibration = CalibrateFromBody({}, scans);
    double squares = 0.0;
    int heights = 0;
    for (double height = kLowest_m + 5e-4; height < kHighest_m - 5e-4; height += 1e-3, ++heights) {
      const double error = calibration.HeightAt(camera.RowOf(height)) - height;
      EXPECT_NEAR(error, 0.0, tolerance) << "seed " << seed << " height " << height;
      squares += error * error;
    }
    // The average leverage is 5 / 63.
    EXPECT_LT(std::sqrt(squares / heights), 2.0 * plateau_m * std::sqrt(5.0 / 63.0) + 2e-6) << seed;
  }
}

// Step heights twice too large: the scans have the true heights, and no function of the row gives
// the other half, so nearly the standard deviation of the steps remains.
TEST(CalibrationBody, ItsResidualShowsWrongStepHeights) {
  const Pinhole camera;
  const auto scans = ScanBodies(camera, {});
  CalibrationBody wrong;
  for (double& height : wrong.step_heights_m) height *= 2.0;
  const auto& steps = CalibrationBody{}.step_heights_m;
  double sum = 0.0;
  double squares = 0.0;
  for (const double height : steps) {
    sum += height;
    squares += height * height;
  }
  const auto count = static_cast<double>(steps.size());
  const double deviation = std::sqrt(squares / count - sum * sum / (count * count));
  const double tolerance = 5.0 * BestError(camera) + 1e-8;  // as above
  EXPECT_LT(CalibrateFromBody({}, scans).residual_m, tolerance);
  const double residual = CalibrateFromBody(wrong, scans).residual_m;
  EXPECT_GT(residual, 0.8 * deviation);
  EXPECT_LT(residual, deviation + tolerance);
}

TEST(CalibrationBody, AScanWithoutTheBodyIsNamed) {
  const Pinhole camera;
  const auto expect_refused = [&](std::vector<float> rows) {
    auto scans = ScanBodies(camera, {});
    scans[2].profile.row_px = std::move(rows);
    EXPECT_THAT(MessageOf([&] { CalibrateFromBody({}, scans); }), HasSubstr("scan 3"));
  };
  const float nothing = std::numeric_limits<float>::quiet_NaN();
  expect_refused(std::vector<float>(kColumns, nothing));
  expect_refused(std::vector<float>(kColumns, 500.0F));
  expect_refused(std::vector<float>(kColumns - 1, 500.0F));
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Rng rng(seed);
    std::vector<float> noise(kColumns);
    for (float& row : noise) row = static_cast<float>(500.0 + 0.5 * rng.Normal());
    expect_refused(noise);
  }
  auto half = ScanBodies(camera, {})[2].profile.row_px;
  std::fill(half.begin() + 512, half.end(), nothing);
  expect_refused(half);
  auto covered = ScanBodies(camera, {})[2].profile.row_px;  // something covers the body
  std::fill(covered.begin() + 620, covered.begin() + 700, covered[511]);
  expect_refused(covered);
  auto stretched = ScanBodies(camera, {})[2].profile.row_px;  // the body moved during the scan
  stretched.insert(stretched.begin() + 600, 120, stretched[600]);
  stretched.resize(kColumns);
  expect_refused(stretched);
}

TEST(CalibrationBody, NoStepsAreRefused) {
  EXPECT_THAT(MessageOf([] {
                CalibrateFromBody({{0.0, 0.0}, 0.008}, ScanBodies({}, {}));
              }),
              HasSubstr("step"));
}

TEST(Calibrate, TurnsRowsIntoHeights) {
  const Pinhole camera;
  const Calibration calibration = Fit(camera);
  RawProfile raw{std::vector<float>(kColumns, static_cast<float>(camera.RowOf(0.01))), 2.5};
  raw.row_px[7] = std::numeric_limits<float>::quiet_NaN();
  raw.row_px[8] = 1e6F;
  const Profile profile = Calibrate(raw, calibration);
  EXPECT_EQ(profile.time_s, 2.5);
  ASSERT_EQ(profile.height_m.size(), raw.row_px.size());
  EXPECT_TRUE(std::isnan(profile.height_m[7]));
  EXPECT_TRUE(std::isnan(profile.height_m[8]));
  EXPECT_NEAR(profile.height_m[9], 0.01, 6e-6);
  raw.row_px.pop_back();
  EXPECT_THAT(MessageOf([&] { Calibrate(raw, calibration); }),
              AllOf(HasSubstr("1023"), HasSubstr("1024")));
}

TEST(CalibrationFile, GivesBackEveryDigit) {
  const testing_support::TempFolder folder;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Rng rng(seed);
    Calibration written;
    written.columns = static_cast<int>(32 + rng.Index(4000));
    written.row_min_px = 100.0 * rng.Uniform();
    written.row_max_px = 200.0 + 1000.0 * rng.Uniform();
    for (double& c : written.height_m) c = rng.Normal() * std::pow(10.0, rng.Uniform(-12.0, 0.0));
    written.meters_per_column = {1e-4 * (0.1 + rng.Uniform()), rng.Normal()};
    WriteCalibration(written, folder / "calibration.yaml");
    const Calibration read = ReadCalibration(folder / "calibration.yaml");
    EXPECT_EQ(read.columns, written.columns);
    EXPECT_EQ(read.row_min_px, written.row_min_px);
    EXPECT_EQ(read.row_max_px, written.row_max_px);
    EXPECT_EQ(read.height_m, written.height_m);
    EXPECT_EQ(read.meters_per_column, written.meters_per_column);
  }
}

TEST(CalibrationFile, ErrorsNameFileAndKey) {
  const testing_support::TempFolder folder;
  const auto file = folder / "calibration.yaml";
  WriteCalibration(Fit({}), file);
  const std::string good = base::ReadFile(file);
  const auto refusal = [&](const std::string& text) {
    folder.Write("changed.yaml", text);
    return MessageOf([&] { ReadCalibration(folder / "changed.yaml"); });
  };
  EXPECT_EQ(refusal(good), "");
  for (const std::string key :
       {"columns", "row_min_px", "row_max_px", "height_0_m", "height_1_m", "height_2_m",
        "height_3_m", "height_4_m", "meters_per_column", "meters_per_column_per_m"}) {
    const auto begin = good.find("\n" + key + ":") + 1;
    const auto end = good.find('\n', begin);
    for (const std::string& line :
         {std::string(), key + ": many", key + ": .nan", key + ": 1e99"}) {
      EXPECT_THAT(refusal(good.substr(0, begin) + line + good.substr(end)),
                  AllOf(HasSubstr("changed.yaml"), HasSubstr(key)))
          << line;
    }
  }
  EXPECT_THAT(refusal(good + "height_5_m: 0\n"), HasSubstr("height_5_m"));
  EXPECT_THAT(MessageOf([&] { ReadCalibration(folder / "none.yaml"); }), HasSubstr("none.yaml"));
  WriteCalibration(Fit({}), folder / "new/folder.yaml");
  EXPECT_THROW(WriteCalibration(Fit({}), folder / "new/folder.yaml/file.yaml"), base::InputError);
}

}  // namespace
}  // namespace rangegrasp::seam
