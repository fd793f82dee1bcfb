#include "sensing/line_scanner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "base/units.h"
#include "error_of.h"
#include "sensing/optics.h"
#include "sensing/shapes.h"

namespace rangegrasp::sensing {
namespace {

using Eigen::Vector3d;
using LineScannerMeshes = std::vector<sim::VisualMesh>;

// In these tests W = S: the laser at the origin looks along z.
const base::Pose kHead = base::Pose::Identity();

// The pose is known exactly, and every sample is lost or kept independently.
LineScannerOptions Known() {
  LineScannerOptions options;
  options.calibration_sigma_m = options.calibration_sigma_rad = 0.0;
  options.dropout_patch_m = 0.0;
  return options;
}

LineScannerOptions Noiseless() {
  LineScannerOptions options = Known();
  options.centroid_sigma_px = options.speckle_sigma_m = options.quantisation_px = 0.0;
  options.pan_jitter_rad = 0.0;
  return options;
}

LineScannerMeshes Wall(double z) { return {test::Level(z, -3, 3, -3, 3)}; }

Scan LineScannerScanOf(const LineScannerMeshes& meshes, const LineScannerOptions& options,
                       std::uint64_t seed = 1) {
  base::Rng rng(seed);
  return ScanScene(meshes, kHead, options, rng);
}

/// Calls f(index, profile, sample) for every sample.
template <typename F>
void ForEach(const Scan& scan, F f) {
  for (int p = 0; p < scan.view.image.profiles; ++p) {
    for (int s = 0; s < scan.view.image.samples; ++s) f(scan.view.image.Index(p, s), p, s);
  }
}

std::size_t Count(const Scan& scan, SampleState state) {
  return static_cast<std::size_t>(std::ranges::count(scan.truth.state, state));
}

bool SameBytes(const Scan& a, const Scan& b) {
  const auto equal = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
  };
  return equal(a.view.image.points_C, b.view.image.points_C) &&
         equal(a.truth.state, b.truth.state) && equal(a.truth.label, b.truth.label) &&
         equal(a.truth.true_range_m, b.truth.true_range_m);
}

TEST(LineScanner, WithoutNoiseAPlaneIsExact) {
  LineScannerOptions options = Noiseless();
  options.profiles = 20;
  const Scan scan = LineScannerScanOf(Wall(1.0), options);
  EXPECT_EQ(Count(scan, SampleState::kMeasured), scan.truth.state.size());
  ForEach(scan, [&](std::size_t i, int, int) {
    EXPECT_NEAR(scan.view.image.points_C[i].z(), 1.0, 2e-6);  // single-precision rays
    EXPECT_NEAR(scan.view.image.points_C[i].norm(), scan.truth.true_range_m[i], 2e-6);
  });
}

// The view has the calibrated pose, which gives the pan axis of every profile.
TEST(LineScanner, TheViewStandsWhereTheScannerDoes) {
  const base::Pose X_WS = base::MakePose(
      Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized()).toRotationMatrix(), {0.1, 0.2, 0.3});
  base::Rng rng(1);
  const Scan scan = ScanScene({}, X_WS, Noiseless(), rng);
  EXPECT_TRUE(scan.view.X_CV.isApprox(X_WS, 0.0));
  ASSERT_EQ(scan.view.image.origins_C.size(), 1u);
  EXPECT_EQ(scan.view.image.origins_C[0], X_WS.translation());
  EXPECT_EQ(scan.view.spacing_m, 0.0);
}

// On a wall straight ahead, samples are one slope step apart, and profiles are one pan step apart.
// Both grow off the center: over +-2 degrees by less than 2 (1 / cos^2(2 deg) - 1) = 0.25 %.
TEST(LineScanner, SpacingIsThatOfTheRaysOnAWall) {
  LineScannerOptions options = Noiseless();
  options.fan_rad = options.pan_range_rad = base::Deg(4.0);
  options.samples = 101;
  options.profiles = 41;
  for (const double depth_m : {0.8, 1.2}) {
    const double along_m = 2.0 * depth_m * std::tan(base::Deg(2.0)) / 100.0;
    const double across_m = depth_m * base::Deg(4.0) / 40.0;
    EXPECT_NEAR(
        LineScannerScanOf(Wall(depth_m), options).view.spacing_m / (0.5 * (along_m + across_m)),
        1.0, 0.0025);
  }
}

class PlaneNoise : public ::testing::TestWithParam<double> {};

TEST_P(PlaneNoise, HasNoBiasAndThePredictedSpread) {
  LineScannerOptions options = Known();
  options.pan_jitter_rad = 0.0;
  options.pan_range_rad = base::Deg(20.0);
  options.profiles = 60;
  const Scan scan = LineScannerScanOf(Wall(GetParam()), options);
  double sum = 0.0;
  double squares = 0.0;
  ForEach(scan, [&](std::size_t i, int p, int) {
    ASSERT_EQ(scan.truth.state[i], SampleState::kMeasured);
    const double cosine = std::cos(PanAngle(options, p));
    const double error = (scan.view.image.points_C[i].z() - GetParam()) / cosine;
    const double normalised = error / DepthSigma(options, GetParam() / cosine);
    sum += normalised;
    squares += normalised * normalised;
  });
  // Five standard errors of mean and variance for 30,720 samples. The correlated fifth of the
  // variance costs less than half of them.
  const double n = static_cast<double>(scan.truth.state.size());
  EXPECT_NEAR(sum / n, 0.0, 5.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(squares / n, 1.0, 5.0 * std::sqrt(2.0 * 2.0 / n));
}

// Compares the noise stated by the scan with the truth: the standard deviation of the errors along
// the rays, in units of noise_m, is one at the fan's center and at its ends, where rays are longer.
TEST_P(PlaneNoise, IsWhatTheViewSaysItIs) {
  LineScannerOptions options = Known();
  options.pan_jitter_rad = 0.0;
  options.pan_range_rad = base::Deg(20.0);
  options.profiles = 150;
  const Scan scan = LineScannerScanOf(Wall(GetParam()), options);
  std::array<double, 2> squares{};  // the fan's middle half, the rest
  std::array<double, 2> count{};
  ForEach(scan, [&](std::size_t i, int, int s) {
    const Vector3d& p = scan.view.image.points_C[i];
    const double error = p.norm() * (1.0 - GetParam() / p.z());  // to the ray's point on the wall
    const double normalised = error / static_cast<double>(scan.view.noise_m[i]);
    const std::size_t part = std::abs(s - 255.5) < 128.0 ? 0 : 1;
    squares[part] += normalised * normalised;
    count[part] += 1.0;
  });
  for (const std::size_t part : {0U, 1U}) {  // five standard errors, as above
    EXPECT_NEAR(squares[part] / count[part], 1.0, 5.0 * std::sqrt(2.0 * 2.0 / count[part])) << part;
  }
}

INSTANTIATE_TEST_SUITE_P(Depths, PlaneNoise, ::testing::Values(0.7, 1.0, 1.4));

TEST(LineScanner, SpeckleIsCorrelatedAlongTheLineAndNotAcross) {
  LineScannerOptions options = Noiseless();
  options.speckle_sigma_m = 0.0002;
  const Scan scan = LineScannerScanOf(Wall(1.0), options);
  std::array<double, 3> product{};  // same sample, next sample, next profile
  ForEach(scan, [&](std::size_t i, int p, int s) {
    if (p + 1 == scan.view.image.profiles || s + 1 == scan.view.image.samples) return;
    const double e = scan.view.image.points_C[i].z() - 1.0;
    product[0] += e * e;
    product[1] += e * (scan.view.image.points_C[i + 1].z() - 1.0);
    product[2] += e * (scan.view.image.points_C[scan.view.image.Index(p + 1, s)].z() - 1.0);
  });
  // For 76,000 samples, 19,000 of them independent, five standard errors are 0.036.
  EXPECT_NEAR(product[1] / product[0], std::exp(-0.5), 0.036);
  EXPECT_NEAR(product[2] / product[0], 0.0, 0.036);
}

// The speckle of the first sample is not smaller than that of the others.
TEST(LineScanner, SpeckleIsStationaryFromTheFirstSample) {
  LineScannerOptions options = Noiseless();
  options.speckle_sigma_m = 0.0002;
  options.samples = 16;
  options.profiles = 2000;
  options.pan_range_rad = base::Deg(1.0);
  const Scan scan = LineScannerScanOf(Wall(1.0), options);
  for (const int s : {0, 15}) {
    double squares = 0.0;
    for (int p = 0; p < options.profiles; ++p) {
      const double e = scan.view.image.points_C[scan.view.image.Index(p, s)].z() - 1.0;
      squares += e * e;
    }
    const double variance = squares / options.profiles;
    EXPECT_NEAR(variance / (options.speckle_sigma_m * options.speckle_sigma_m), 1.0,
                5.0 * std::sqrt(2.0 / options.profiles))
        << s;
  }
}

TEST(LineScanner, CentroidsAreGivenInStepsAndOnTheSensor) {
  LineScannerOptions options = Noiseless();
  options.quantisation_px = 0.5;
  options.centroid_sigma_px = 100.0;
  options.sensor_pixels = 200;
  const CameraModel camera(options);
  const Scan scan = LineScannerScanOf(Wall(options.focus_distance_m), options);
  ForEach(scan, [&](std::size_t i, int, int) {
    if (scan.truth.state[i] != SampleState::kMeasured) return;
    const Vector3d& p = scan.view.image.points_C[i];
    const double steps = camera.Column(0.0, std::hypot(p.x(), p.z())) / options.quantisation_px;
    EXPECT_NEAR(steps, std::round(steps), 1e-6);
    EXPECT_LE(std::abs(steps), 200.0 + 1e-6);
  });
  EXPECT_GT(Count(scan, SampleState::kMeasured), 1000u);
  EXPECT_GT(Count(scan, SampleState::kOutOfView), 1000u);
}

// The plane of a thin plate passes between laser and camera: the laser lights one side, the camera
// sees the other.
TEST(LineScanner, TheCameraDoesNotSeeTheBackOfALitSurface) {
  const LineScannerOptions options = Noiseless();
  const Vector3d along = Vector3d(0.5 * options.baseline_m, 0.0, -1.0).normalized();
  const Vector3d corner = Vector3d(0.0, -0.2, 1.0) - 0.05 * along;
  const Scan scan = LineScannerScanOf({test::Plate(corner, 0.1 * along, {0.0, 0.4, 0.0})}, options);
  EXPECT_EQ(Count(scan, SampleState::kMeasured), 0u);
  EXPECT_GT(Count(scan, SampleState::kCameraShadow), 100u);
}

TEST(LineScanner, ASpheresRadiusIsRecovered) {
  LineScannerOptions options = Known();
  options.pan_jitter_rad = 0.0;
  const double radius = 0.06;
  const Vector3d center(0.02, -0.01, 1.0);
  const Scan scan = LineScannerScanOf({test::Sphere(center, radius, 200)}, options);
  // For points p = c + r n, |p - c|^2 linearised at the truth is n . dc + dr = |p - c| - r. Only
  // points within 50 degrees of the view are used, where edges and drop-outs do not bias them.
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  const Vector3d view = -center.normalized();
  ForEach(scan, [&](std::size_t i, int, int) {
    const Vector3d d = scan.view.image.points_C[i] - center;
    if (scan.truth.state[i] != SampleState::kMeasured) return;
    if (d.normalized().dot(view) < std::cos(base::Deg(50.0))) return;
    const Eigen::Vector4d row(d.normalized().x(), d.normalized().y(), d.normalized().z(), 1.0);
    normal += row * row.transpose();
    right += row * (d.norm() - radius);
  });
  const Eigen::Matrix4d covariance = normal.inverse();
  const double radius_error = (covariance * right)(3);
  // Five standard errors, times sqrt(2) for the speckle's correlation.
  const double sigma = std::sqrt(2.0) * DepthSigma(options, 1.0) * std::sqrt(covariance(3, 3));
  EXPECT_LT(sigma, 0.0005);
  EXPECT_NEAR(radius_error, 0.0, 5.0 * sigma);
}

// A wall at 1 m with a plate of |x| <= 40 mm, |y| <= 100 mm in front of it.
constexpr double kHalf = 0.04;
LineScannerMeshes PlateBeforeWall(double z, double wall_z = 1.0) {
  return {test::Level(wall_z, -3, 3, -3, 3), test::Level(z, -kHalf, kHalf, -0.1, 0.1, 7)};
}

TEST(LineScanner, LabelsAndCameraShadowAreWhereGeometryPutsThem) {
  const LineScannerOptions options = Noiseless();
  const double plate_z = 0.8;
  const Scan scan = LineScannerScanOf(PlateBeforeWall(plate_z), options);
  ForEach(scan, [&](std::size_t i, int p, int s) {
    const double pan = PanAngle(options, p);
    const double y = Slope(options, s) / std::cos(pan);  // at z = 1
    const double x = std::tan(pan);
    const double camera_x = options.baseline_m * std::cos(pan);
    const double camera_z = -options.baseline_m * std::sin(pan);
    const double share = (1.0 - plate_z) / (1.0 - camera_z);
    const double cross_x = x + (camera_x - x) * share;
    const double cross_y = y * (1.0 - share);
    // The line is 1 mm wide and a sample 1.5 mm long; closer to an edge, either may be seen.
    const auto inside = [](double cx, double cy) {
      const double depth = std::max(std::abs(cx) - kHalf, std::abs(cy) - 0.1);
      return depth < -0.0015 ? 1 : depth > 0.0015 ? 0 : -1;
    };
    const int on_plate = inside(x * plate_z, y * plate_z);
    const int hidden = inside(cross_x, cross_y);
    if (on_plate == 1) {
      EXPECT_EQ(scan.truth.label[i], 7u);
      EXPECT_EQ(scan.truth.state[i], SampleState::kMeasured);
      EXPECT_NEAR(scan.view.image.points_C[i].z(), plate_z, 2e-6);
    } else if (on_plate == 0 && hidden >= 0) {
      EXPECT_EQ(scan.truth.label[i], 0u);
      EXPECT_EQ(scan.truth.state[i],
                hidden == 1 ? SampleState::kCameraShadow : SampleState::kMeasured);
      EXPECT_NEAR(scan.truth.true_range_m[i], std::sqrt(1.0 + x * x + y * y), 2e-6);
    }
  });
  EXPECT_GT(Count(scan, SampleState::kCameraShadow), 1000u);
}

TEST(LineScanner, WhatIsNotMeasuredIsNaN) {
  const Scan scan = LineScannerScanOf(PlateBeforeWall(0.8), Known());
  ForEach(scan, [&](std::size_t i, int, int) {
    EXPECT_EQ(scan.view.image.points_C[i].allFinite(),
              scan.truth.state[i] == SampleState::kMeasured);
    EXPECT_EQ(std::isnan(scan.view.image.points_C[i].x()),
              scan.truth.state[i] != SampleState::kMeasured);
    EXPECT_EQ(std::isnan(scan.view.noise_m[i]), scan.truth.state[i] != SampleState::kMeasured);
  });
}

/// Distance from the plate's outline along the seen surface, in x and y.
double OutlineDistance(const Vector3d& p, double plate_z) {
  const Vector3d q = p * (plate_z / p.z());  // its ray's point in the plate's plane
  const double dx = std::abs(q.x()) - kHalf;
  const double dy = std::abs(q.y()) - 0.1;
  return std::abs(std::max(dx, dy));
}

TEST(LineScanner, MixedPointsHangBetweenNearSurfacesOnlyWithinTheLineOfAnEdge) {
  const LineScannerOptions options = Noiseless();
  const double plate_z = 0.992;
  int mixed = 0;
  for (int k = 0; k < 5; ++k) {  // plates at different offsets between profiles
    LineScannerMeshes meshes = PlateBeforeWall(plate_z);
    for (Vector3d& v : meshes[1].mesh_W.vertices) v.x() += 0.0004 * k;
    const Scan scan = LineScannerScanOf(meshes, options);
    ForEach(scan, [&](std::size_t i, int, int) {
      if (scan.truth.state[i] != SampleState::kMeasured) return;
      const Vector3d& p = scan.view.image.points_C[i];
      const double off = std::min(std::abs(p.z() - plate_z), std::abs(p.z() - 1.0));
      if (off < 1e-5) return;
      // Rays extend 0.6 line widths across the line and a third of a sample (0.5 mm) along it. The
      // camera's shadow has its own edges to the left of the plate, where the parallax of the 8 mm
      // step is 8 * 0.3 / 1 = 2.4 mm.
      const Vector3d shifted = p + Vector3d(0.0024 - 0.0004 * k, 0, 0);
      const double distance = std::min(OutlineDistance(p - Vector3d(0.0004 * k, 0, 0), plate_z),
                                       OutlineDistance(shifted, plate_z));
      EXPECT_LT(distance, 0.0008) << p.transpose();
      if (p.z() > plate_z + 0.002 && p.z() < 0.998) ++mixed;
    });
  }
  EXPECT_GT(mixed, 20);
}

TEST(LineScanner, NothingHangsBetweenSurfacesWhoseImagesAreApart) {
  for (int k = 0; k < 5; ++k) {  // so that the edge crosses the line of some profile
    LineScannerMeshes meshes = PlateBeforeWall(0.9);
    for (Vector3d& v : meshes[1].mesh_W.vertices) v.x() += 0.0008 * k;
    const Scan scan = LineScannerScanOf(meshes, Noiseless());
    ForEach(scan, [&](std::size_t i, int, int) {
      if (scan.truth.state[i] != SampleState::kMeasured) return;
      const double z = scan.view.image.points_C[i].z();
      // A partly visible line of 1 mm moves the centroid by less than 0.6 mm; the depth moves by
      // z / b times that.
      EXPECT_LT(std::min(std::abs(z - 0.9), std::abs(z - 1.0)), 0.0006 / 0.3);
    });
  }
}

TEST(LineScanner, AReflectanceStepPullsTheCentroidToTheBrighterSide) {
  const LineScannerOptions options = Noiseless();
  int bent = 0;
  for (int k = 0; k < 10; ++k) {
    const double step_x = 0.0004 * k;
    LineScannerMeshes meshes = {test::Level(1.0, -3, step_x, -3, 3),
                                test::Level(1.0, step_x, 3, -3, 3)};
    meshes[0].surface.albedo = 0.8;
    meshes[1].surface.albedo = 0.2;
    const Scan scan = LineScannerScanOf(meshes, options);
    ForEach(scan, [&](std::size_t i, int, int) {
      ASSERT_EQ(scan.truth.state[i], SampleState::kMeasured);
      const Vector3d& p = scan.view.image.points_C[i];
      const double error = p.z() - 1.0;
      if (std::abs(error) < 1e-5) return;
      ++bent;
      EXPECT_LT(std::abs(p.x() - step_x), 0.0007);
      // Light at -x of the fan's center appears further to the left, as if it were closer.
      EXPECT_LT(error, 0.0);
      EXPECT_GT(error, -0.5 * options.line_width_m / options.baseline_m);
    });
  }
  EXPECT_GT(bent, 100);
}

/// Compares the number of drop-outs among the seen samples with the sum of probabilities.
void ExpectDropouts(const Scan& scan, const std::vector<double>& probability) {
  double expected = 0.0;
  double variance = 0.0;
  double dropped = 0.0;
  for (std::size_t i = 0; i < probability.size(); ++i) {
    const SampleState state = scan.truth.state[i];
    if (state != SampleState::kMeasured && state != SampleState::kDropout) continue;
    expected += probability[i];
    variance += probability[i] * (1.0 - probability[i]);
    dropped += state == SampleState::kDropout ? 1.0 : 0.0;
  }
  EXPECT_GT(variance, 1000.0);
  EXPECT_NEAR(dropped, expected, 5.0 * std::sqrt(variance));
}

TEST(LineScanner, GrazingSamplesDropOutByTheirIncidence) {
  const LineScannerOptions options = Known();
  const double tilt = base::Deg(65.0);
  const Vector3d along(0, std::cos(tilt), std::sin(tilt));
  const Vector3d normal(0, -std::sin(tilt), std::cos(tilt));
  const Scan scan = LineScannerScanOf(
      {test::Plate(Vector3d(-3, 0, 1) - 2 * along, {6, 0, 0}, 4 * along)}, options);
  std::vector<double> probability(scan.truth.state.size());
  ForEach(scan, [&](std::size_t i, int p, int s) {
    const Vector3d ray =
        PanRotation(PanAngle(options, p)) * Vector3d(0, Slope(options, s), 1).normalized();
    const double incidence_deg = base::ToDeg(std::acos(std::abs(ray.dot(normal))));
    probability[i] = std::clamp((incidence_deg - 60.0) / 20.0, 0.0, 1.0);
  });
  ExpectDropouts(scan, probability);
}

TEST(LineScanner, DarkAndClearSurfacesDropOutByTheirShares) {
  LineScannerMeshes dark = Wall(1.0);
  dark[0].surface.albedo = 0.025;
  const Scan dark_scan = LineScannerScanOf(dark, Known());
  ExpectDropouts(dark_scan, std::vector<double>(dark_scan.truth.state.size(), 0.7));
  LineScannerMeshes clear = Wall(1.0);
  clear[0].surface.clarity = 0.8;
  const Scan clear_scan = LineScannerScanOf(clear, Known());
  ExpectDropouts(clear_scan, std::vector<double>(clear_scan.truth.state.size(), 0.8));
}

// A glossy wall blinds the camera everywhere with probability 1/2, so half of its patches are lost
// completely. Neighboring samples along the line, a dozen per patch, are nearly always lost or kept
// together.
TEST(LineScanner, PatchesAreLostAsAWhole) {
  LineScannerOptions options = Noiseless();
  options.dropout_patch_m = 0.02;
  LineScannerMeshes meshes = Wall(1.0);
  meshes[0].surface.gloss = 0.5;
  options.saturation_angle_rad = base::kPi;
  const Scan scan = LineScannerScanOf(meshes, options);
  std::size_t lost = 0, pairs = 0, same = 0;
  ForEach(scan, [&](std::size_t i, int, int s) {
    lost += scan.truth.state[i] == SampleState::kDropout ? 1 : 0;
    if (s == 0) return;
    ++pairs;
    same += scan.truth.state[i] == scan.truth.state[i - 1] ? 1 : 0;
  });
  const auto all = static_cast<double>(scan.truth.state.size());
  EXPECT_NEAR(static_cast<double>(lost) / all, 0.5, 0.06);  // about 1,400 patches
  EXPECT_GT(static_cast<double>(same) / static_cast<double>(pairs), 0.9);
}

/// A wall with a print whose right half is white.
LineScannerMeshes PrintedWall(const geometry::Rgb& left) {
  LineScannerMeshes meshes = Wall(1.0);
  const auto& vertices = meshes[0].mesh_W.vertices;
  for (const auto& triangle : meshes[0].mesh_W.triangles) {
    auto& corners = meshes[0].colors.uv.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto x = static_cast<float>(vertices[triangle[k]].x());
      corners[k] = {(x + 3.0f) / 6.0f, 0.5f};
    }
  }
  meshes[0].colors.print = std::make_shared<geometry::Print>(
      geometry::Print{.width = 2, .height = 1, .texels = {left, {255, 255, 255}}});
  return meshes;
}

// The left half is black. Only this half loses samples.
TEST(LineScanner, APrintsAlbedoGoesBeforeTheSurfaces) {
  LineScannerMeshes meshes = PrintedWall({0, 0, 0});
  meshes[0].surface.albedo = 0.7;
  const Scan scan = LineScannerScanOf(meshes, Known());
  std::size_t dark = 0, dark_lost = 0, white_lost = 0;
  ForEach(scan, [&](std::size_t i, int p, int) {
    const double x = std::tan(PanAngle(Known(), p));
    const bool lost = scan.truth.state[i] == SampleState::kDropout;
    if (x > 0.002) white_lost += lost ? 1 : 0;
    if (x > -0.002) return;
    ++dark;
    dark_lost += lost ? 1 : 0;
  });
  EXPECT_EQ(white_lost, 0u);
  const double expected = AlbedoLoss(PrintAlbedo(0));
  EXPECT_NEAR(static_cast<double>(dark_lost) / static_cast<double>(dark), expected, 0.01);
}

constexpr geometry::Rgb kRed = {200, 30, 30};

// The second exposure does not change any measured range.
TEST(LineScanner, ColorsAreSeenBesideTheRange) {
  LineScannerOptions options = Known();
  const LineScannerMeshes meshes = PrintedWall(kRed);
  const Scan without = LineScannerScanOf(meshes, options);
  EXPECT_TRUE(without.view.colors.empty());
  options.color = true;
  options.color_noise_levels = options.color_gain_sigma = options.color_shift_m = 0.0;
  const Scan scan = LineScannerScanOf(meshes, options);
  EXPECT_TRUE(SameBytes(scan, without));
  ASSERT_EQ(scan.view.colors.size(), scan.truth.state.size());
  // The wall is upright, so it gets no light from above, and half of all light.
  const auto lit = [](const geometry::Rgb& color) {
    return geometry::ColorOf(0.5 * geometry::LightOf(color));
  };
  ForEach(scan, [&](std::size_t i, int p, int) {
    const double x = std::tan(PanAngle(options, p));
    if (std::abs(x) < 0.005) return;
    EXPECT_EQ(scan.view.colors[i], x < 0.0 ? lit(kRed) : lit({255, 255, 255}));
  });
}

// Checks over many scans: a channel's noise, its gain, and the shift of colors against samples.
TEST(LineScanner, ColorsAreOffByWhatIsStated) {
  LineScannerOptions options = Known();
  options.color = true;
  options.samples = 2;
  options.profiles = 1000;
  options.pan_jitter_rad = 0.0;
  const LineScannerMeshes meshes = PrintedWall(kRed);
  constexpr int kScans = 300;
  double levels = 0.0, gains = 0.0, shifts_m = 0.0;
  for (std::uint64_t seed = 1; seed <= kScans; ++seed) {
    const auto colors = LineScannerScanOf(meshes, options, seed).view.colors;
    const std::size_t n = colors.size();
    double sum = 0.0, squares = 0.0;
    for (std::size_t i = n / 2 + 100; i < n; ++i) sum += colors[i][0];
    const double mean = sum / static_cast<double>(n / 2 - 100);
    for (std::size_t i = n / 2 + 100; i < n; ++i) squares += std::pow(colors[i][0] - mean, 2);
    levels += squares / static_cast<double>(n / 2 - 100);
    const auto level = static_cast<std::uint8_t>(std::lround(mean));
    const double gain = geometry::LightOf({level, level, level}).x() / 0.5;
    gains += std::pow(std::log(gain), 2);
    // The print's edge, as the second exposure sees it, is where green increases.
    int edge = 0;
    while (colors[2 * static_cast<std::size_t>(edge)][1] < 100) ++edge;
    shifts_m += std::pow(std::tan(PanAngle(options, edge)), 2);
  }
  EXPECT_NEAR(std::sqrt(levels / kScans), options.color_noise_levels, 0.1);
  EXPECT_NEAR(std::sqrt(gains / kScans), options.color_gain_sigma, 0.006);
  EXPECT_NEAR(std::sqrt(2.0 * shifts_m / kScans), options.color_shift_m, 1.5e-4);
}

// Over many scans, the known pose is off by the stated root mean squares, and the points are off
// with it: a point has the same coordinates in the known frame as in the true one.
TEST(LineScanner, TheKnownPoseIsOffByTheCalibration) {
  LineScannerOptions options = Noiseless();
  options.samples = options.profiles = 4;
  options.calibration_sigma_m = 0.001;
  options.calibration_sigma_rad = base::Deg(0.1);
  double squares_m = 0.0, squares_rad = 0.0;
  constexpr int kScans = 400;
  for (int seed = 1; seed <= kScans; ++seed) {
    const Scan scan = LineScannerScanOf(Wall(1.0), options, static_cast<std::uint64_t>(seed));
    const base::Pose& known = scan.view.X_CV;
    squares_m += known.translation().squaredNorm();
    squares_rad += std::pow(Eigen::AngleAxisd(known.linear()).angle(), 2);
    EXPECT_EQ(scan.view.image.origins_C[0], known.translation());
    for (const Vector3d& p : scan.view.image.points_C) {
      EXPECT_NEAR((known.inverse() * p).z(), 1.0, 2e-6);
    }
  }
  // Each has three normal components, so the relative deviation of the mean square is
  // sqrt(2 / 3 / n).
  const double tolerance = 4.0 * std::sqrt(2.0 / 3.0 / kScans);
  EXPECT_NEAR(squares_m / kScans / 1e-6, 1.0, tolerance);
  EXPECT_NEAR(squares_rad / kScans / std::pow(base::Deg(0.1), 2), 1.0, tolerance);
}

TEST(LineScanner, AMirrorBlindsTheCameraWithinFiveDegrees) {
  const LineScannerOptions options = Noiseless();
  LineScannerMeshes meshes = Wall(1.0);
  meshes[0].surface.gloss = 1.0;
  const Scan scan = LineScannerScanOf(meshes, options);
  ForEach(scan, [&](std::size_t i, int p, int s) {
    const double pan = PanAngle(options, p);
    const Vector3d point(std::tan(pan), Slope(options, s) / std::cos(pan), 1.0);
    const Vector3d camera(options.baseline_m * std::cos(pan), 0,
                          -options.baseline_m * std::sin(pan));
    const Vector3d mirrored(point.x(), point.y(), -point.z());
    const double offset_deg =
        base::ToDeg(std::acos(mirrored.normalized().dot((camera - point).normalized())));
    if (std::abs(offset_deg - 5.0) < 0.01) return;
    EXPECT_EQ(scan.truth.state[i],
              offset_deg < 5.0 ? SampleState::kDropout : SampleState::kMeasured);
  });
  EXPECT_GT(Count(scan, SampleState::kDropout), 1000u);
}

TEST(LineScanner, ThePanJitterIsOneAngleAProfile) {
  LineScannerOptions options = Noiseless();
  options.pan_jitter_rad = base::Deg(0.02);
  // A wall rotated by 45 degrees about y. Its depth in the fan at a pan angle a is
  // 1 / (cos a + sin a).
  const Scan scan =
      LineScannerScanOf({test::Plate(Vector3d(-1, -3, 2), {3, 0, -3}, {0, 6, 0})}, options);
  double sum = 0.0;
  double squares = 0.0;
  for (int p = 0; p < scan.view.image.profiles; ++p) {
    const double pan = PanAngle(options, p);
    std::vector<double> jitter;
    for (int s = 0; s < scan.view.image.samples; ++s) {
      const std::size_t i = scan.view.image.Index(p, s);
      if (scan.truth.state[i] != SampleState::kMeasured) continue;
      const Vector3d& q = scan.view.image.points_C[i];
      const double depth = std::hypot(q.x(), q.z());
      EXPECT_NEAR(std::atan2(q.x(), q.z()), pan, 1e-12);  // the view knows the nominal angle
      // cos a + sin a = sqrt(2) sin(a + 45 deg)
      jitter.push_back(std::asin(1.0 / (depth * std::sqrt(2.0))) - base::Deg(45.0) - pan);
    }
    ASSERT_GT(jitter.size(), 100u);
    for (const double j : jitter) EXPECT_NEAR(j, jitter[0], 1e-5);
    sum += jitter[0];
    squares += jitter[0] * jitter[0];
  }
  const double n = scan.view.image.profiles;
  const double sigma = std::sqrt(squares / n);
  EXPECT_NEAR(sigma / options.pan_jitter_rad, 1.0, 5.0 / std::sqrt(2.0 * n));
  EXPECT_NEAR(sum / n / options.pan_jitter_rad, 0.0, 5.0 / std::sqrt(n));  // one per profile
}

TEST(LineScanner, TheSameSeedGivesTheSameBytes) {
  EXPECT_TRUE(SameBytes(LineScannerScanOf(PlateBeforeWall(0.8), {}, 5),
                        LineScannerScanOf(PlateBeforeWall(0.8), {}, 5)));
  EXPECT_FALSE(SameBytes(LineScannerScanOf(PlateBeforeWall(0.8), {}, 5),
                         LineScannerScanOf(PlateBeforeWall(0.8), {}, 6)));
}

TEST(LineScanner, AnObjectElsewhereDoesNotChangeTheNoiseHere) {
  const Scan without = LineScannerScanOf(Wall(1.0), Known());
  const Scan with = LineScannerScanOf(PlateBeforeWall(0.8), Known());
  ForEach(with, [&](std::size_t i, int, int) {
    if (with.truth.label[i] != 0 || with.truth.state[i] != SampleState::kMeasured) return;
    if (std::abs(without.view.image.points_C[i].x()) < 0.2) return;
    EXPECT_EQ(with.view.image.points_C[i], without.view.image.points_C[i]);
  });
}

TEST(LineScanner, AnEmptySceneIsOutOfView) {
  const Scan scan = LineScannerScanOf({}, {});
  EXPECT_EQ(scan.view.image.points_C.size(), 150u * 512u);
  EXPECT_EQ(scan.view.image.origins_C.size(), 1u);
  EXPECT_EQ(Count(scan, SampleState::kOutOfView), scan.truth.state.size());
  for (const double range : scan.truth.true_range_m) EXPECT_TRUE(std::isnan(range));
}

TEST(LineScanner, SurfacesOffTheSensorsWindowAreOutOfViewButKnownToTheTruth) {
  for (const double z : {0.4, 3.0}) {
    const Scan scan = LineScannerScanOf(Wall(z), {});
    EXPECT_EQ(Count(scan, SampleState::kOutOfView), scan.truth.state.size());
    for (const double range : scan.truth.true_range_m) EXPECT_GE(range, z - 1e-5);
  }
}

TEST(LineScanner, TheHeadsOwnHousingHidesNothing) {
  LineScannerMeshes meshes = Wall(1.0);
  meshes.push_back(test::Box({0, 0, 0.05}, {0.02, 0.02, 0.01}));
  meshes.push_back(test::Box({0.3, 0, 0.05}, {0.02, 0.02, 0.01}));
  EXPECT_TRUE(SameBytes(LineScannerScanOf(meshes, Known()), LineScannerScanOf(Wall(1.0), Known())));
}

TEST(LineScanner, ABrokenMeshIsNamed) {
  LineScannerMeshes meshes = PlateBeforeWall(0.8);
  const auto error = [&] {
    return testing_support::ErrorOf<std::invalid_argument>([&] { LineScannerScanOf(meshes, {}); });
  };
  meshes[1].mesh_W.vertices[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error(), ::testing::HasSubstr("mesh 1: vertex 2 is not finite"));
  meshes = PlateBeforeWall(0.8);
  meshes[1].mesh_W.triangles[1][0] = 99;
  EXPECT_THAT(error(), ::testing::HasSubstr("mesh 1: triangle 1 uses vertex 99 of 4"));
}

}  // namespace
}  // namespace rangegrasp::sensing
