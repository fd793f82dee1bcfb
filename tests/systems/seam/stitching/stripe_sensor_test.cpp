#include "seam/stitching/stripe_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "error_of.h"
#include "seam/stitching/mats.h"
#include "seam/stitching/smooth_mats.h"
#include "temp_folder.h"

namespace rangegrasp::seam {
namespace {

// A sensor without disturbances.
StripeSensorOptions Perfect() {
  StripeSensorOptions options;
  options.row_sigma_px = 0.0;
  options.row_quantum_px = 0.0;
  options.speckle = 0.0;
  options.lost_return = 0.0;
  options.outlier_share = 0.0;
  options.phantom_share = 0.0;
  return options;
}

std::vector<float> RowsOf(const StripeSensor& sensor, const Mats& mats, int scans,
                          std::uint64_t seed, const RawProfile* previous = nullptr) {
  base::Rng rng(seed);
  std::vector<float> rows;
  for (int i = 0; i < scans; ++i) {
    const auto profile = sensor.Scan(mats, {}, 0.0, previous, rng);
    rows.insert(rows.end(), profile.row_px.begin(), profile.row_px.end());
  }
  return rows;
}

double ShareMissing(const std::vector<float>& rows) {
  const auto missing = std::count_if(rows.begin(), rows.end(), [](float r) { return r != r; });
  return static_cast<double>(missing) / static_cast<double>(rows.size());
}

// The reference is a projection matrix K [R | t]: the camera is at the standoff from the origin of
// L, and its optical axis is at the angle to the laser plane (y = 0).
TEST(StripeSensor, RowsAndColumnsAreAPinholeProjection) {
  const StripeSensor sensor(Perfect());
  const StripeSensorOptions& o = sensor.options();
  const double s = std::sin(o.angle_rad);
  const double c = std::cos(o.angle_rad);
  Eigen::Matrix3d rotation;
  rotation << 1.0, 0.0, 0.0, 0.0, c, s, 0.0, s, -c;
  const Eigen::Vector3d camera = o.standoff_m * Eigen::Vector3d(0.0, -s, c);
  Eigen::Matrix3d intrinsics = Eigen::Matrix3d::Identity();
  intrinsics(0, 0) = intrinsics(1, 1) = o.line.columns_per_m * o.standoff_m;
  intrinsics(0, 2) = 0.5 * (o.line.columns - 1);
  intrinsics(1, 2) = 0.5 * (o.rows - 1);
  for (double x = -0.04; x <= 0.04; x += 0.01) {
    for (double z = -0.04; z <= 0.03; z += 0.01) {
      const Eigen::Vector3d p = intrinsics * rotation * (Eigen::Vector3d(x, 0.0, z) - camera);
      EXPECT_NEAR(sensor.ColumnOf(x, z), p.x() / p.z(), 1e-9);
      EXPECT_NEAR(sensor.RowOf(z), p.y() / p.z(), 1e-9);
      EXPECT_NEAR(sensor.LateralAt(sensor.ColumnOf(x, z), z), x, 1e-12);
    }
  }
}

// The plane z = tan(t) x meets the column's ray x = k (D - z cos a) in closed form.
TEST(StripeSensor, AScanOfATiltedPlaneIsExact) {
  MatOptions mat = Smooth(EdgeShape::kNone);
  mat.tilt_rad = 0.1;
  const Mats mats(mat, 1);
  const StripeSensor sensor(Perfect());
  const StripeSensorOptions& o = sensor.options();
  const auto rows = RowsOf(sensor, mats, 1, 1);
  const double slope = std::tan(mat.tilt_rad);
  for (int column = 0; column < o.line.columns; ++column) {
    const double k = o.line.ToMeters(column) / o.standoff_m;
    const double x = k * o.standoff_m / (1.0 + k * slope * std::cos(o.angle_rad));
    // The position along the line is good to 5 um and a float row to 6e-5.
    ASSERT_NEAR(rows[static_cast<std::size_t>(column)], sensor.RowOf(slope * x),
                5e-6 * slope * 7e3 + 1e-4)
        << column;
  }
}

TEST(StripeSensor, AStepIsSeenInItsColumnAtItsHeight) {
  MatOptions mat = Smooth(EdgeShape::kStep);
  mat.course.offset_m = 0.01;
  const StripeSensor sensor(Perfect());
  const auto rows = RowsOf(sensor, Mats(mat, 1), 1, 1);
  // Allows up to one column for the step's width and one for positions between columns.
  const auto edge = static_cast<std::size_t>(sensor.ColumnOf(0.01, 0.5 * mat.height_m));
  EXPECT_NEAR(rows[edge - 2], sensor.RowOf(0.0), 1e-3);
  EXPECT_NEAR(rows[edge + 3], sensor.RowOf(mat.height_m), 1e-3);
}

TEST(StripeSensor, TheHeadingTurnsTheLineCounterClockwise) {
  MatOptions mat = Smooth(EdgeShape::kNone);
  mat.obstacles = {{0.0, 0.02, 0.004, 0.004, 0.004}};
  const Mats mats(mat, 1);
  const StripeSensor sensor(Perfect());
  base::Rng rng(1);
  LinePose pose;
  pose.heading_rad = 0.5 * 3.14159265358979;
  const auto rows = sensor.Scan(mats, pose, 0.0, nullptr, rng).row_px;
  EXPECT_NEAR(rows[static_cast<std::size_t>(sensor.ColumnOf(0.02, 0.004))], sensor.RowOf(0.004),
              1e-3);
  EXPECT_NEAR(rows[static_cast<std::size_t>(sensor.ColumnOf(-0.02, 0.0))], sensor.RowOf(0.0), 1e-3);
}

TEST(StripeSensor, HeightsCountFromTheLinesOwnFrame) {
  const Mats mats(Smooth(EdgeShape::kNone), 1);
  const StripeSensor sensor(Perfect());
  base::Rng rng(1);
  LinePose pose;
  pose.height_m = 0.004;
  EXPECT_NEAR(sensor.Scan(mats, pose, 0.0, nullptr, rng).row_px[500], sensor.RowOf(-0.004), 1e-3);
  pose.height_m = 1.0;  // far below the camera's view
  EXPECT_EQ(ShareMissing(sensor.Scan(mats, pose, 0.0, nullptr, rng).row_px), 1.0);
}

// With 100,000 spots, the standard deviation is known to 0.22 %.
TEST(StripeSensor, RowNoiseGrowsAsReturnFalls) {
  StripeSensorOptions options = Perfect();
  options.row_sigma_px = 0.4;
  const StripeSensor sensor(options);
  for (const double darkness : {0.0, 0.8}) {
    MatOptions mat = Smooth(EdgeShape::kNone);
    mat.texture.darkness = darkness;
    const Mats mats(mat, 1);
    double sum = 0.0;
    const auto rows = RowsOf(sensor, mats, 100, 3);
    for (const float row : rows) sum += std::pow(row - sensor.RowOf(0.0), 2);
    const double expected = 0.4 / std::sqrt(mats.At(0.0, 0.0).return_strength);
    EXPECT_NEAR(std::sqrt(sum / static_cast<double>(rows.size())), expected, 0.012 * expected);
  }
}

TEST(StripeSensor, RowsAreMultiplesOfTheQuantum) {
  StripeSensorOptions options = Perfect();
  options.row_sigma_px = 1.0;
  options.row_quantum_px = 0.25;
  const auto rows = RowsOf(StripeSensor(options), Mats(Smooth(EdgeShape::kNone), 1), 1, 3);
  for (const float row : rows) EXPECT_EQ(row * 4.0F, std::round(row * 4.0F));
}

// The strength is 1 - c + c e with an exponentially distributed e. It is below the limit l with the
// probability 1 - exp(-(l - 1 + c) / c).
TEST(StripeSensor, SpeckleLosesTheShareOfSpotsThatItsContrastPromises) {
  const Mats mats(Smooth(EdgeShape::kNone), 1);
  struct Case {
    double contrast, limit, share;
  };
  for (const Case& k : {Case{1.0, 0.2, 1.0 - std::exp(-0.2)}, Case{0.8, 0.4, 1.0 - std::exp(-0.25)},
                        Case{0.5, 0.4, 0.0}}) {
    StripeSensorOptions options = Perfect();
    options.speckle = k.contrast;
    options.lost_return = k.limit;
    const double lost = ShareMissing(RowsOf(StripeSensor(options), mats, 100, 4));
    EXPECT_NEAR(lost, k.share, 5.0 * 0.5 / std::sqrt(102'400.0));
  }
}

TEST(StripeSensor, NothingComesBackFromSteepSlopes) {
  const StripeSensor sensor(Perfect());
  const auto rows = RowsOf(sensor, Mats(Smooth(EdgeShape::kConvex), 1), 1, 1);
  EXPECT_TRUE(std::isnan(rows.front()));
  EXPECT_TRUE(std::isnan(rows.back()));
  EXPECT_TRUE(std::isfinite(rows[512]));
}

struct Runs {
  double share = 0.0;
  double mean_length = 0.0;
  double sigma_px = 0.0;
};
Runs OutliersOf(const std::vector<float>& rows, double row) {
  double columns = 0.0;
  double runs = 0.0;
  double sum = 0.0;
  bool before = false;
  for (const float r : rows) {
    const bool off = std::abs(r - row) > 1e-2;
    columns += off ? 1.0 : 0.0;
    runs += off && !before ? 1.0 : 0.0;
    sum += std::pow(r - row, 2);
    before = off;
  }
  return {columns / static_cast<double>(rows.size()), columns / runs, std::sqrt(sum / columns)};
}

// With 400,000 columns and about 5,000 runs, the mean length is known to 1.3 %, a share to 1.9 %.
TEST(StripeSensor, ReflectionsComeInRunsWithTheirShareAndLength) {
  StripeSensorOptions options = Perfect();
  options.outlier_share = 0.05;
  options.outlier_run_columns = 4.0;
  options.outlier_sigma_px = 40.0;
  const StripeSensor sensor(options);
  const Runs runs =
      OutliersOf(RowsOf(sensor, Mats(Smooth(EdgeShape::kNone), 1), 400, 5), sensor.RowOf(0.0));
  EXPECT_NEAR(runs.share, 0.05, 0.1 * 0.05);
  EXPECT_NEAR(runs.mean_length, 4.0, 0.07 * 4.0);
  EXPECT_NEAR(runs.sigma_px, 40.0, 0.07 * 40.0);
  options.outlier_share = 0.4;
  const StripeSensor often(options);
  EXPECT_NEAR(
      OutliersOf(RowsOf(often, Mats(Smooth(EdgeShape::kNone), 1), 400, 5), often.RowOf(0.0)).share,
      0.4, 0.05 * 0.4);
}

// Every spot is lost. The previous line was in row 100 in all columns.
TEST(StripeSensor, PhantomsShowThePreviousLineOrAnyRow) {
  StripeSensorOptions options = Perfect();
  options.lost_return = 0.5;
  options.phantom_share = 0.8;
  options.phantom_previous_share = 0.25;
  const StripeSensor sensor(options);
  MatOptions mat = Smooth(EdgeShape::kNone);
  mat.texture.darkness = 1.0;
  const RawProfile previous{std::vector<float>(1024, 100.0F), 0.0};
  const auto rows = RowsOf(sensor, Mats(mat, 1), 100, 6, &previous);
  const auto n = static_cast<double>(rows.size());
  EXPECT_NEAR(ShareMissing(rows), 0.2, 0.01);
  EXPECT_NEAR(static_cast<double>(std::count(rows.begin(), rows.end(), 100.0F)) / n, 0.2, 0.01);
  const auto high = std::count_if(rows.begin(), rows.end(), [](float r) { return r > 767.0F; });
  EXPECT_NEAR(static_cast<double>(high) / n, 0.6 * 0.25, 0.01);
}

TEST(StripeSensor, AScanDependsOnItsArgumentsAndTheStreamAlone) {
  const Mats mats(RandomMats(EdgeShape::kStep, MatTexture{}, false, 3), 2);
  const StripeSensor sensor{StripeSensorOptions{}};
  const auto a = RowsOf(sensor, mats, 2, 9);
  const auto b = RowsOf(sensor, mats, 2, 9);
  const auto c = RowsOf(sensor, mats, 2, 10);
  int differ = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_TRUE(a[i] == b[i] || (a[i] != a[i] && b[i] != b[i]));
    differ += a[i] == c[i] ? 0 : 1;
  }
  EXPECT_GT(differ, 1000);
}

TEST(StripeSensor, DarkMatsAreMeasuredLessOften) {
  const StripeSensor sensor{StripeSensorOptions{}};
  MatTexture texture;
  texture.darkness = 0.0;
  EXPECT_DOUBLE_EQ(sensor.Rate(texture), 100.0);
  texture.darkness = 1.0;
  EXPECT_DOUBLE_EQ(sensor.Rate(texture), 30.0);
}

// Each plateau's row is the median of about 90 columns with 0.06 mm noise, so its error is 7 um.
// The fit to 60 plateaus reduces this to 2 um. The 4th-order function itself is good to 3 um here.
TEST(StripeSensor, CalibrationInvertsTheCamera) {
  for (const double columns_per_m : {12'000.0, 18'000.0}) {
    StripeSensorOptions options;
    options.line.columns_per_m = columns_per_m;
    const StripeSensor sensor(options);
    base::Rng rng(1);
    const Calibration calibration = CalibrateFromBody({}, sensor.ScanBody({}, 9, rng));
    for (double z = -options.range_below_m + 1e-3; z < options.range_above_m - 1e-3; z += 1e-3) {
      EXPECT_NEAR(calibration.HeightAt(sensor.RowOf(z)), z, 12e-6) << z;
    }
    for (double x = -0.02; x <= 0.02; x += 0.005) {
      for (const double z : {-0.02, 0.0, 0.02}) {
        EXPECT_NEAR(calibration.LateralAt(sensor.ColumnOf(x, z), z), x, 0.5 / columns_per_m);
      }
    }
  }
}

void ExpectError(const std::string& text, const std::vector<std::string>& parts) {
  const testing_support::TempFolder folder;
  const auto file = folder.Write("sensor.yaml", text);
  const std::string error = testing_support::ErrorOf([&] { ReadStripeSensor(file); });
  for (const std::string& part : parts) EXPECT_THAT(error, testing::HasSubstr(part));
}

TEST(StripeSensorFile, FaultsNameLineKeyAndWhatWouldBeRight) {
  ExpectError("name: a\nrow_sigma: 1\n", {"sensor.yaml:2", "row_sigma", "row_sigma_px"});
  ExpectError("speckle: 1.5\n", {"sensor.yaml:1", "speckle", "1.5", "from 0 to 1"});
  ExpectError("columns: 8\n", {"columns", "from 32"});
  ExpectError("lines_ahead_mm: [80, near]\n", {"lines_ahead_mm", "near"});
  ExpectError("lines_ahead_mm: [80, -5]\n", {"lines_ahead_mm", "-5"});
  ExpectError("lines_ahead_mm: []\n", {"lines_ahead_mm", "at least one element"});
  ExpectError("outlier_run_columns: 0.5\n", {"outlier_run_columns"});
  ExpectError("range_above_mm: 500\n", {"range_above_mm", "nearer to the camera"});
  ExpectError("rate_min_hz: 200\n", {"rate_min_hz", "rate_max_hz"});
  ExpectError("rows: 100\n", {"range_above_mm", "rows"});
  ExpectError("type: line_scanner\n", {"type", "stripe_sensor"});
}

TEST(StripeSensorFile, ValuesArriveInSiUnits) {
  const testing_support::TempFolder folder;
  const auto file = folder.Write(
      "s.yaml", "name: x\ncolumns_per_mm: 18\nlines_ahead_mm: [80, 65]\nstandoff_mm: 150\n");
  const StripeSensorOptions options = ReadStripeSensor(file);
  EXPECT_EQ(options.name, "x");
  EXPECT_DOUBLE_EQ(options.line.columns_per_m, 18'000.0);
  EXPECT_EQ(options.lines_ahead_m, (std::vector<double>{80.0 * 1e-3, 65.0 * 1e-3}));
  EXPECT_DOUBLE_EQ(options.standoff_m, 0.15);
  EXPECT_DOUBLE_EQ(options.row_sigma_px, StripeSensorOptions{}.row_sigma_px);
}

TEST(StripeSensorFile, TheShippedSensorsAreThoseOfTheDissertation) {
  const std::filesystem::path sensors =
      std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "models" / "sensors";
  const auto base = ReadStripeSensor(sensors / "stripe_base.yaml");
  EXPECT_EQ(base.line.columns, 1024);
  EXPECT_DOUBLE_EQ(base.line.columns_per_m, 12'000.0);
  EXPECT_EQ(base.lines_ahead_m.size(), 1U);
  const auto three = ReadStripeSensor(sensors / "stripe_three_lines.yaml");
  EXPECT_DOUBLE_EQ(three.line.columns_per_m, 18'000.0);
  EXPECT_EQ(three.lines_ahead_m.size(), 3U);
  EXPECT_GT(three.phantom_share, 0.0);
}

}  // namespace
}  // namespace rangegrasp::seam
