#include "parts/cloud/seen_side.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "parts/cloud/cloud_mesh.h"
#include "parts/cloud/cloud_samples.h"
#include "parts/hierarchy/hierarchy.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;

constexpr double kInner = 0.8, kOuter = 0.9, kFloor = 0.15, kTall = 2.0;

/// Distances to a cup about z, and to half a ring of a handle at its side.
double ToCup(const Vector3d& p) {
  const double r = p.head<2>().norm();
  const double solid = std::max({r - kOuter, -p.z(), p.z() - kTall});
  return std::max(solid, -std::max(r - kInner, kFloor - p.z()));
}
double ToHandle(const Vector3d& p) {
  const Vector3d q = p - Vector3d(kOuter - 0.05, 0.0, 1.0);
  return std::max(std::hypot(std::hypot(q.x(), q.z()) - 0.55, q.y()) - 0.1, -q.x());
}

/// The first point at which a ray comes to the mug: steps as long as the distance are safe.
std::optional<Vector3d> FirstHit(Vector3d p, const Vector3d& ray) {
  for (double way = 0.0; way < 12.0;) {
    const double step = std::min(ToCup(p), ToHandle(p));
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
/// What parallel rays see of the mug from a direction, 0.06 apart, with a noise of 0.006 along
/// them: 3 mm and 0.3 mm of a mug 95 mm tall.
View LookFrom(double azimuth, double elevation, std::uint64_t seed) {
  base::Rng rng(seed);
  const Vector3d ray = -Vector3d(std::cos(azimuth) * std::cos(elevation),
                                 std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
  const Vector3d right = ray.unitOrthogonal(), up = right.cross(ray);
  View view;
  for (double x = -2.5; x < 2.5; x += 0.06) {
    for (double y = -2.5; y < 2.5; y += 0.06) {
      const auto hit =
          FirstHit(Vector3d(0.0, 0.0, 0.5 * kTall) - 6.0 * ray + x * right + y * up, ray);
      if (!hit) continue;
      view.is_handle.push_back(ToHandle(*hit) < ToCup(*hit));
      view.cloud.points.push_back(*hit + 0.006 * rng.Normal() * ray);
    }
  }
  return view;
}

/// Whether some part is the handle, or is the cup, to nine tenths: so much of it is, and so much of
/// what is belongs to it.
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
  // From above by 20 to 55 degrees, the handle to the left, to the right and towards the viewer.
  int views = 0, right = 0;
  for (const double elevation : {0.35, 0.55, 0.75, 0.95}) {
    for (const double azimuth : {-1.7, -0.9, -0.1, 0.8, 1.6}) {
      const View view = LookFrom(azimuth, elevation, static_cast<std::uint64_t>(++views));
      const Segmentation found = SegmentHierarchy(view.cloud, {});
      const bool both = IsOnePiece(view, found, false) && IsOnePiece(view, found, true);
      if (both) ++right;
      EXPECT_LE(found.parts, 4) << azimuth << " " << elevation;
      EXPECT_EQ(AtLevel(found, 0).parts, 1);
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
  // A cell counts as covered if any of the surface is in it, so that a disc of radius 1 covers up
  // to one of 1 + a cell's diagonal; a cell is two edges of the mesh, at most 0.11 here.
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
