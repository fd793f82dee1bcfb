#include "parts/shape/face_frames.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "parts/solids.h"

namespace rangegrasp::parts {
namespace {

// Area after Heron, from the three sides alone; the normal stands on all of them and looks to where
// the corners run round counterclockwise.
TEST(FaceFrames, OfRandomTrianglesAreThoseOfTheirSides) {
  base::Rng rng(1);
  Shape soup;
  for (std::uint32_t f = 0; f < 1000; ++f) {
    for (int i = 0; i < 3; ++i) soup.points.emplace_back(rng.Normal(), rng.Normal(), rng.Normal());
    soup.faces.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  const FaceFrames frames = BuildFaceFrames(soup);
  double total = 0.0;
  for (std::size_t f = 0; f < 1000; ++f) {
    const Eigen::Vector3d &p = soup.points[3 * f], &q = soup.points[3 * f + 1],
                          &r = soup.points[3 * f + 2];
    const double a = (q - p).norm(), b = (r - q).norm(), c = (p - r).norm(), s = 0.5 * (a + b + c);
    // Heron loses half of the digits of slivers.
    const double area = std::sqrt(std::max(0.0, s * (s - a) * (s - b) * (s - c)));
    EXPECT_NEAR(frames.area[f], area, 1e-7);
    EXPECT_NEAR(frames.normal[f].norm(), 1.0, 1e-12);
    for (const Eigen::Vector3d side : {q - p, r - q, p - r}) {
      EXPECT_NEAR(frames.normal[f].dot(side), 0.0, 1e-9);
    }
    EXPECT_GT(frames.normal[f].dot((q - p).cross(r - p)), 0.0);
    EXPECT_LT((3.0 * frames.center[f] - p - q - r).norm(), 1e-12);
    total += area;
  }
  EXPECT_NEAR(frames.total_area, total, 1e-6);
}

// A ball's surface, from below: the faces' corners lie on it.
TEST(FaceFrames, AreasOfABallAddUpToItsSurface) {
  const FaceFrames frames =
      BuildFaceFrames(samples::Ball(24, [](const Eigen::Vector3d&) { return 2.0; }));
  EXPECT_LT(frames.total_area, 16.0 * M_PI);
  // A spherical triangle is larger than the flat one by (a^2 + b^2 + c^2) / 24; on the unit ball no
  // side is longer than a cell's diagonal, sqrt(2) * 2 / 24.
  const double side = std::sqrt(2.0) * 2.0 / 24.0;
  EXPECT_GT(frames.total_area, 16.0 * M_PI * (1.0 - 3.0 * side * side / 24.0));
  for (std::size_t f = 0; f < frames.area.size(); ++f) {
    EXPECT_GT(frames.normal[f].dot(frames.center[f]), 0.0);
  }
}

}  // namespace
}  // namespace rangegrasp::parts
