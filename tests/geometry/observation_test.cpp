#include "geometry/observation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/rng.h"
#include "base/units.h"
#include "geometry/box_scan.h"

namespace rangegrasp::geometry {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A flat grid with samples along_m apart along a profile and profiles across_m apart.
RangeImage Grid(int profiles, int samples, double along_m, double across_m) {
  RangeImage image{profiles, samples, {}, {Eigen::Vector3d::Zero()}};
  for (int p = 0; p < profiles; ++p) {
    for (int s = 0; s < samples; ++s) image.points_C.emplace_back(along_m * s, across_m * p, 1.0);
  }
  return image;
}

TEST(MedianSpacing, IsTheMeanOfBothDirectionsOfAGrid) {
  EXPECT_NEAR(MedianSpacing(Grid(30, 40, 0.001, 0.003)), 0.002, 1e-12);
  EXPECT_NEAR(MedianSpacing(Grid(1, 40, 0.001, 0.003)), 0.001, 1e-12);
  EXPECT_NEAR(MedianSpacing(Grid(30, 1, 0.001, 0.003)), 0.003, 1e-12);
}

// Gaps and depth steps at a few samples do not change it.
TEST(MedianSpacing, HoldsWithGapsAndSteps) {
  RangeImage image = Grid(60, 60, 0.001, 0.003);
  base::Rng rng(1);
  for (int k = 0; k < 600; ++k) {
    image.points_C[rng.Index(image.points_C.size())] = Eigen::Vector3d::Constant(kNaN);
  }
  for (int p = 0; p < 60; ++p) {
    for (int s = 30; s < 60; ++s) image.points_C[image.Index(p, s)].z() = 2.0;
  }
  EXPECT_NEAR(MedianSpacing(image), 0.002, 1e-12);
}

TEST(RangeImage, AProfileHasItsOrigin) {
  RangeImage image = Grid(2, 5, 0.001, 0.003);
  EXPECT_EQ(image.OriginOf(9), Eigen::Vector3d::Zero());
  image.origins_C = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(image.OriginOf(i), i < 5 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY()) << i;
  }
  image.origins_C.resize(3);
  EXPECT_THROW(image.OriginOf(0), std::invalid_argument);
}

TEST(ToCloud, TakesWhatWasMeasuredInItsOrder) {
  RangeImage image = Grid(2, 3, 0.001, 0.003);
  image.points_C[1].setConstant(kNaN);
  image.points_C[4].x() = kNaN;
  const Indices source{0, 2, 3, 5};
  const PointCloud cloud = ToCloud(image);
  ASSERT_EQ(cloud.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(cloud.points[k], image.points_C[source[k]]);
}

TEST(MedianSpacing, IsZeroWithoutNeighbors) {
  EXPECT_EQ(MedianSpacing({}), 0.0);
  EXPECT_EQ(MedianSpacing(Grid(1, 1, 0.001, 0.001)), 0.0);
  RangeImage image = Grid(3, 3, 0.001, 0.001);
  for (std::size_t i = 1; i < 9; i += 2) image.points_C[i].setConstant(kNaN);
  EXPECT_EQ(MedianSpacing(image), 0.0);  // the remaining samples touch only at corners
}

}  // namespace
}  // namespace rangegrasp::geometry

namespace rangegrasp::views {
namespace {

using geometry::Field;
using geometry::SeenSpace;
using geometry::samples::LookFrom;
using geometry::samples::ScanBox;

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

const AlignedBox3d kBox(Vector3d(-0.05, -0.04, 0.0), Vector3d(0.05, 0.04, 0.12));
const AlignedBox3d kRegion(Vector3d(-0.15, -0.15, 0.005), Vector3d(0.15, 0.15, 0.165));
const Vector3d kMiddle(0.0, 0.0, 0.06);
const Vector3d kFront(0.40, 0.0, 0.30);
constexpr double kDepth_m = 0.03;

SeenSpace SpaceSeenFrom(const std::vector<Vector3d>& places, double cell_m = 0.01) {
  SeenSpace space(kRegion, cell_m);
  base::Rng rng(1);
  for (const Vector3d& place : places) {
    space.Add(ScanBox(LookFrom(place, kMiddle), kBox, 0.0, rng));
  }
  return space;
}

// Checks every cell with geometry only. A cell is hidden if the segment from the sensor to it
// crosses the box well inside the silhouette and ends well behind the face where it enters. Cells
// are 10 mm wide; those cut by a silhouette or a face may be either.
TEST(SeenSpace, CallsFreeNothingThatTheSensorDoesNotSee) {
  const SeenSpace space = SpaceSeenFrom({kFront});
  const AlignedBox3d inner(kBox.min() + Vector3d(0.0, 0.015, 0.0),
                           kBox.max() - Vector3d(0.0, 0.015, 0.015));
  int hidden = 0;
  int free = 0;
  for (int z = 0; z < space.Size().z(); ++z) {
    for (int y = 0; y < space.Size().y(); ++y) {
      for (int x = 0; x < space.Size().x(); ++x) {
        const Vector3d p = space.MiddleOf({x, y, z});
        const Vector3d way = p - kFront;
        const Eigen::Array3d a = (inner.min() - kFront).array() / way.array();
        const Eigen::Array3d b = (inner.max() - kFront).array() / way.array();
        const double enter = a.min(b).maxCoeff();
        const bool crosses = enter < std::min(1.0, a.max(b).minCoeff());
        const auto cell = space.At({x, y, z});
        if (crosses && (1.0 - enter) * way.norm() > 0.02) {
          EXPECT_NE(cell, SeenSpace::Cell::kFree) << p.transpose();
          ++hidden;
        }
        free += cell == SeenSpace::Cell::kFree ? 1 : 0;
      }
    }
  }
  EXPECT_GT(hidden, 300);
  EXPECT_GT(free, 5000);
}

TEST(SeenSpace, TheFarSideIsWorthMoreThanTheSideThatWasSeen) {
  const SeenSpace space = SpaceSeenFrom({kFront});
  const auto gain = [&](const Vector3d& from) {
    return space.GainFrom(LookFrom(from, kMiddle), {}, kRegion, kDepth_m);
  };
  const double behind = gain({-0.40, 0.0, 0.30});
  EXPECT_GT(behind, 3.0 * gain(kFront));
  // The box's shadow on the table is behind its face from y = -0.04 to 0.04, 0.12 high, and is at
  // most that long. The view sees some of it and no more.
  EXPECT_GT(behind, 0.1e-3);
  EXPECT_LT(behind, space.UnseenVolume());
}

TEST(SeenSpace, ALookTakesItsGainAway) {
  const Vector3d back(-0.40, 0.0, 0.30);
  const auto gain = [&](const SeenSpace& space) {
    return space.GainFrom(LookFrom(back, kMiddle), {}, kRegion, kDepth_m);
  };
  EXPECT_LT(gain(SpaceSeenFrom({kFront, back})), 0.25 * gain(SpaceSeenFrom({kFront})));
}

TEST(SeenSpace, KnownSurfacesHideWhatIsBehindThem) {
  // From the front, all unseen space lies behind faces that were seen.
  const SeenSpace space = SpaceSeenFrom({kFront}, 0.005);
  const double gain = space.GainFrom(LookFrom(kFront, kMiddle), {}, kRegion, kDepth_m);
  EXPECT_LT(gain, 0.2 * space.UnseenVolume());
}

TEST(SeenSpace, ARaysChanceFallsWithItsDistanceInAnyDirection) {
  // In unseen space a ray reaches about depth / cell cells along an axis, and sqrt(3) times as many
  // along the diagonal, which crosses more of them on the same way.
  const SeenSpace unseen(kRegion, 0.01);
  const Vector3d middle = kRegion.center() + Vector3d(0.0013, 0.0027, 0.0031);
  const Field ray{.half_right_rad = 1e-4, .half_down_rad = 1e-4};
  const auto gain = [&](const Vector3d& direction) {
    const Vector3d from = middle - 0.4 * direction.normalized();
    return unseen.GainFrom(LookFrom(from, middle), ray, kRegion, kDepth_m);
  };
  const double along = gain({-1.0, 1e-9, 0.0});
  EXPECT_NEAR(along, kDepth_m / 0.01 * 1e-6, 0.25 * along);
  EXPECT_NEAR(gain({-1.0, 1.0, -1.0}), std::sqrt(3.0) * along, 0.2 * along);
}

TEST(SeenSpace, AFieldMayBeHalfOfAllDirections) {
  const SeenSpace unseen(kRegion, 0.02);
  const Field half{.half_right_rad = base::kPi / 2.0, .half_down_rad = 0.3};
  const base::Pose X_CS = LookFrom(kFront, kMiddle);
  EXPECT_GE(unseen.GainFrom(X_CS, half, kRegion, kDepth_m),
            unseen.GainFrom(X_CS, {}, kRegion, kDepth_m));
}

TEST(SeenSpace, ItsCeilingIsAboveTheBoxAndItsShadow) {
  const SeenSpace space = SpaceSeenFrom({kFront});
  const geometry::TriangleMesh ceiling = space.Ceiling(0.01);
  double highest = 0.0;
  double foremost = -1.0;
  for (const Vector3d& v : ceiling.vertices) {
    if (std::abs(v.y()) > 0.035) continue;  // further out, the region's corners are out of view
    highest = std::max(highest, v.z());
    if (v.z() > 0.05) foremost = std::max(foremost, v.x());
  }
  EXPECT_GE(highest, 0.12);
  EXPECT_LE(highest, 0.12 + 0.01 + 2.0 * 0.01);  // the margin and the cells that contain the top
  EXPECT_GE(foremost, 0.05);
  EXPECT_LE(foremost, 0.05 + 2.0 * 0.01);  // nothing can be in front of the box
  double level_m2 = 0.0;
  for (const auto& [a, b, c] : ceiling.triangles) {
    const Vector3d& p = ceiling.vertices[a];
    const Vector3d n = (ceiling.vertices[b] - p).cross(ceiling.vertices[c] - p);
    EXPECT_GT(n.norm(), 0.0);
    level_m2 += 0.5 * n.z();  // 0 for upright ones
    if (n.z() <= 0.0) continue;
    for (const auto corner : {a, b, c}) {
      EXPECT_LE(kRegion.exteriorDistance(
                    Vector3d(ceiling.vertices[corner].x(), ceiling.vertices[corner].y(), 0.1)),
                1e-9);
    }
  }
  // Level faces cover whole cells of 0.01 m.
  EXPECT_GT(level_m2, 0.0);
  EXPECT_NEAR(level_m2 / 1e-4, std::round(level_m2 / 1e-4), 1e-6);
}

TEST(SeenSpace, RefusesABoxWithoutCells) {
  EXPECT_THROW(SeenSpace(AlignedBox3d(Vector3d::Zero(), Vector3d(0.1, 0.1, 0.005)), 0.01),
               std::invalid_argument);
  EXPECT_THROW(SeenSpace(AlignedBox3d(), 0.01), std::invalid_argument);
  EXPECT_THROW(SeenSpace(kRegion, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::views
