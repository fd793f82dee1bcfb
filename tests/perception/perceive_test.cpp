// Top surfaces, rotation axes, merging and completion on synthetic scans of known shapes, through
// the whole pipeline.
#include "perception/perceive.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "perception/analytic.h"
#include "perception/raster_scan.h"

namespace rangegrasp::perception {
namespace {

using Eigen::Vector3d;
using geometry::TriangleMesh;
using synthetic::Lying;
using synthetic::Standing;

constexpr std::uint64_t kSeeds = 6;

struct Place {
  double x;
  double y;
  double yaw;
};
Place RandomPlace(std::uint64_t seed) {
  base::Rng rng(base::DeriveSeed(seed, "place"));
  const double x = rng.Uniform(-0.06, 0.06);
  const double y = rng.Uniform(-0.06, 0.06);
  return {x, y, rng.Uniform(0.0, 2.0 * base::kPi)};
}

Scene PerceiveSee(const std::vector<TriangleMesh>& meshes, std::uint64_t seed,
                  const PerceptionOptions& options = {}) {
  synthetic::RasterOptions raster;
  raster.seed = seed;
  base::Rng rng(seed);
  return Perceive(synthetic::MakeRasterScan(meshes, raster).points_W, raster.sensor_W, options,
                  rng);
}

TriangleMesh Stand(const TriangleMesh& mesh, double height_m, const Place& p) {
  return geometry::Transformed(mesh, Standing(p.yaw, {p.x, p.y, 0.5 * height_m}));
}

TriangleMesh LieAt(const TriangleMesh& mesh, double height_m, const Place& p) {
  return geometry::Transformed(mesh, Lying(p.yaw, {p.x, p.y, height_m}));
}

// The noise of 0.4 mm averages out over hundreds of points. The scan's raster (1.8 mm) and the
// smoothing at edges (3 mm) remain; averages may be off by half a raster step.
constexpr double kFine_m = 0.0009;
// Extents end within one raster step on either side, seen at up to 53 deg.
constexpr double kExtent_m = 0.003;
// Mirroring doubles the errors of the raster step (1.8 mm) and of the ridge's position on the seen
// side.
constexpr double kMirrored_m = 0.004;

TEST(Perceive, AStandingCylinderIsRotationalAndClosedWithItsRadiusAndAxis) {
  for (const double radius : {0.035, 0.0375, 0.0425}) {
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const Place place = RandomPlace(seed);
      const double height = radius > 0.04 ? 0.065 : 0.115;
      const Scene scene =
          PerceiveSee({Stand(synthetic::CylinderMesh(radius, height), height, place)}, seed);
      ASSERT_EQ(scene.objects.size(), 1u);
      const PerceivedObject& object = scene.objects[0];
      ASSERT_EQ(object.kind, ObjectKind::kRotational) << radius << " " << seed;
      EXPECT_FALSE(object.open);
      EXPECT_NEAR(object.axis->radius_m, radius, kFine_m);
      EXPECT_NEAR(object.axis->center_C.x(), place.x, kFine_m);
      EXPECT_NEAR(object.axis->center_C.y(), place.y, kFine_m);
      EXPECT_GT(object.axis->direction_C.z(), std::cos(base::Deg(1.0)));
      EXPECT_NEAR(object.height_m, height, kFine_m);
      EXPECT_EQ(object.base_m, 0.0);
      // The 36-sided polygon has 0.5 % less area than the circle.
      const double volume = base::kPi * radius * radius * height;
      EXPECT_NEAR(geometry::Volume(object.surface_C), volume, 0.06 * volume);
    }
  }
}

TEST(Perceive, ATaperedTubIsRotational) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Place place = RandomPlace(seed);
    const auto tub = synthetic::Turned({{0, 0}, {0.035, 0}, {0.0425, 0.065}, {0, 0.065}});
    const Scene scene =
        PerceiveSee({geometry::Transformed(tub, Standing(0, {place.x, place.y, 0}))}, seed);
    ASSERT_EQ(scene.objects.size(), 1u);
    ASSERT_EQ(scene.objects[0].kind, ObjectKind::kRotational) << seed;
    EXPECT_NEAR(scene.objects[0].axis->center_C.x(), place.x, kFine_m);
    EXPECT_NEAR(scene.objects[0].axis->center_C.y(), place.y, kFine_m);
  }
}

TEST(Perceive, AMugIsRotationalAndOpenAndItsCavityStaysEmpty) {
  for (std::uint64_t seed = 0; seed < 2 * kSeeds; ++seed) {
    Place place = RandomPlace(seed);
    place.yaw = 2.0 + 0.2 * static_cast<double>(seed);  // handle away from the sensor or aside
    const auto mug =
        geometry::Transformed(synthetic::MugMesh(), Standing(place.yaw, {place.x, place.y, 0.0}));
    const Scene scene = PerceiveSee({mug}, seed);
    ASSERT_FALSE(scene.objects.empty());
    const PerceivedObject& object = scene.objects[0];
    ASSERT_EQ(object.kind, ObjectKind::kRotational) << seed;
    EXPECT_TRUE(object.open);
    EXPECT_NEAR(object.axis->radius_m, 0.041, 1.5e-3);
    // The surface's volume excludes the cavity. The full cylinder has 502 cm^3; wall, floor and
    // handle have 124 cm^3. The floor is not seen, so part of the cavity stays filled.
    EXPECT_LT(geometry::Volume(object.surface_C), 380e-6) << seed;
  }
}

TEST(Perceive, PrismsAreNotRotational) {
  const std::vector<std::pair<TriangleMesh, double>> shapes{
      {synthetic::BoxMesh(0.075, 0.045, 0.12), 0.12},
      {synthetic::BoxMesh(0.06, 0.06, 0.10), 0.10},
      {synthetic::Extrude(synthetic::Regular(5, 0.04), 0.16), 0.16},
      {synthetic::Extrude(synthetic::Regular(3, 0.04), 0.10), 0.10}};
  for (const auto& [mesh, height] : shapes) {
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const Scene scene = PerceiveSee({Stand(mesh, height, RandomPlace(seed))}, seed);
      ASSERT_EQ(scene.objects.size(), 1u);
      EXPECT_EQ(scene.objects[0].kind, ObjectKind::kOther) << height << " " << seed;
      EXPECT_FALSE(scene.objects[0].open);
    }
  }
}

// Its corners extend 5 mm outward, so the distances alone nearly make it round.
TEST(Perceive, AHexagonalColumnIsNotRotational) {
  const auto mesh = synthetic::Extrude(synthetic::Regular(6, 0.04), 0.10);
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Scene scene = PerceiveSee({Stand(mesh, 0.10, RandomPlace(seed))}, seed);
    ASSERT_EQ(scene.objects.size(), 1u);
    EXPECT_EQ(scene.objects[0].kind, ObjectKind::kOther) << seed;
  }
}

TEST(Perceive, ABoxHasItsTopFaceAndItsBox) {
  for (std::uint64_t seed = 0; seed < 2 * kSeeds; ++seed) {
    const Place place = RandomPlace(seed);
    const Scene scene =
        PerceiveSee({Stand(synthetic::BoxMesh(0.09, 0.06, 0.135), 0.135, place)}, seed);
    ASSERT_EQ(scene.objects.size(), 1u);
    const PerceivedObject& object = scene.objects[0];
    ASSERT_TRUE(object.top);
    EXPECT_FALSE(object.top->ridge);
    EXPECT_GT(object.top->plane.normal.z(), std::cos(base::Deg(1.5)));
    EXPECT_NEAR(object.top->major_m, 0.09, kExtent_m);
    EXPECT_NEAR(object.top->minor_m, 0.06, kExtent_m);
    const Vector3d along(std::cos(place.yaw), std::sin(place.yaw), 0.0);
    EXPECT_GT(std::abs(object.axis_C.dot(along)), std::cos(base::Deg(3.0)));
    EXPECT_NEAR(object.size_m.x(), 0.09, kExtent_m);
    EXPECT_NEAR(object.size_m.y(), 0.06, kExtent_m);
    EXPECT_NEAR(object.size_m.z(), 0.135, kFine_m);
  }
}

TEST(Perceive, ALyingCylinderIsCompletedToItsWidthWhateverItsYaw) {
  for (int step = 0; step < 12; ++step) {
    const double yaw = base::kPi * step / 12;
    const Scene scene =
        PerceiveSee({LieAt(synthetic::CylinderMesh(0.035, 0.115), 0.035, {0.01, -0.02, yaw})}, 7);
    ASSERT_EQ(scene.objects.size(), 1u);
    const PerceivedObject& object = scene.objects[0];
    ASSERT_TRUE(object.top && object.top->ridge) << step;
    const Vector3d along(std::cos(yaw), std::sin(yaw), 0.0);
    EXPECT_GT(std::abs(object.top->major_C.dot(along)), std::cos(base::Deg(2.0)));
    EXPECT_NEAR(object.size_m.y(), 0.07, kMirrored_m) << step;
    EXPECT_NEAR(object.size_m.x(), 0.115, 0.004) << step;
    EXPECT_NEAR(object.center_C.x(), 0.01, 0.002) << step;
    EXPECT_NEAR(object.center_C.y(), -0.02, 0.002) << step;
  }
}

TEST(Perceive, WithoutSymmetryALyingCylinderLacksItsFarSide) {
  PerceptionOptions options;
  options.features.complete_by_symmetry = false;
  options.features.lying_axes = false;  // A completion about the axis would have it.
  const Scene scene = PerceiveSee(
      {LieAt(synthetic::CylinderMesh(0.035, 0.115), 0.035, {0, 0, base::kPi / 2})}, 1, options);
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_LT(scene.objects[0].size_m.y(), 0.062);
}

/// Removes the points in a strip of the x-y plane: |offset across the direction| < half.
geometry::Points WithoutStrip(const geometry::Points& points, const Vector3d& center,
                              const Vector3d& across, double half_m) {
  geometry::Points kept;
  for (const auto& p : points) {
    if (p.z() < 0.003 || std::abs((p - center).dot(across)) > half_m) kept.push_back(p);
  }
  return kept;
}

TEST(Merging, ACylinderCutInTwoByLostPointsIsOneObject) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Place place = RandomPlace(seed);
    synthetic::RasterOptions raster;
    raster.seed = seed;
    const auto scan = synthetic::MakeRasterScan(
        {Stand(synthetic::CylinderMesh(0.0375, 0.15), 0.15, place)}, raster);
    const auto cut = WithoutStrip(scan.points_W, {place.x, place.y, 0}, Vector3d::UnitY(), 0.012);
    base::Rng rng(seed);
    const Scene scene = Perceive(cut, raster.sensor_W, {}, rng);
    EXPECT_EQ(scene.segments.size(), 2u);
    ASSERT_EQ(scene.objects.size(), 1u) << seed;
    ASSERT_EQ(scene.objects[0].kind, ObjectKind::kRotational);
    EXPECT_NEAR(scene.objects[0].axis->radius_m, 0.0375, kFine_m);
  }
}

TEST(Merging, TwoEqualCylindersBesideEachOtherRemainTwo) {
  for (int step = 0; step < 8; ++step) {
    const double a = base::kPi * step / 8;
    const Vector3d d(0.047 * std::cos(a), 0.047 * std::sin(a), 0.05);
    const auto cylinder = synthetic::CylinderMesh(0.035, 0.10);
    const Scene scene =
        PerceiveSee({geometry::Transformed(cylinder, Standing(0, d)),
                     geometry::Transformed(cylinder, Standing(0, {-d.x(), -d.y(), d.z()}))},
                    static_cast<std::uint64_t>(step));
    EXPECT_EQ(scene.objects.size(), 2u) << step;
  }
}

TEST(Merging, BoxesBesideAndBehindEachOtherRemainTwo) {
  for (const double gap : {0.026, 0.034}) {
    for (const bool behind : {false, true}) {
      const double d = 0.5 * (0.06 + gap);
      const Vector3d offset = behind ? Vector3d(d, 0, 0.04) : Vector3d(0, d, 0.04);
      const auto box = synthetic::BoxMesh(0.06, 0.06, 0.08);
      const Scene scene =
          PerceiveSee({geometry::Transformed(box, Standing(0, offset)),
                       geometry::Transformed(box, Standing(0, {-offset.x(), -offset.y(), 0.04}))},
                      3);
      EXPECT_EQ(scene.objects.size(), 2u) << gap << " " << behind;
    }
  }
}

TEST(Merging, AFrontFaceCutOffFromItsTopIsJoined) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Place place = RandomPlace(seed);
    place.yaw = 0.0;
    synthetic::RasterOptions raster;
    raster.seed = seed;
    const auto scan = synthetic::MakeRasterScan(
        {Stand(synthetic::BoxMesh(0.06, 0.08, 0.12), 0.12, place)}, raster);
    geometry::Points cut;
    for (const auto& p : scan.points_W) {
      const bool edge = p.x() > place.x + 0.018 && p.z() > 0.1;
      const bool side = p.z() > 0.1 && p.z() < 0.117;
      if (!edge && !side) cut.push_back(p);
    }
    base::Rng rng(seed);
    PerceptionOptions options;
    Scene scene = Perceive(cut, raster.sensor_W, options, rng);
    ASSERT_GE(scene.segments.size(), 2u);
    EXPECT_EQ(scene.objects.size(), scene.segments.size());  // 20 mm is more than lost points
    options.features.merge.fragment_gap_m = 0.030;
    scene = Perceive(cut, raster.sensor_W, options, rng);
    EXPECT_EQ(scene.objects.size(), 1u) << seed;
  }
}

std::vector<TriangleMesh> MixedScene() {
  return {Stand(synthetic::CylinderMesh(0.035, 0.115), 0.115, {0.04, 0.08, 0}),
          Stand(synthetic::BoxMesh(0.09, 0.06, 0.135), 0.135, {-0.05, -0.02, 0.5}),
          LieAt(synthetic::CylinderMesh(0.0375, 0.15), 0.0375, {0.07, -0.08, 1.2}),
          geometry::Transformed(synthetic::MugMesh(), Standing(3.2, {-0.08, 0.10, 0.0})),
          Stand(synthetic::BoxMesh(0.05, 0.05, 0.05), 0.05, {-0.05, -0.13, 0.2})};
}

TEST(Perceive, KeepsItsPromisesAboutAScene) {
  const Scene scene = PerceiveSee(MixedScene(), 5);
  EXPECT_EQ(scene.objects.size(), 5u);
  const char* const names[] = {"sampling", "table",        "filter",  "smooth",    "normals",
                               "segments", "top surfaces", "merging", "completion"};
  ASSERT_EQ(scene.seconds.size(), std::size(names));
  for (std::size_t i = 0; i < std::size(names); ++i) EXPECT_EQ(scene.seconds[i].first, names[i]);
  std::vector<int> used(scene.cloud.size(), 0);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const PerceivedObject& object = scene.objects[i];
    if (i > 0) {
      EXPECT_LE(object.height_m, scene.objects[i - 1].height_m + 0.001);
    }
    EXPECT_GE(object.size_m.x(), object.size_m.y());
    EXPECT_TRUE(object.center_C.allFinite() && object.size_m.allFinite());
    EXPECT_FALSE(object.surface_C.triangles.empty());
    for (const auto k : object.points) EXPECT_EQ(++used[k], 1);
    for (const auto& p : object.completed_C) EXPECT_GE(scene.table.plane.Distance(p), -1e-9);
    for (const auto& p : object.surface_C.vertices) {
      EXPECT_GE(scene.table.plane.Distance(p), -1e-9);
    }
  }
}

TEST(Perceive, IsDeterministic) {
  const Scene a = PerceiveSee(MixedScene(), 6);
  const Scene b = PerceiveSee(MixedScene(), 6);
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (std::size_t i = 0; i < a.objects.size(); ++i) {
    EXPECT_EQ(a.objects[i].points, b.objects[i].points);
    EXPECT_EQ(a.objects[i].completed_C, b.objects[i].completed_C);
    EXPECT_TRUE(a.objects[i].surface_C.triangles == b.objects[i].surface_C.triangles);
    EXPECT_TRUE(a.objects[i].surface_C.vertices == b.objects[i].surface_C.vertices);
  }
}

TEST(Perceive, TurnsWithTheSceneAndTheSensor) {
  synthetic::RasterOptions raster;
  const auto scan = synthetic::MakeRasterScan(MixedScene(), raster);
  const base::Pose X = base::MakePose(Eigen::AngleAxisd(0.7, Vector3d::UnitZ()).toRotationMatrix(),
                                      {0.3, -0.2, 0.1});
  geometry::Points turned;
  for (const auto& p : scan.points_W) turned.push_back(X * p);
  base::Rng rng_a(1);
  base::Rng rng_b(1);
  const Scene a = Perceive(scan.points_W, raster.sensor_W, {}, rng_a);
  const Scene b = Perceive(turned, X * raster.sensor_W, {}, rng_b);
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (std::size_t i = 0; i < a.objects.size(); ++i) {
    EXPECT_EQ(a.objects[i].kind, b.objects[i].kind);
    EXPECT_EQ(a.objects[i].open, b.objects[i].open);
    // Direction cells and slices are aligned differently.
    EXPECT_NEAR((X * a.objects[i].center_C - b.objects[i].center_C).norm(), 0.0, 0.002) << i;
    EXPECT_NEAR((a.objects[i].size_m - b.objects[i].size_m).norm(), 0.0, 0.003) << i;
  }
}

TEST(Perceive, NamesWhatIsWrongWithTooFewPoints) {
  base::Rng rng(1);
  const geometry::Points few(10, Vector3d(0, 0, 0));
  EXPECT_THROW(Perceive(few, {0.8, 0, 0.6}, {}, rng), base::InputError);
}

TEST(Perceive, AnEmptyTableHasNoObjects) { EXPECT_TRUE(PerceiveSee({}, 1).objects.empty()); }

TEST(BuildObjects, SurvivesDegenerateSegments) {
  geometry::PointCloud cloud;
  std::vector<geometry::Indices> segments;
  const auto add = [&](const geometry::Points& points) {
    segments.emplace_back();
    for (const auto& p : points) {
      segments.back().push_back(static_cast<std::uint32_t>(cloud.size()));
      cloud.points.push_back(p);
      cloud.normals.push_back(Vector3d::UnitZ());
    }
  };
  add({{0, 0, 0.05}});
  add({{0.1, 0, 0.05}, {0.1, 0.01, 0.05}});
  add(geometry::Points(50, Vector3d(-0.1, 0, 0.03)));
  geometry::Points line, plane;
  for (int i = 0; i < 50; ++i) line.emplace_back(0.002 * i, 0.1, 0.04);
  for (int i = 0; i < 100; ++i) plane.emplace_back(0.002 * (i % 10), -0.1, 0.02 + 0.002 * (i / 10));
  add(line);
  add(plane);
  for (const Vector3d& normal : {Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(0, 0, -1)}) {
    for (auto& n : cloud.normals) n = normal;
    base::Rng rng(1);
    StageSeconds seconds;
    const samples::Given given(cloud);
    const auto objects = internal::BuildObjects(given.Context(), segments, rng, seconds);
    EXPECT_GE(objects.size(), 1u);
    for (const auto& object : objects) {
      EXPECT_TRUE(object.center_C.allFinite() && object.size_m.allFinite());
    }
  }
}

}  // namespace
}  // namespace rangegrasp::perception
