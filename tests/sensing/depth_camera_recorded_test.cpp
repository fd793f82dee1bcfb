// Compares the noise of a simulated depth camera with recorded clouds of a Kinect: residuals of
// planes, correlation of neighbors, the share of holes near depth edges and elsewhere, and samples
// between two surfaces.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <vector>

#include "base/statistics.h"
#include "labelled_cloud.h"
#include "sensing/depth_camera.h"
#include "sensing/shapes.h"

namespace rangegrasp::sensing {
namespace {

using Eigen::Vector3d;

// Parameters of the recorded clouds. The focal length is a least-squares fit to their points; the
// baseline is the device's (Khoshelham and Elberink 2012). Their product converts depths to
// disparities.
constexpr double kKinectFocal_px = 525.0;
constexpr double kKinectBaseline_m = 0.075;
constexpr double kFb = kKinectFocal_px * kKinectBaseline_m;

/// Disparities [px] of an image, NaN where nothing was measured.
struct Disparities {
  int width = 0, height = 0;
  std::vector<double> of;

  double At(int x, int y) const { return of[static_cast<std::size_t>(y * width + x)]; }
};

Disparities DisparitiesOf(int width, int height, const geometry::Points& points_S) {
  Disparities image{width, height, {}};
  for (const Vector3d& p : points_S) image.of.push_back(kFb / p.z());
  return image;
}

/// The compared figures.
struct NoiseFigures {
  std::vector<double> sigma_px;                       ///< of plane residuals, one per window
  std::vector<double> alike_1, alike_4, alike_below;  ///< correlation 1 and 4 columns, 1 row apart
  double near_holes = 0, near = 0, flat_holes = 0, flat = 0, hanging = 0, edges = 0;

  double NearShare() const { return near_holes / near; }
  double FlatShare() const { return flat_holes / flat; }
  double HangingShare() const { return hanging / edges; }
};

constexpr int kHalf = 10;  // half size of a window
constexpr int kSide = 2 * kHalf + 1;

/// Adds the figures of a complete, flat window; 1 / z of a plane is linear in the image.
void AddPlane(const Disparities& image, int x, int y, NoiseFigures& figures) {
  Eigen::Matrix<double, kSide * kSide, 3> A;
  Eigen::Matrix<double, kSide * kSide, 1> b;
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      A.row(j * kSide + i) << i - kHalf, j - kHalf, 1.0;
      b(j * kSide + i) = image.At(x + i - kHalf, y + j - kHalf);
    }
  }
  const Eigen::VectorXd e = b - A * A.householderQr().solve(b).eval();
  const double variance = e.squaredNorm() / (kSide * kSide - 3);
  constexpr double kFlat_px = 0.2;  // larger residuals mean a curved surface
  if (variance > kFlat_px * kFlat_px || !(variance > 0.0)) return;
  const auto alike = [&](int right, int down) {
    double sum = 0.0;
    int count = 0;
    for (int j = 0; j + down < kSide; ++j) {
      for (int i = 0; i + right < kSide; ++i, ++count) {
        sum += e(j * kSide + i) * e((j + down) * kSide + i + right);
      }
    }
    return sum / count / variance;
  };
  figures.sigma_px.push_back(std::sqrt(variance));
  figures.alike_1.push_back(alike(1, 0));
  figures.alike_4.push_back(alike(4, 0));
  figures.alike_below.push_back(alike(0, 1));
}

void AddWindow(const Disparities& image, int x, int y, NoiseFigures& figures) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  int measured = 0;
  for (int j = -kHalf; j <= kHalf; ++j) {
    for (int i = -kHalf; i <= kHalf; ++i) {
      const double d = image.At(x + i, y + j);
      if (!std::isfinite(d)) continue;
      ++measured;
      low = std::min(low, d);
      high = std::max(high, d);
    }
  }
  const double share = measured / static_cast<double>(kSide * kSide);
  const bool hole = !std::isfinite(image.At(x, y));
  if (share > 0.3 && high - low > 4.0) {
    figures.near += 1;
    figures.near_holes += hole ? 1 : 0;
  } else if (share > 0.6 && high - low < 2.0) {
    figures.flat += 1;
    figures.flat_holes += hole ? 1 : 0;
    if (measured == kSide * kSide && (x - kHalf) % kSide == 0 && (y - kHalf) % kSide == 0) {
      AddPlane(image, x, y, figures);
    }
  }
}

void AddHanging(const Disparities& image, NoiseFigures& figures) {
  constexpr double kStep_px = 4.0, kBetween_px = 1.0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x + 2 < image.width; ++x) {
      const double a = image.At(x, y), b = image.At(x + 1, y), c = image.At(x + 2, y);
      if (!(std::abs(a - c) > kStep_px) || !std::isfinite(b)) continue;
      figures.edges += 1;
      const bool between = b > std::min(a, c) + kBetween_px && b < std::max(a, c) - kBetween_px;
      figures.hanging += between ? 1 : 0;
    }
  }
}

void AddImage(const Disparities& image, NoiseFigures& figures) {
  constexpr int kStep = 3;  // not every pixel, since neighbors are alike
  for (int y = kHalf; y + kHalf < image.height; y += kStep) {
    for (int x = kHalf; x + kHalf < image.width; x += kStep) AddWindow(image, x, y, figures);
  }
  AddHanging(image, figures);
}

/// Options with the recorded camera's lens; this test compares the noise.
DepthCameraOptions KinectLike() {
  DepthCameraOptions options;
  options.field_right_rad = 2.0 * std::atan(320.0 / kKinectFocal_px);
  options.baseline_m = kKinectBaseline_m;
  options.disparity_sigma_px = 0.068;
  options.disparity_step_px = 0.125;  // Khoshelham and Elberink 2012: eighths of a pixel
  options.window_px = 7;
  options.window_rows_px = 3;
  options.fixed_share = 1.0;
  options.edge_loss = 0.05;
  options.flying_share = 0.0;
  return options;
}

/// A table like the recorded ones, seen from 0.9 m at 45 deg, with boxes of 60 to 160 mm.
NoiseFigures Simulated() {
  const double s = std::sqrt(0.5);
  Eigen::Matrix3d R_WS;
  R_WS.col(0) = Vector3d::UnitY();
  R_WS.col(2) = Vector3d(-s, 0.0, -s);
  R_WS.col(1) = R_WS.col(2).cross(R_WS.col(0));
  const base::Pose X_WS = base::MakePose(R_WS, {0.64, 0.0, 0.64});
  std::vector<sim::VisualMesh> meshes = {test::Level(0.0, -0.6, 0.5, -0.6, 0.6)};
  for (int i = 0; i < 6; ++i) {
    const Vector3d half(0.03 + 0.008 * i, 0.04, 0.03 + 0.01 * i);
    meshes.push_back(test::Box({-0.25 + 0.2 * (i % 3), i < 3 ? -0.15 : 0.15, half.z()}, half,
                               static_cast<std::uint32_t>(i + 1)));
  }
  NoiseFigures figures;
  base::Rng rng(1);
  for (int image = 0; image < 4; ++image) {
    const Scan scan = ScanScene(meshes, X_WS, KinectLike(), rng);
    geometry::Points points_S;
    const base::Pose X_SW = scan.view.X_CV.inverse();
    for (const Vector3d& p_W : scan.view.image.points_C) points_S.push_back(X_SW * p_W);
    AddImage(DisparitiesOf(640, 480, points_S), figures);
  }
  return figures;
}

NoiseFigures Recorded() {
  NoiseFigures figures;
  for (const int number : labelled::KinectNumbers()) {
    if (number % 8 != 0) continue;
    const geometry::CloudFile cloud = labelled::ReadKinect(number);
    AddImage(DisparitiesOf(cloud.width, cloud.height, cloud.points), figures);
  }
  return figures;
}

TEST(DepthCameraRecorded, ItsNoiseIsThatOfRecordedClouds) {
  if (!std::filesystem::exists(labelled::KinectFolder())) {
    GTEST_SKIP() << "no recorded clouds in " << labelled::KinectFolder();
  }
  const NoiseFigures recorded = Recorded();
  const NoiseFigures simulated = Simulated();
  const auto print = [](const char* what, double a, double b) {
    std::printf("%-40s recorded %6.3f, simulated %6.3f\n", what, a, b);
  };
  const auto compare = [&](const char* what, auto member, double within) {
    const double a = base::MedianOf(recorded.*member), b = base::MedianOf(simulated.*member);
    print(what, a, b);
    EXPECT_NEAR(a, b, within) << what;
  };
  ASSERT_GT(recorded.sigma_px.size(), 30U);
  ASSERT_GT(simulated.sigma_px.size(), 30U);
  // Tolerances allow for differences between two devices of a type, not between samples.
  compare("plane residual [px of disparity]", &NoiseFigures::sigma_px, 0.012);
  compare("correlation, 1 column apart", &NoiseFigures::alike_1, 0.12);
  compare("correlation, 4 columns apart", &NoiseFigures::alike_4, 0.15);
  compare("correlation, 1 row apart", &NoiseFigures::alike_below, 0.15);
  print("holes near depth edges", recorded.NearShare(), simulated.NearShare());
  print("holes elsewhere", recorded.FlatShare(), simulated.FlatShare());
  print("hanging samples at depth edges", recorded.HangingShare(), simulated.HangingShare());
  EXPECT_LT(std::abs(std::log(recorded.NearShare() / simulated.NearShare())), std::log(2.0));
  EXPECT_NEAR(recorded.FlatShare(), simulated.FlatShare(), 0.015);
  EXPECT_NEAR(recorded.HangingShare(), simulated.HangingShare(), 0.01);
}

}  // namespace
}  // namespace rangegrasp::sensing
