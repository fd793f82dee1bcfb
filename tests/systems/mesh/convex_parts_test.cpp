#include "mesh/convex_parts.h"

#include <gtest/gtest.h>

#include "geometry/shape.h"
#include "mesh/repair.h"

namespace rangegrasp::objects {
namespace {

using geometry::TriangleMesh;

#define SKIP_WITHOUT_COACD() \
  if (!CanCut()) GTEST_SKIP() << "CoACD is not there; scripts/setup fetches it"

// A box from low to high.
void AddBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high, TriangleMesh& mesh) {
  geometry::Shape box;
  box.kind = geometry::Shape::Kind::kBox;
  box.size = (high - low) / 2;
  box.X_BS.translation() = (high + low) / 2;
  geometry::Append(Tessellate(box), mesh);
}

// An L of two legs, 100 mm long, 20 mm thick: the outline of seven corners, extruded by 30 mm.
TriangleMesh Angle() {
  const std::vector<Eigen::Vector2d> outline = {{0, 0},       {0.1, 0},    {0.1, 0.02},
                                                {0.02, 0.02}, {0.02, 0.1}, {0, 0.1}};
  TriangleMesh mesh;
  for (const double z : {0.0, 0.03}) {
    for (const auto& p : outline) mesh.vertices.emplace_back(p.x(), p.y(), z);
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t j = (i + 1) % 6;
    mesh.triangles.push_back({i, j, j + 6});
    mesh.triangles.push_back({i, j + 6, i + 6});
  }
  const std::array<std::array<std::uint32_t, 3>, 4> lid = {
      {{0, 1, 3}, {1, 2, 3}, {0, 3, 5}, {3, 4, 5}}};
  for (const auto& [a, b, c] : lid) {
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({a + 6, b + 6, c + 6});
  }
  return mesh;
}

TEST(ConvexParts, AConvexSolidIsOnePart) {
  SKIP_WITHOUT_COACD();
  TriangleMesh box;
  AddBox({0, 0, 0}, {0.1, 0.05, 0.02}, box);
  const auto parts = ConvexParts(box);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_NEAR(geometry::Volume(parts[0]), 1e-4, 1e-9);
}

// An L has a hull of nearly twice its volume; two boxes hold all of it and nothing else.
TEST(ConvexParts, AnAngleIsCutWithoutFillingItsHollow) {
  SKIP_WITHOUT_COACD();
  const TriangleMesh angle = Angle();
  ASSERT_NEAR(geometry::Volume(angle), 0.0036 * 0.03, 1e-12);
  const auto parts = ConvexParts(angle);
  ASSERT_GE(parts.size(), 2U);
  const geometry::Overlap overlap = geometry::OverlapOf(angle, parts);
  EXPECT_GT(overlap.covered, 0.99);
  EXPECT_LT(overlap.beyond, 0.05);
}

TEST(ConvexParts, TheSameSolidIsCutTheSame) {
  SKIP_WITHOUT_COACD();
  const auto first = ConvexParts(Angle()), second = ConvexParts(Angle());
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].vertices, second[i].vertices);
    EXPECT_EQ(first[i].triangles, second[i].triangles);
  }
}

}  // namespace
}  // namespace rangegrasp::objects
