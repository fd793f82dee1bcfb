#include "recognition/library.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "geometry/mesh.h"
#include "perception/raster_scan.h"

namespace rangegrasp::recognition {
namespace {

using Eigen::Vector3d;
using Place = std::array<double, 3>;

Place PlaceOf(const Vector3d& p) { return {p.x(), p.y(), p.z()}; }

class EverySeededDistortion : public testing::TestWithParam<std::uint64_t> {
 protected:
  const geometry::ColoredMesh box_ = {synthetic::BoxMesh(0.09, 0.06, 0.135), {}};
};

INSTANTIATE_TEST_SUITE_P(Seeds, EverySeededDistortion, testing::Range<std::uint64_t>(0, 20));

TEST_P(EverySeededDistortion, LeavesTheSurfaceClosed) {
  base::Rng rng(GetParam());
  const auto mesh = Distorted(box_, 0.0015, rng).mesh;
  // Each edge is used once in each direction.
  std::map<std::pair<Place, Place>, int> passed;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Place a = PlaceOf(mesh.vertices[t[i]]);
      const Place b = PlaceOf(mesh.vertices[t[(i + 1) % 3]]);
      ++passed[{std::min(a, b), std::max(a, b)}];
    }
  }
  EXPECT_TRUE(std::ranges::all_of(passed, [](const auto& edge) { return edge.second == 2; }));
  EXPECT_NEAR(geometry::Volume(mesh) / geometry::Volume(box_.mesh), 1.0, 0.1);
}

TEST_P(EverySeededDistortion, ScalesWithItsRootMeanSquareAndMovesNothingAsAWhole) {
  base::Rng small(GetParam());
  base::Rng large(GetParam());
  const auto one = Distorted(box_, 0.001, small).mesh;
  const auto two = Distorted(box_, 0.002, large).mesh;
  double squares = 0.0;
  Vector3d moved = Vector3d::Zero();
  for (std::size_t i = 0; i < one.vertices.size(); ++i) {
    const Vector3d d = two.vertices[i] - one.vertices[i];  // equal to one's offset from the box
    squares += d.squaredNorm();
    moved += d;
  }
  const auto n = static_cast<double>(one.vertices.size());
  EXPECT_NEAR(std::sqrt(squares / n), 0.001, 1e-9);
  EXPECT_LT((moved / n).norm(), 1e-9);
}

TEST(Distorted, BendsAFlatFace) {
  base::Rng rng(1);
  const auto mesh = Distorted({synthetic::BoxMesh(0.09, 0.06, 0.135), {}}, 0.001, rng).mesh;
  double low = 1.0;
  double high = 0.0;
  for (const Vector3d& p : mesh.vertices) {
    if (p.z() < 0.06) continue;  // the top, at 67.5 mm, and the upper end of the sides
    if (std::abs(p.x()) > 0.035 || std::abs(p.y()) > 0.02) continue;
    low = std::min(low, p.z());
    high = std::max(high, p.z());
  }
  EXPECT_GT(high - low, 0.3e-3);
}

TEST(Distorted, KeepsTheColorsOfItsTriangles) {
  geometry::ColoredMesh box{synthetic::BoxMesh(0.09, 0.06, 0.135), {}};
  box.colors.plain.assign(box.mesh.triangles.size(), geometry::Rgb{10, 20, 30});
  base::Rng rng(1);
  const auto distorted = Distorted(box, 0.001, rng);
  EXPECT_GT(distorted.mesh.triangles.size(), box.mesh.triangles.size());
  EXPECT_EQ(distorted.colors.plain.size(), distorted.mesh.triangles.size());
}

}  // namespace
}  // namespace rangegrasp::recognition
