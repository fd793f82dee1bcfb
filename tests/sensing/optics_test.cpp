#include "sensing/optics.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "base/rng.h"
#include "base/units.h"
#include "geometry/random_points.h"
#include "sensing/line_scanner.h"
#include "sensing/shapes.h"

namespace rangegrasp::sensing {
namespace {

TEST(CameraModel, DepthInvertsColumn) {
  const CameraModel camera{LineScannerOptions{}};
  for (double z = 0.4; z < 3.0; z += 0.01) {
    const auto depth = camera.Depth(camera.Column(0.0, z));
    ASSERT_TRUE(depth);
    EXPECT_NEAR(*depth, z, 1e-12);
  }
}

TEST(CameraModel, ColumnIsTheAngleBetweenAxisAndPoint) {
  const LineScannerOptions options;
  const CameraModel camera(options);
  const double axis = std::atan2(options.baseline_m, options.focus_distance_m);
  for (const double x : {-0.002, 0.0, 0.001}) {
    for (const double z : {0.6, 0.9, 1.7}) {
      const double angle = axis - std::atan2(options.baseline_m - x, z);
      EXPECT_NEAR(camera.Column(x, z),
                  std::tan(angle) * options.focal_length_m / options.pixel_pitch_m, 1e-9);
    }
  }
  EXPECT_NEAR(camera.Column(0.0, options.focus_distance_m), 0.0, 1e-9);
}

TEST(CameraModel, DepthPerPixelIsTheDerivative) {
  const CameraModel camera{LineScannerOptions{}};
  for (const double z : {0.6, 1.0, 1.8}) {
    const double u = camera.Column(0.0, z);
    const double h = 1e-4;
    EXPECT_NEAR(camera.DepthPerPixel(z), (*camera.Depth(u + h) - *camera.Depth(u - h)) / (2 * h),
                1e-7);
  }
}

TEST(CameraModel, NoDepthWhereTheRaysDoNotMeet) {
  const LineScannerOptions options;
  const CameraModel camera(options);
  // A ray parallel to the fan has q = tan(alpha) = b / F.
  const double parallel_px = options.baseline_m / options.focus_distance_m *
                             options.focal_length_m / options.pixel_pitch_m;
  EXPECT_TRUE(camera.Depth(parallel_px - 1.0));
  EXPECT_FALSE(camera.Depth(parallel_px));
  EXPECT_FALSE(camera.Depth(parallel_px + 1.0));
}

TEST(CameraModel, TheWindowEndsBeforeTheFloor) {
  const CameraModel camera{LineScannerOptions{}};
  EXPECT_FALSE(camera.InView({0.0, 0.0, 0.50}));
  EXPECT_TRUE(camera.InView({0.0, 0.0, 0.55}));
  EXPECT_TRUE(camera.InView({0.0, 0.0, 2.2}));
  EXPECT_FALSE(camera.InView({0.0, 0.0, 2.4}));
}

TEST(CameraModel, TheColumnsSpanTheFanWithTheDefaultLens) {
  const LineScannerOptions options;
  const double sensor_rad =
      2.0 * std::atan(0.5 * options.samples * options.pixel_pitch_m / options.focal_length_m);
  EXPECT_NEAR(sensor_rad, options.fan_rad, base::Deg(1.0));
}

TEST(PanAngle, IsSymmetricAndEvenlySpaced) {
  LineScannerOptions options;
  options.profiles = 11;
  EXPECT_DOUBLE_EQ(PanAngle(options, 0), -0.5 * options.pan_range_rad);
  EXPECT_DOUBLE_EQ(PanAngle(options, 5), 0.0);
  EXPECT_DOUBLE_EQ(PanAngle(options, 10), 0.5 * options.pan_range_rad);
  options.profiles = 1;
  EXPECT_EQ(PanAngle(options, 0), 0.0);
}

TEST(DepthSigma, GrowsWithTheSquareOfTheAxialDistance) {
  const LineScannerOptions options;
  const CameraModel camera(options);
  const double ratio = camera.AxialDistance(0.0, 1.4) / camera.AxialDistance(0.0, 0.7);
  EXPECT_NEAR(DepthSigma(options, 1.4) / DepthSigma(options, 0.7), ratio * ratio, 1e-12);
}

TEST(DepthSigma, OfSpeckleAloneIsItsOptionAtOneMetre) {
  LineScannerOptions options;
  options.centroid_sigma_px = options.quantisation_px = 0.0;
  EXPECT_NEAR(DepthSigma(options, 1.0), options.speckle_sigma_m, 1e-15);
}

// An error that is uniform over a step q has the standard deviation q / sqrt(12).
TEST(DepthSigma, OfQuantisationAloneIsThatOfAUniformError) {
  LineScannerOptions options;
  options.centroid_sigma_px = options.speckle_sigma_m = 0.0;
  options.quantisation_px = 0.5;
  const CameraModel camera(options);
  const double u = camera.Column(0.0, 1.0);
  const double h = 1e-3;
  const double depth_per_px = (*camera.Depth(u + h) - *camera.Depth(u - h)) / (2.0 * h);
  EXPECT_NEAR(DepthSigma(options, 1.0) / (std::abs(depth_per_px) * 0.5 / std::sqrt(12.0)), 1.0,
              1e-6);
}

using base::Deg;

TEST(IncidenceLoss, RisesFromSixtyToEightyDegrees) {
  const LineScannerOptions options;
  EXPECT_EQ(IncidenceLoss(options, 0.0), 0.0);
  EXPECT_EQ(IncidenceLoss(options, Deg(60.0)), 0.0);
  EXPECT_NEAR(IncidenceLoss(options, Deg(65.0)), 0.25, 1e-12);
  EXPECT_NEAR(IncidenceLoss(options, Deg(70.0)), 0.5, 1e-12);
  EXPECT_NEAR(IncidenceLoss(options, Deg(80.0)), 1.0, 1e-12);
  EXPECT_EQ(IncidenceLoss(options, Deg(90.0)), 1.0);
}

TEST(AlbedoLoss, DarkSurfacesLoseHalfToNineTenths) {
  EXPECT_EQ(AlbedoLoss(0.7), 0.0);
  EXPECT_EQ(AlbedoLoss(0.10), 0.0);
  EXPECT_NEAR(AlbedoLoss(0.05), 0.5, 1e-12);
  EXPECT_NEAR(AlbedoLoss(0.0), 0.9, 1e-12);
  EXPECT_NEAR(AlbedoLoss(0.075), 0.25, 1e-12);  // linear in between
  EXPECT_NEAR(AlbedoLoss(0.025), 0.7, 1e-12);
  for (double a = 0.0; a < 0.2; a += 0.001) EXPECT_GE(AlbedoLoss(a), AlbedoLoss(a + 0.001));
}

TEST(GlossLoss, OnlyNearTheMirrorDirection) {
  const LineScannerOptions options;
  EXPECT_EQ(GlossLoss(options, 0.6, Deg(4.9)), 0.6);
  EXPECT_EQ(GlossLoss(options, 0.6, Deg(5.1)), 0.0);
}

TEST(SampleLoss, DarknessAndClarityAreIndependent) {
  EXPECT_NEAR(SampleLoss(0.05, 0.2), 1.0 - 0.5 * 0.8, 1e-12);
  EXPECT_EQ(SampleLoss(0.7, 0.0), 0.0);
}

TEST(PatchLoss, IncidenceAndGlossAreIndependent) {
  const LineScannerOptions options;
  EXPECT_NEAR(PatchLoss(options, 0.4, Deg(70.0), Deg(1.0)), 1.0 - 0.5 * 0.6, 1e-12);
  EXPECT_EQ(PatchLoss(options, 0.4, 0.0, Deg(180.0)), 0.0);
}

// In sRGB, half of the light is level 188 of 255.
TEST(PrintAlbedo, IsLinearInTheLightOfTheRedChannel) {
  EXPECT_NEAR(PrintAlbedo(0), 0.04, 1e-12);
  EXPECT_NEAR(PrintAlbedo(255), 0.85, 1e-12);
  EXPECT_NEAR(PrintAlbedo(188), 0.04 + 0.81 * 0.503, 1e-3);
  for (int red = 0; red < 255; ++red) {
    EXPECT_LT(PrintAlbedo(static_cast<std::uint8_t>(red)),
              PrintAlbedo(static_cast<std::uint8_t>(red + 1)));
  }
}

TEST(BrightestBlob, IsTheCentroidOfWhatLiesWithinOneWidth) {
  std::array<Glint, 3> glints = {{{3.0, 2.0, 0}, {1.0, 1.0, 1}, {2.0, 1.0, 2}}};
  const Blob blob = BrightestBlob(glints, 1.0);
  EXPECT_NEAR(blob.column_px, 9.0 / 4.0, 1e-12);
  EXPECT_NEAR(blob.brightness, 4.0, 1e-12);
  EXPECT_EQ(blob.source, 0u);
}

TEST(BrightestBlob, OfTwoPeaksTheBrighterWins) {
  std::array<Glint, 4> glints = {{{0.0, 1.0, 0}, {0.5, 1.0, 1}, {9.0, 1.5, 2}, {9.5, 1.0, 3}}};
  const Blob blob = BrightestBlob(glints, 2.0);
  EXPECT_NEAR(blob.column_px, (9.0 * 1.5 + 9.5) / 2.5, 1e-12);
  EXPECT_EQ(blob.source, 2u);
}

TEST(BrightestBlob, OfEqualPeaksTheFirstInTheImageWins) {
  std::array<Glint, 2> glints = {{{9.0, 1.0, 0}, {0.0, 1.0, 1}}};
  EXPECT_EQ(BrightestBlob(glints, 2.0).source, 1u);
}

TEST(BrightestBlob, WithoutLightThereIsNone) { EXPECT_EQ(BrightestBlob({}, 1.0).brightness, 0.0); }

using Eigen::Vector3d;
using geometry::samples::RandomDirection;
using geometry::samples::RandomPoint;

std::vector<sim::VisualMesh> RandomTriangles(base::Rng& rng) {
  std::vector<sim::VisualMesh> meshes(5);
  for (auto& mesh : meshes) {
    for (std::uint32_t t = 0; t < 20; ++t) {
      const Vector3d center = RandomPoint(1.0, rng);
      for (int k = 0; k < 3; ++k)
        mesh.mesh_W.vertices.push_back(center + 0.4 * RandomPoint(1.0, rng));
      mesh.mesh_W.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
  }
  return meshes;
}

/// A crossing found by solving o + t d = a + u (b - a) + v (c - a); `margin` is how far inside the
/// triangle it lies, negative outside.
struct Crossing {
  double distance_m;
  double margin;
};

std::optional<Crossing> Cross(const Vector3d& o, const Vector3d& d, const Vector3d& a,
                              const Vector3d& b, const Vector3d& c) {
  Eigen::Matrix3d m;
  m << -d, b - a, c - a;
  if (std::abs(m.determinant()) < 1e-9) return std::nullopt;
  const Vector3d tuv = m.fullPivLu().solve(o - a);
  return Crossing{tuv.x(), std::min({tuv.y(), tuv.z(), 1.0 - tuv.y() - tuv.z()})};
}

struct Reference {
  double distance_m = std::numeric_limits<double>::infinity();
  std::uint32_t mesh = Hit::kNone;
  Vector3d normal = Vector3d::Zero();
  bool doubtful = false;  ///< passes a triangle's edge or the near end within rounding
};

Reference BruteForce(std::span<const sim::VisualMesh> meshes, const Ray& ray) {
  Reference best;
  const Vector3d o = ray.origin_W.cast<double>();
  const Vector3d d = ray.direction_W.cast<double>();
  for (std::uint32_t i = 0; i < meshes.size(); ++i) {
    const auto& v = meshes[i].mesh_W.vertices;
    for (const auto& t : meshes[i].mesh_W.triangles) {
      const auto crossing = Cross(o, d, v[t[0]], v[t[1]], v[t[2]]);
      if (!crossing || crossing->distance_m < 0.0) continue;
      const double from_near = crossing->distance_m - static_cast<double>(ray.near_m);
      if (std::abs(crossing->margin) < 1e-4 ||
          (crossing->margin > 0.0 && std::abs(from_near) < 1e-5)) {
        best.doubtful = true;
      }
      if (crossing->margin < 0.0 || from_near < 0.0) continue;
      if (crossing->distance_m >= best.distance_m) continue;
      best.distance_m = crossing->distance_m;
      best.mesh = i;
      best.normal = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).normalized();
    }
  }
  return best;
}

TEST(RayCaster, AgreesWithBruteForceOnRandomScenes) {
  int compared = 0;
  int found = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    base::Rng rng(seed);
    const auto meshes = RandomTriangles(rng);
    const RayCaster caster = CasterOf(meshes);
    std::vector<Ray> rays;
    for (int i = 0; i < 203; ++i) {  // not a multiple of a packet
      const Vector3d origin = 1.5 * RandomPoint(1.0, rng);
      rays.push_back({origin.cast<float>(), RandomDirection(rng).cast<float>(), 0.1f, 10.0f});
    }
    std::vector<Hit> hits;
    std::vector<std::uint8_t> blocked;
    caster.FirstHits(rays, hits);
    caster.Blocked(rays, blocked);
    ASSERT_EQ(hits.size(), rays.size());
    ASSERT_EQ(blocked.size(), rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Reference reference = BruteForce(meshes, rays[i]);
      if (reference.doubtful) continue;
      ++compared;
      ASSERT_EQ(hits[i].mesh, reference.mesh) << "seed " << seed << " ray " << i;
      EXPECT_EQ(blocked[i] != 0, hits[i].found());
      if (!hits[i].found()) continue;
      ++found;
      // Coordinates up to 2 m in single precision, at oblique angles, give some 1e-6 m.
      EXPECT_NEAR(hits[i].distance_m, reference.distance_m, 2e-5);
      EXPECT_NEAR(std::abs(hits[i].normal_W.cast<double>().dot(reference.normal)), 1.0, 1e-4);
      EXPECT_LE(hits[i].normal_W.dot(rays[i].direction_W), 0.0f);
    }
  }
  EXPECT_GT(compared, 3500);
  EXPECT_GT(found, 700);
}

TEST(RayCaster, RespectsBothEndsOfARay) {
  const std::vector meshes = {test::Level(1.0, -1, 1, -1, 1)};
  const RayCaster caster = CasterOf(meshes);
  const Eigen::Vector3f o = Eigen::Vector3f::Zero();
  const Eigen::Vector3f up = Eigen::Vector3f::UnitZ();
  const std::vector<Ray> rays = {
      {o, up, 0.0f, 2.0f}, {o, up, 1.5f, 2.0f}, {o, up, 0.0f, 0.5f}, {o, up, 0.5f, -0.5f}};
  std::vector<std::uint8_t> blocked;
  caster.Blocked(rays, blocked);
  EXPECT_EQ(blocked, (std::vector<std::uint8_t>{1, 0, 0, 0}));
}

TEST(RayCaster, WithoutMeshesNothingIsMet) {
  const RayCaster caster = CasterOf({});
  const std::vector<Ray> rays(3, {Eigen::Vector3f::Zero(), Eigen::Vector3f::UnitX(), 0.0f, 9.0f});
  std::vector<Hit> hits;
  caster.FirstHits(rays, hits);
  for (const Hit& hit : hits) EXPECT_FALSE(hit.found());
}

}  // namespace

}  // namespace rangegrasp::sensing
