#include "perception/segment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

#include "geometry/plane.h"
#include "geometry/random_points.h"
#include "geometry/synthetic.h"
#include "perception/analytic.h"
#include "perception/perceive.h"
#include "perception/raster_scan.h"

namespace rangegrasp::perception {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using geometry::KdTree;
using geometry::PointCloud;
using geometry::Points;
using geometry::TriangleMesh;

const Vector3d kSegmentSensor(0.8, 0.0, 0.62);

/// The objects of a scan, without the table, with normals and a label for each point.
struct SegmentObjects {
  PointCloud cloud;
  std::vector<int> label;
};

SegmentObjects ScanObjects(const std::vector<synthetic::Solid>& solids, std::uint64_t seed) {
  synthetic::ScanOptions options;
  options.seed = seed;
  options.sigma_m = 0.0002;
  const auto scan = synthetic::MakeScan(solids, options);
  SegmentObjects objects;
  for (std::size_t i = 0; i < scan.label.size(); ++i) {
    if (scan.label[i] < 0 || scan.points_W[i].z() < 0.004) continue;
    objects.cloud.points.push_back(scan.points_W[i]);
    objects.label.push_back(scan.label[i]);
  }
  objects.cloud.normals =
      geometry::EstimateNormals(objects.cloud.points, KdTree(objects.cloud.points), 0.005,
                                geometry::Points{kSegmentSensor}, {});
  return objects;
}

SegmentObjects TwoBoxes(double gap_m, std::uint64_t seed) {
  return ScanObjects({synthetic::Box{{0.0, -0.02 - gap_m / 2.0, 0.04}, {0.04, 0.04, 0.08}, 0.0},
                      synthetic::Box{{0.0, 0.02 + gap_m / 2.0, 0.04}, {0.04, 0.04, 0.08}, 0.0}},
                     seed);
}

class BothMethods : public ::testing::TestWithParam<SegmentMethod> {
 protected:
  SegmentOptions Options() const {
    SegmentOptions options;
    options.method = GetParam();
    return options;
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, BothMethods,
                         ::testing::Values(SegmentMethod::kMesh, SegmentMethod::kRegionGrowing));

TEST_P(BothMethods, BoxesTwentyMillimetresApartAreTwoSegments) {
  const SegmentObjects objects = TwoBoxes(0.020, 1);
  const auto segments = Segment(objects.cloud, Options());
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_EQ(segments[0].size() + segments[1].size(), objects.cloud.size());
  for (const Indices& segment : segments) {
    for (const std::uint32_t i : segment) {
      EXPECT_EQ(objects.label[i], objects.label[segment.front()]);
    }
  }
}

TEST_P(BothMethods, TouchingBoxesAreOneSegment) {
  EXPECT_EQ(Segment(TwoBoxes(0.0005, 2).cloud, Options()).size(), 1u);
}

TEST_P(BothMethods, SegmentsDoNotDependOnTheOrderOfThePoints) {
  const SegmentObjects objects = ScanObjects(synthetic::MixedObjects(), 3);
  const auto segments = Segment(objects.cloud, Options());
  EXPECT_EQ(segments.size(), 5u);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    base::Rng rng(seed);
    const Indices order = geometry::samples::Permutation(objects.cloud.size(), rng);
    PointCloud shuffled;
    shuffled.points = geometry::Select(objects.cloud.points, order);
    shuffled.normals = geometry::Select(objects.cloud.normals, order);
    auto others = Segment(shuffled, Options());
    ASSERT_EQ(others.size(), segments.size());
    for (std::size_t k = 0; k < others.size(); ++k) {
      for (std::uint32_t& i : others[k]) i = order[i];
      std::sort(others[k].begin(), others[k].end());
      EXPECT_EQ(others[k], segments[k]);
    }
  }
}

TEST_P(BothMethods, SmallSegmentsAreDroppedAndTheRestGoesLargestFirst) {
  const SegmentObjects objects = ScanObjects(synthetic::MixedObjects(), 4);
  SegmentOptions options = Options();
  const auto all = Segment(objects.cloud, options);
  for (std::size_t k = 1; k < all.size(); ++k) EXPECT_LE(all[k].size(), all[k - 1].size());
  options.min_points = static_cast<int>(all[1].size());
  EXPECT_EQ(Segment(objects.cloud, options).size(), 2u);
}

TEST_P(BothMethods, TinyCloudsHaveNoSegment) {
  PointCloud cloud;
  EXPECT_TRUE(Segment(cloud, Options()).empty());
  cloud.points = {{0.0, 0.0, 0.0}};
  cloud.normals = {{0.0, 0.0, 1.0}};
  EXPECT_TRUE(Segment(cloud, Options()).empty());
}

TEST(NormalWeight, FollowsItsEquations) {
  base::Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const Vector3d a = geometry::samples::RandomPoint(1.0, rng);
    const Vector3d b = geometry::samples::RandomPoint(1.0, rng);
    const double cosine = (a.x() * b.x() + a.y() * b.y() + a.z() * b.z()) /
                          (std::sqrt(a.dot(a)) * std::sqrt(b.dot(b)));  // eq. 5.3
    EXPECT_NEAR(NormalWeight(a, b), 1.0 - std::abs(cosine), 1e-14);     // eq. 5.4
    EXPECT_NEAR(NormalWeight(a, -3.0 * a), 0.0, 1e-14);
  }
  EXPECT_EQ(NormalWeight({1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}), 1.0);
}

/// Algorithm 2 as a flood fill over all pairs.
std::vector<Indices> FloodFill(const PointCloud& cloud, double d_a, double neighborhood) {
  std::vector<bool> done(cloud.size(), false);
  std::vector<Indices> regions;
  for (std::uint32_t start = 0; start < cloud.size(); ++start) {
    if (done[start]) continue;
    Indices region = {start};
    done[start] = true;
    for (std::size_t k = 0; k < region.size(); ++k) {
      const std::uint32_t i = region[k];
      for (std::uint32_t m = 0; m < cloud.size(); ++m) {
        const double d = (cloud.points[i] - cloud.points[m]).norm();  // eq. 5.2
        if (done[m] || d >= neighborhood * d_a) continue;
        if (d * NormalWeight(cloud.normals[i], cloud.normals[m]) >= d_a) continue;
        done[m] = true;
        region.push_back(m);
      }
    }
    std::sort(region.begin(), region.end());
    regions.push_back(region);
  }
  std::stable_sort(regions.begin(), regions.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return regions;
}

TEST(RegionGrowing, IsTheFloodFillOfAlgorithm2) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    base::Rng rng(seed);
    PointCloud cloud;
    cloud.points = geometry::samples::RandomPoints(300, 0.02, rng);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      cloud.normals.push_back(geometry::samples::RandomDirection(rng));
    }
    const double d_a =
        geometry::NearestNeighborDistances(cloud.points, KdTree(cloud.points)).mean_m;
    SegmentOptions options;
    options.min_points = 1;
    for (const double neighborhood : {1.5, 3.0, 6.0}) {
      options.neighborhood = neighborhood;
      const auto regions = SegmentByRegionGrowing(cloud.points, cloud.normals, options);
      EXPECT_EQ(regions, FloodFill(cloud, d_a, neighborhood));
      options.method = SegmentMethod::kRegionGrowing;
      EXPECT_EQ(Segment(cloud, options), regions);
    }
  }
}

TEST(RegionGrowing, NeedsOneNormalAPoint) {
  EXPECT_THROW(SegmentByRegionGrowing(Points(3, {0.0, 0.0, 0.0}), Points{}, {}),
               std::invalid_argument);
}

TEST(MeshAlpha, IsTheLargestNeighbourDistanceWithinBounds) {
  SegmentOptions options;
  EXPECT_EQ(MeshAlpha(0.005, options), 0.005);
  EXPECT_EQ(MeshAlpha(0.001, options), options.min_alpha_m);
  EXPECT_EQ(MeshAlpha(0.200, options), options.max_alpha_m);
}

TEST(MeshSegmentation, OneStragglerDoesNotJoinWhatIsApart) {
  SegmentObjects objects = TwoBoxes(0.030, 5);
  objects.cloud.points.emplace_back(0.0, 0.0, 0.3);  // d_max = 0.2 m
  EXPECT_EQ(SegmentByMesh(objects.cloud.points, {}).size(), 2u);
}

TEST(MeshSegmentation, TwinsShareASegmentAndPointsWithoutATriangleHaveNone) {
  SegmentOptions options;
  options.drop_small_segments = false;
  const Points points = {{0.0, 0.0, 0.0},   {0.004, 0.0, 0.0}, {0.0, 0.004, 0.0},
                         {0.0, 0.0, 0.004}, {0.004, 0.0, 0.0}, {9.0, 9.0, 9.0}};
  EXPECT_EQ(SegmentByMesh(points, options), (std::vector<Indices>{{0, 1, 2, 3, 4}}));
}

// Objects that touch, lean on or lie on each other are separated; objects of one piece are not.

/// A sensor: its ray spacing [rad] and noise [m]; every `every_row`-th row of rays is kept.
struct SensorCase {
  double pitch_rad;
  double sigma_m;
  int every_row;
};

/// The scan with only some rows of rays, like a line scanner with a larger line spacing.
synthetic::RasterScan Scan(const std::vector<TriangleMesh>& meshes, const SensorCase& sensor) {
  synthetic::RasterOptions options;
  options.pitch_rad = sensor.pitch_rad;
  options.sigma_m = sensor.sigma_m;
  const auto scan = synthetic::MakeRasterScan(meshes, options);
  if (sensor.every_row == 1) return scan;
  // Rays of one row share a plane through the sensor, so the elevation in its frame gives the row.
  const Vector3d forward = (Vector3d(0, 0, 0.04) - options.sensor_W).normalized();
  const Vector3d down = forward.cross(forward.cross(Vector3d::UnitZ()).normalized());
  synthetic::RasterScan kept;
  for (std::size_t i = 0; i < scan.points_W.size(); ++i) {
    const Vector3d d = scan.points_W[i] - options.sensor_W;
    const long row = std::lround(d.dot(down) / d.dot(forward) / options.pitch_rad);
    if (row % sensor.every_row != 0) continue;
    kept.points_W.push_back(scan.points_W[i]);
    kept.label.push_back(scan.label[i]);
  }
  return kept;
}

/// What perception makes of a scan from the default place.
Scene SceneOf(const synthetic::RasterScan& scan, const PerceptionOptions& options = {}) {
  base::Rng rng(1);
  return Perceive(scan.points_W, synthetic::RasterOptions{}.sensor_W, options, rng);
}

/// The object that has most of a mesh's points, and the share of the points it has.
struct Owner {
  std::size_t object = 0;
  double share = 0.0;
};

class TouchingThings : public ::testing::TestWithParam<SensorCase> {
 protected:
  std::vector<Owner> See(const std::vector<TriangleMesh>& meshes) {
    const auto scan = Scan(meshes, GetParam());
    scene_ = SceneOf(scan);
    std::vector<std::map<std::size_t, int>> in(meshes.size());
    for (std::size_t o = 0; o < scene_.objects.size(); ++o) {
      for (const auto i : scene_.objects[o].points) {
        const int mesh = scan.label[scene_.source[i]];
        if (mesh >= 0) ++in[static_cast<std::size_t>(mesh)][o];
      }
    }
    std::vector<Owner> owners;
    for (const auto& counts : in) {
      Owner owner;
      int most = 0;
      int sum = 0;
      for (const auto& [o, count] : counts) {
        sum += count;
        if (count > most) owner.object = o;
        most = std::max(most, count);
      }
      owner.share = sum > 0 ? static_cast<double>(most) / sum : 0.0;
      owners.push_back(owner);
    }
    return owners;
  }
  Scene scene_;
};

/// A patch along the seam may go to the other object: 20 mm of faces of at least 60 mm.
constexpr double kMost = 0.75;

TriangleMesh At(const TriangleMesh& mesh, double yaw, const Vector3d& p) {
  return geometry::Transformed(mesh, synthetic::Standing(yaw, p));
}

TEST_P(TouchingThings, ALowBoxBeforeATallOneIsAnother) {
  const auto owners = See({At(synthetic::BoxMesh(0.06, 0.09, 0.15), 0.0, {-0.05, 0.0, 0.075}),
                           At(synthetic::BoxMesh(0.08, 0.08, 0.06), 0.0, {0.02, 0.0, 0.03})});
  EXPECT_NE(owners[0].object, owners[1].object);
  EXPECT_GT(owners[0].share, kMost);
  EXPECT_GT(owners[1].share, kMost);
}

TEST_P(TouchingThings, ABoxLeaningOnACylinderIsAnother) {
  const base::Pose leaning = base::MakePose(
      Eigen::AngleAxisd(-0.6, Vector3d::UnitX()).toRotationMatrix(), {0.0, -0.078, 0.062});
  const auto owners = See({At(synthetic::CylinderMesh(0.0375, 0.15), 0.0, {0.0, 0.03, 0.075}),
                           geometry::Transformed(synthetic::BoxMesh(0.10, 0.03, 0.13), leaning)});
  EXPECT_NE(owners[0].object, owners[1].object);
  EXPECT_GT(owners[0].share, kMost);
  EXPECT_GT(owners[1].share, kMost);
}

TEST_P(TouchingThings, ASmallBoxOnALargeOneIsAnother) {
  const auto owners = See({At(synthetic::BoxMesh(0.16, 0.14, 0.07), 0.1, {0.0, 0.0, 0.035}),
                           At(synthetic::BoxMesh(0.06, 0.06, 0.06), 0.4, {0.0, 0.0, 0.10})});
  EXPECT_NE(owners[0].object, owners[1].object);
  EXPECT_GT(owners[0].share, kMost);
  EXPECT_GT(owners[1].share, kMost);
}

TEST_P(TouchingThings, AThingThatHangsOverTheOneItLiesOnIsNoHandle) {
  // The sensor sees the table below the overhang.
  const auto owners = See({At(synthetic::BoxMesh(0.09, 0.10, 0.09), 0.0, {0.0, -0.05, 0.045}),
                           At(synthetic::BoxMesh(0.07, 0.16, 0.03), 0.0, {0.0, 0.06, 0.105})});
  EXPECT_NE(owners[0].object, owners[1].object);
  EXPECT_GT(owners[0].share, kMost);
  EXPECT_GT(owners[1].share, kMost);
}

TEST_P(TouchingThings, ABoxStaysOne) {
  for (const double yaw : {0.0, 0.4, 0.8}) {
    const auto owners = See({At(synthetic::BoxMesh(0.09, 0.06, 0.135), yaw, {0.0, 0.0, 0.0675})});
    EXPECT_EQ(scene_.objects.size(), 1u) << yaw;
    EXPECT_GT(owners[0].share, 0.99);
  }
}

INSTANTIATE_TEST_SUITE_P(Sensors, TouchingThings,
                         ::testing::Values(SensorCase{0.001, 0.0003, 1},
                                           SensorCase{0.002, 0.0003, 1},
                                           SensorCase{0.0018, 0.0004, 3},
                                           SensorCase{0.0015, 0.0020, 1}),
                         [](const auto& tested) { return "Case" + std::to_string(tested.index); });

TEST(SegmentByConvexity, TheInsideOfARoundThingIsOneSurface) {
  // Patches of 15 mm differ by more than the assumed minimum noise.
  for (const double radius_m : {0.03, 0.04, 0.05}) {
    samples::Analytic shape;
    shape.AddWall({0.0, 0.0}, radius_m, 0.0, 0.08, -1.4, 1.4, true);
    EXPECT_EQ(SegmentByConvexity(shape.cloud, {}).size(), 1u) << radius_m;
  }
}

TEST(SegmentByConvexity, FlatThingsThatMeetAtARightAngleAreTwo) {
  samples::Analytic shape;
  shape.AddRectangle({0.0, 0.0, 0.0}, {0.04, 0.0, 0.0}, {0.0, 0.04, 0.0});
  shape.AddRectangle({-0.042, 0.0, 0.042}, {0.0, 0.04, 0.0}, {0.0, 0.0, 0.04});
  EXPECT_EQ(SegmentByConvexity(shape.cloud, {}).size(), 2u);
}

TEST(TouchingThingsOfOnePiece, ACupWithItsHandleIsOneObject) {
  const Scene scene =
      SceneOf(synthetic::MakeRasterScan({At(synthetic::MugMesh(), 3.2, Vector3d::Zero())}));
  ASSERT_GE(scene.objects.size(), 1u);
  std::size_t all = 0;
  for (const auto& object : scene.objects) all += object.points.size();
  EXPECT_GT(static_cast<double>(scene.objects[0].points.size()), 0.85 * static_cast<double>(all));
}

TEST(TouchingThingsOfOnePiece, AHandleThatHangsBesideItsCupIsOfIt) {
  // The handle points sideways, so the sensor sees all of it and the table below it.
  for (const double yaw : {1.3, 1.6, -1.6}) {
    const Scene scene =
        SceneOf(synthetic::MakeRasterScan({At(synthetic::MugMesh(), yaw, Vector3d::Zero())}));
    EXPECT_EQ(scene.objects.size(), 1u) << yaw;
  }
}

synthetic::RasterScan ScanOnTable(const std::vector<TriangleMesh>& meshes, double table_half_m) {
  synthetic::RasterOptions raster;
  raster.table_half_m = table_half_m;
  return synthetic::MakeRasterScan(meshes, raster);
}

/// Four walls, 6 mm thick and 100 mm high, around 300 x 300 mm.
std::vector<TriangleMesh> OpenBox() {
  const auto along = synthetic::BoxMesh(0.312, 0.006, 0.10);
  const auto across = synthetic::BoxMesh(0.006, 0.30, 0.10);
  return {At(along, 0, {0, -0.153, 0.05}), At(along, 0, {0, 0.153, 0.05}),
          At(across, 0, {-0.153, 0, 0.05}), At(across, 0, {0.153, 0, 0.05})};
}

TEST(OpenBoxes, WallsAreNoObjectsAndWhatLiesInTheBoxIs) {
  auto meshes = OpenBox();
  meshes.push_back(At(synthetic::BoxMesh(0.08, 0.06, 0.09), 0.3, {-0.05, -0.07, 0.045}));
  meshes.push_back(At(synthetic::CylinderMesh(0.035, 0.08), 0.0, {-0.03, 0.06, 0.04}));
  const auto scan = ScanOnTable(meshes, 0.22);
  for (const bool on : {true, false}) {
    PerceptionOptions options;
    options.features.containers = on;
    const Scene scene = SceneOf(scan, options);
    EXPECT_EQ(scene.container.empty(), !on);
    std::size_t of_walls = 0;
    for (const auto& object : scene.objects) {
      const auto walls = std::ranges::count_if(object.points, [&](auto i) {
        const int mesh = scan.label[scene.source[i]];
        return mesh >= 0 && mesh < 4;
      });
      of_walls += 2 * static_cast<std::size_t>(walls) > object.points.size() ? 1 : 0;
    }
    if (on) {
      EXPECT_EQ(of_walls, 0u);
      EXPECT_EQ(scene.objects.size(), 2u);
    } else {
      EXPECT_GT(of_walls, 0u);
    }
  }
}

TEST(OpenBoxes, AreFoundWhicheverWayTheyStand) {
  for (const double yaw : {0.2, 0.6, 0.8}) {
    auto meshes = OpenBox();
    meshes.push_back(At(synthetic::CylinderMesh(0.035, 0.08), 0.0, {-0.03, 0.06, 0.04}));
    for (auto& mesh : meshes) mesh = At(mesh, yaw, Vector3d::Zero());
    const auto scan = ScanOnTable(meshes, 0.26);
    const Scene scene = SceneOf(scan);
    const auto walls = std::ranges::count_if(scan.label, [](int l) { return l >= 0 && l < 4; });
    // Excludes points within the table's clearance and mixed points off the walls.
    EXPECT_GT(static_cast<double>(scene.container.size()), 0.85 * static_cast<double>(walls))
        << yaw;
    EXPECT_EQ(scene.objects.size(), 1u) << yaw;
  }
}

TEST(OpenBoxes, AreFoundWhereAThingLiesOnOneOfTheRims) {
  auto meshes = OpenBox();
  meshes.push_back(At(synthetic::BoxMesh(0.03, 0.30, 0.03), 0.0, {-0.153, 0.0, 0.115}));
  EXPECT_FALSE(SceneOf(ScanOnTable(meshes, 0.22)).container.empty());
}

TEST(OpenBoxes, AClosedOneIsAnObject) {
  // From two sides, everything of its walls is seen except their inner sides.
  const std::vector<TriangleMesh> carton{At(synthetic::BoxMesh(0.2, 0.22, 0.1), 0.0, {0, 0, 0.05})};
  geometry::Observation observation;
  for (const double x : {0.8, -0.8}) {
    synthetic::RasterOptions raster;
    raster.sensor_W.x() = x;
    const auto scan = synthetic::MakeRasterScan(carton, raster);
    observation.views.emplace_back().image = {.profiles = 1,
                                              .samples = static_cast<int>(scan.points_W.size()),
                                              .points_C = scan.points_W,
                                              .origins_C = {raster.sensor_W}};
  }
  base::Rng rng(1);
  const Scene scene = Perceive(observation, {}, rng, std::nullopt);
  EXPECT_TRUE(scene.container.empty());
  EXPECT_EQ(scene.objects.size(), 1u);
}

TEST(OpenBoxes, ThingsThatStandAboutAreNone) {
  const auto box = synthetic::BoxMesh(0.06, 0.09, 0.15);
  const Scene scene = SceneOf(synthetic::MakeRasterScan({At(box, 0.0, {-0.08, -0.08, 0.075}),
                                                         At(box, 0.0, {-0.08, 0.08, 0.075}),
                                                         At(box, 0.0, {0.08, 0.0, 0.075})}));
  EXPECT_TRUE(scene.container.empty());
  EXPECT_EQ(scene.objects.size(), 3u);
}

TEST(OpenBoxes, ThingsInARectangleThatAreNotEquallyHighAreNone) {
  const auto along = [](double height) { return synthetic::BoxMesh(0.312, 0.02, height); };
  const auto across = [](double height) { return synthetic::BoxMesh(0.02, 0.26, height); };
  const Scene scene = SceneOf(synthetic::MakeRasterScan(
      {At(along(0.08), 0, {0, -0.146, 0.04}), At(along(0.11), 0, {0, 0.146, 0.055}),
       At(across(0.14), 0, {-0.146, 0, 0.07}), At(across(0.05), 0, {0.146, 0, 0.025})}));
  EXPECT_TRUE(scene.container.empty());
  EXPECT_EQ(scene.objects.size(), 4u);
}

}  // namespace
}  // namespace rangegrasp::perception
