// Observations with one and several views, on synthetic scans with ground truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "perception/perceive.h"
#include "perception/raster_scan.h"

namespace rangegrasp::perception {
namespace {

using Eigen::Vector3d;
using geometry::Observation;
using geometry::RangeImage;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// The scan as an image with one profile and an unmeasured sample after each point.
RangeImage ImageOf(const geometry::Points& points_W, const Vector3d& sensor_W) {
  RangeImage image{.profiles = 1, .samples = 0, .points_C = {}, .origins_C = {sensor_W}};
  for (const Vector3d& p : points_W) {
    image.points_C.push_back(p);
    image.points_C.emplace_back(kNan, kNan, kNan);
  }
  image.samples = static_cast<int>(image.points_C.size());
  return image;
}

Observation ObservationOf(const std::vector<RangeImage>& images) {
  Observation observation;
  for (const RangeImage& image : images) observation.views.emplace_back().image = image;
  return observation;
}

/// A box, a lying cylinder (whose far side is completed) and a mug.
std::vector<geometry::TriangleMesh> Objects() {
  return {geometry::Transformed(synthetic::BoxMesh(0.09, 0.06, 0.135),
                                synthetic::Standing(0.5, {-0.05, -0.04, 0.0675})),
          geometry::Transformed(synthetic::CylinderMesh(0.03, 0.12),
                                synthetic::Lying(1.2, {0.07, -0.08, 0.03})),
          geometry::Transformed(synthetic::MugMesh(), synthetic::Standing(3.2, {0.0, 0.09, 0.0}))};
}

synthetic::RasterScan ScanFrom(const Vector3d& sensor_W, std::uint64_t seed) {
  synthetic::RasterOptions options;
  options.sensor_W = sensor_W;
  options.seed = seed;
  return synthetic::MakeRasterScan(Objects(), options);
}

const Vector3d kFront(0.8, 0.0, 0.62);
const Vector3d kBack(-0.8, 0.0, 0.62);

Scene See(const Observation& observation, std::uint64_t seed,
          const std::optional<Workspace>& workspace = std::nullopt) {
  base::Rng rng(seed);
  return Perceive(observation, {}, rng, workspace);
}

void ExpectSameScene(const Scene& a, const Scene& b) {
  EXPECT_EQ(a.points_C, b.points_C);
  EXPECT_EQ(a.table.plane.normal, b.table.plane.normal);
  EXPECT_EQ(a.table.plane.offset_m, b.table.plane.offset_m);
  EXPECT_EQ(a.cloud.normals, b.cloud.normals);
  EXPECT_EQ(a.segments, b.segments);
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (std::size_t i = 0; i < a.objects.size(); ++i) {
    EXPECT_EQ(a.objects[i].points, b.objects[i].points);
    EXPECT_EQ(a.objects[i].center_C, b.objects[i].center_C);
    EXPECT_EQ(a.objects[i].completed_C, b.objects[i].completed_C);
    EXPECT_EQ(a.objects[i].surface_C.vertices, b.objects[i].surface_C.vertices);
  }
}

TEST(Observation, StatedNoiseIsTheMedianOfWhatSamplesAreStatedToHave) {
  const auto scan = ScanFrom(kFront, 1);
  Observation observation = ObservationOf({ImageOf(scan.points_W, kFront)});
  geometry::View& view = observation.views.front();
  view.noise_m.assign(view.image.points_C.size(), 0.0F);
  for (std::size_t i = 0; i < view.noise_m.size(); i += 8) view.noise_m[i] = 0.0023F;
  PerceptionOptions options;
  options.stated_noise = true;
  base::Rng rng(1);
  EXPECT_FLOAT_EQ(static_cast<float>(Perceive(observation, options, rng).sampling.noise_m),
                  0.0023F);
  // If the view states no noise, it is measured.
  view.noise_m.clear();
  base::Rng again(1);
  EXPECT_LT(Perceive(observation, options, again).sampling.noise_m, 0.0015);
}

TEST(Observation, OneViewIsThePlainCloud) {
  const auto scan = ScanFrom(kFront, 1);
  base::Rng rng(1);
  const Scene plain = Perceive(scan.points_W, kFront, {}, rng);
  const Scene scene = See(ObservationOf({ImageOf(scan.points_W, kFront)}), 1);
  ExpectSameScene(scene, plain);
  ASSERT_EQ(scene.objects.size(), 3u);
}

TEST(Observation, TwoHalvesOfAScanFromOnePlaceAreTheWholeScan) {
  for (const std::uint64_t seed : {1, 2}) {
    const auto scan = ScanFrom(kFront, seed);
    const auto middle = scan.points_W.begin() + static_cast<std::ptrdiff_t>(scan.label.size() / 2);
    const auto halves = ObservationOf({ImageOf({scan.points_W.begin(), middle}, kFront),
                                       ImageOf({middle, scan.points_W.end()}, kFront)});
    ExpectSameScene(See(halves, seed), See(ObservationOf({ImageOf(scan.points_W, kFront)}), seed));
  }
}

TEST(Workspace, LeavesOutWhatLiesFurtherAwayAndWhatLiesInAFixture) {
  geometry::Shape wall;
  wall.kind = geometry::Shape::Kind::kBox;
  wall.size = {0.01, 0.3, 0.1};
  wall.X_BS.translation() = Eigen::Vector3d(0.1, 0.0, 0.1);
  const Workspace workspace(base::Pose::Identity(), 0.2, {wall});
  EXPECT_TRUE(workspace.Contains({0.0, 0.0, 0.05}));
  EXPECT_TRUE(workspace.Contains({0.15, 0.0, 0.05})) << "behind the wall";
  EXPECT_TRUE(workspace.Contains({0.1, 0.0, 0.25})) << "over the wall";
  EXPECT_FALSE(workspace.Contains({0.105, 0.1, 0.05}));
  EXPECT_FALSE(workspace.Contains({0.0, 0.21, 0.05}));
}

TEST(Observation, EveryPointIsTracedToItsViewAndSample) {
  const auto front = ScanFrom(kFront, 3);
  const auto back = ScanFrom(kBack, 4);
  const auto observation =
      ObservationOf({ImageOf(front.points_W, kFront), ImageOf(back.points_W, kBack)});
  const Workspace workspace{base::MakePose(Eigen::Matrix3d::Identity(), {0.02, 0.01, 0.0}), 0.15};
  const Scene scene = See(observation, 3, workspace);
  ASSERT_EQ(scene.samples.size(), scene.points_C.size());
  for (std::size_t i = 0; i < scene.samples.size(); ++i) {
    const SampleId& id = scene.samples[i];
    EXPECT_EQ(observation.views[id.view].image.points_C[id.sample], scene.points_C[i]);
    EXPECT_LE((scene.points_C[i] - Vector3d(0.02, 0.01, 0.0)).head<2>().norm(), 0.15);
    if (i == 0) continue;  // views in order, each in scan order
    const SampleId& before = scene.samples[i - 1];
    EXPECT_TRUE(before.view < id.view || (before.view == id.view && before.sample < id.sample));
  }
  const auto inside = [](const geometry::Points& points) {
    return std::count_if(points.begin(), points.end(), [](const Vector3d& p) {
      return (p - Vector3d(0.02, 0.01, 0.0)).head<2>().norm() <= 0.15;
    });
  };
  EXPECT_EQ(static_cast<std::ptrdiff_t>(scene.samples.size()),
            inside(front.points_W) + inside(back.points_W));
  for (std::uint32_t i = 0; i < scene.cloud.size(); ++i) {
    EXPECT_EQ(scene.SampleOf(i), scene.samples[scene.source[i]]);
    // Smoothing over 3 mm moves a point by less than that.
    const SampleId& id = scene.SampleOf(i);
    EXPECT_LT((observation.views[id.view].image.points_C[id.sample] - scene.cloud.points[i]).norm(),
              0.003);
  }
}

TEST(Observation, NormalsTurnToTheSensorThatSawThePoint) {
  const auto front = ScanFrom(kFront, 5);
  const auto back = ScanFrom(kBack, 6);
  const Scene scene =
      See(ObservationOf({ImageOf(front.points_W, kFront), ImageOf(back.points_W, kBack)}), 5);
  std::size_t away_from_the_other = 0;
  for (std::uint32_t i = 0; i < scene.cloud.size(); ++i) {
    const bool from_back = scene.SampleOf(i).view == 1;
    const Vector3d& p = scene.cloud.points[i];
    const Vector3d& normal = scene.cloud.normals[i];
    EXPECT_GE(normal.dot((from_back ? kBack : kFront) - p), 0.0);
    away_from_the_other += normal.dot((from_back ? kFront : kBack) - p) < 0.0 ? 1 : 0;
  }
  // Walls that only one sensor sees face away from the other.
  EXPECT_GT(away_from_the_other, scene.cloud.size() / 4);
}

TEST(Observation, AnObjectSeenFromTwoSidesHasPointsOfBothAndItsMeasuredSize) {
  const auto front = ScanFrom(kFront, 7);
  const auto back = ScanFrom(kBack, 8);
  const Scene scene =
      See(ObservationOf({ImageOf(front.points_W, kFront), ImageOf(back.points_W, kBack)}), 7);
  ASSERT_EQ(scene.objects.size(), 3u);
  const std::array<const synthetic::RasterScan*, 2> views{&front, &back};
  for (const PerceivedObject& object : scene.objects) {
    // Finds the mesh of the object, and how many of that mesh's points in each view it has.
    std::array<std::size_t, 2> held{};
    std::map<int, std::size_t> votes;
    for (const auto i : object.points) {
      const SampleId& id = scene.SampleOf(i);
      ++held[id.view];
      ++votes[views[id.view]->label[id.sample / 2]];
    }
    const int mesh = std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) {
                       return a.second < b.second;
                     })->first;
    for (std::size_t v = 0; v < 2; ++v) {
      std::size_t measured = 0;
      for (std::size_t i = 0; i < views[v]->label.size(); ++i) {
        measured += views[v]->label[i] == mesh && views[v]->points_W[i].z() > 0.004 ? 1 : 0;
      }
      // Mixed points at its outline (a tenth of the edge pixels) may be removed.
      EXPECT_GT(static_cast<double>(held[v]), 0.95 * static_cast<double>(measured)) << mesh << v;
      EXPECT_GT(measured, 500u);
    }
  }
  // The box is 90 x 60 mm; both sides end within one raster step (1.8 mm), seen at up to 53 deg.
  EXPECT_NEAR(scene.objects[0].size_m.x(), 0.09, 0.003);
  EXPECT_NEAR(scene.objects[0].size_m.y(), 0.06, 0.003);
}

TEST(Observation, AProfileMayHaveAnOriginOfItsOwn) {
  const RangeImage moving{.profiles = 2,
                          .samples = 2,
                          .points_C = geometry::Points(4, Vector3d::Zero()),
                          .origins_C = {Vector3d::UnitX(), Vector3d::UnitY()}};
  EXPECT_EQ(moving.OriginOf(1), Vector3d::UnitX());
  EXPECT_EQ(moving.OriginOf(2), Vector3d::UnitY());
  RangeImage wrong = moving;
  wrong.origins_C.emplace_back(0.0, 0.0, 1.0);
  EXPECT_THROW(wrong.OriginOf(0), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::perception
