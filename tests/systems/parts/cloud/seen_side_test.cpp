#include "parts/cloud/internal/seen_side.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "parts/cloud/cloud_mesh.h"
#include "parts/cloud/cloud_samples.h"
#include "parts/hierarchy/hierarchy.h"
#include "parts/solids.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;

/// Equal faces of a cone about z with slope 1 in 4, visible over half a turn. One in six faces lies
/// on a fin in a plane next to the axis. All are moved by `move`.
FaceFrames HalfConeWithFin(const Eigen::Isometry3d& move, double noise) {
  base::Rng rng(5);
  FaceFrames frames;
  for (int k = 0; k < 1200; ++k) {
    Vector3d p, n;
    if (k % 6 == 0) {
      p = {0.3, rng.Uniform(1.0, 2.0), rng.Uniform(-1.0, 1.0)};
      n = Vector3d::UnitX();
    } else {
      const double angle = rng.Uniform(0.0, std::numbers::pi);
      const double z = rng.Uniform(-2.0, 2.0);
      const Vector3d out(std::cos(angle), std::sin(angle), 0.0);
      p = (1.0 - 0.25 * z) * out + z * Vector3d::UnitZ();
      n = (out + 0.25 * Vector3d::UnitZ()).normalized();
    }
    frames.center.push_back(move * p);
    frames.normal.push_back((move.linear() * samples::Noisy(n, noise, rng)).normalized());
    frames.area.push_back(1.0);
    frames.total_area += 1.0;
  }
  return frames;
}

TEST(Revolution, TheAxisOfAHalfSeenConeIsFoundBesideAFin) {
  const Eigen::Isometry3d move = Eigen::Translation3d(3.0, -2.0, 5.0) *
                                 Eigen::AngleAxisd(0.7, Vector3d(1.0, 2.0, 3.0).normalized());
  for (const double noise : {0.0, 0.1}) {
    const auto axis = FindRevolution(HalfConeWithFin(move, noise));
    ASSERT_TRUE(axis);
    // 1000 normals with 0.1 rad noise give the axis to about 0.1 / sqrt(1000); ten times that.
    EXPECT_GT(std::abs(axis->direction.dot(move.linear().col(2))), std::cos(0.03));
    EXPECT_LT(axis->direction.cross(move.translation() - axis->point).norm(), 0.03);
    // The cone's share; the lines along the fin's normals do not meet the axis.
    EXPECT_NEAR(axis->share, 5.0 / 6.0, 0.02);
  }
}

TEST(Revolution, TwistIsTheSineOfANormalsWayPastTheAxis) {
  const RevolutionAxis axis{{1.0, 0.0, 0.0}, Vector3d::UnitZ(), 1.0};
  const Vector3d p(3.0, 0.0, 7.0);
  EXPECT_NEAR(axis.Twist(p, Vector3d::UnitX()), 0.0, 1e-12);
  EXPECT_NEAR(axis.Twist(p, Vector3d::UnitZ()), 0.0, 1e-12);
  EXPECT_NEAR(axis.Twist(p, Vector3d(std::cos(0.3), std::sin(0.3), 0.0)), std::sin(0.3), 1e-12);
  EXPECT_NEAR(axis.ProfileOf(p).x(), 2.0, 1e-12);
  EXPECT_NEAR(axis.ProfileOf(p).y(), 7.0, 1e-12);
}

/// Two squares, one above the other, of 20 x 20 cells of side 1, each cell of two triangles. The
/// halves of the lower square are two parts; the upper square is the third.
Shape TwoSheets(double apart, Segmentation& labels) {
  constexpr std::uint32_t kCells = 20;
  Shape mesh;
  for (const double z : {0.0, apart}) {
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (std::uint32_t i = 0; i <= kCells; ++i) {
      for (std::uint32_t j = 0; j <= kCells; ++j) mesh.points.emplace_back(i, j, z);
    }
    for (std::uint32_t i = 0; i < kCells; ++i) {
      for (std::uint32_t j = 0; j < kCells; ++j) {
        const std::uint32_t a = first + i * (kCells + 1) + j;
        const std::uint32_t b = a + kCells + 1;
        mesh.faces.push_back({a, b, a + 1});
        mesh.faces.push_back({b, b + 1, a + 1});
        for (int k = 0; k < 2; ++k) labels.label.push_back(z > 0.0 ? 2 : (i < kCells / 2 ? 0 : 1));
      }
    }
  }
  labels.parts = 3;
  return mesh;
}

TEST(Walls, BothSidesOfAThinWallAreOnePart) {
  Segmentation labels;
  const Shape mesh = TwoSheets(2.0, labels);
  EXPECT_EQ(JoinWalls(mesh, labels).parts, 1);
}

TEST(Walls, SheetsApartAndPartsBesideEachOtherStayApart) {
  Segmentation labels;
  const Shape mesh = TwoSheets(8.0, labels);
  EXPECT_EQ(JoinWalls(mesh, labels).label, labels.label);
}

constexpr double kGirthRadius = 0.1;  // radius of the handle's tube

/// The first hit of a ray on the mug (sphere tracing: steps as long as the distance are safe).
std::optional<Vector3d> FirstHit(Vector3d p, const Vector3d& ray) {
  for (double way = 0.0; way < 12.0;) {
    const double step = std::min(samples::ToCup(p), samples::ToHandle(p, kGirthRadius));
    if (step < 1e-4) return p;
    p += step * ray;
    way += step;
  }
  return std::nullopt;
}

struct View {
  Shape cloud;
  std::vector<bool> is_handle;
};
/// Points of the mug seen from a direction, by parallel rays 0.06 apart with noise of 0.006 along
/// them. This is 3 mm and 0.3 mm on a mug 95 mm tall.
View LookFrom(double azimuth, double elevation, std::uint64_t seed) {
  base::Rng rng(seed);
  const Vector3d ray = -Vector3d(std::cos(azimuth) * std::cos(elevation),
                                 std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
  const Vector3d right = ray.unitOrthogonal(), up = right.cross(ray);
  View view;
  for (double x = -2.5; x < 2.5; x += 0.06) {
    for (double y = -2.5; y < 2.5; y += 0.06) {
      const auto hit = FirstHit(
          Vector3d(0.0, 0.0, 0.5 * samples::kMugTall) - 6.0 * ray + x * right + y * up, ray);
      if (!hit) continue;
      view.is_handle.push_back(samples::ToHandle(*hit, kGirthRadius) < samples::ToCup(*hit));
      view.cloud.points.push_back(*hit + 0.006 * rng.Normal() * ray);
    }
  }
  return view;
}

/// True if a part matches the handle (or the cup) to 90 %: of the part's points and of the handle's
/// (or cup's) points.
bool IsOnePiece(const View& view, const Segmentation& found, bool handle) {
  const auto of_all = std::count(view.is_handle.begin(), view.is_handle.end(), handle);
  for (int part = 0; part < found.parts; ++part) {
    std::ptrdiff_t size = 0, right = 0;
    for (std::size_t i = 0; i < found.label.size(); ++i) {
      if (found.label[i] != part) continue;
      ++size;
      if (view.is_handle[i] == handle) ++right;
    }
    if (10 * right >= 9 * size && 10 * right >= 9 * of_all) return true;
  }
  return false;
}

TEST(SeenSide, AMugOfWhichTheHandleIsInSightIsAContainerAndAHandle) {
  // From 20 to 55 degrees above, with the handle to the left, to the right and towards the viewer.
  int views = 0, right = 0;
  for (const double elevation : {0.35, 0.55, 0.75, 0.95}) {
    for (const double azimuth : {-1.7, -0.9, -0.1, 0.8, 1.6}) {
      const View view = LookFrom(azimuth, elevation, static_cast<std::uint64_t>(++views));
      const Segmentation found = SegmentHierarchy(view.cloud, {});
      const bool both = IsOnePiece(view, found, false) && IsOnePiece(view, found, true);
      if (both) ++right;
      EXPECT_LE(found.parts, 4) << azimuth << " " << elevation;
    }
  }
  EXPECT_GE(right, 18) << "of " << views;
}

TEST(SeenSide, AClosedSurfaceHasTwoLayersAndWhatOneViewShowsOne) {
  base::Rng rng(3);
  geometry::Points ball, half;
  while (half.size() < 3'000) {
    ball.push_back(samples::BallPoint(rng));
    if (ball.back().z() > 0.0) half.push_back(ball.back());
  }
  // A cell is covered if it contains any of the surface, so a disc of radius 1 covers up to a disc
  // of 1 + a cell's diagonal. A cell is two edges of the mesh, at most 0.11 here.
  const double covered = std::pow(1.0 + std::sqrt(2.0) * 0.11, 2);
  const Shape open = MeshOfCloud(half).mesh;
  EXPECT_LE(FewestLayers(open), 1.0);
  EXPECT_GE(FewestLayers(open), 1.0 / covered);
  EXPECT_TRUE(FindSeenBody(open));
  const Shape closed = MeshOfCloud(ball).mesh;
  EXPECT_LE(FewestLayers(closed), 2.0);
  EXPECT_GE(FewestLayers(closed), 2.0 / covered);
  EXPECT_FALSE(FindSeenBody(closed));
}

}  // namespace
}  // namespace rangegrasp::parts
