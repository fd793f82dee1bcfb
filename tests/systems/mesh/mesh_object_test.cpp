#include "mesh/mesh_object.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "base/units.h"
#include "error_of.h"
#include "geometry/sample_meshes.h"
#include "mesh/solid.h"
#include "temp_folder.h"

namespace rangegrasp::objects {
namespace {

TEST(LengthUnit, IsGuessedFromWhatAHandMayGrasp) {
  EXPECT_EQ(GuessUnit(95.0), LengthUnit::kMm);
  EXPECT_EQ(GuessUnit(9.5), LengthUnit::kCm);
  EXPECT_EQ(GuessUnit(0.095), LengthUnit::kM);
  // 25 could be 25 or 250 mm, 39 could be 39 or 390 mm: the size nearer to 100 mm by ratio wins.
  EXPECT_EQ(GuessUnit(25.0), LengthUnit::kCm);
  EXPECT_EQ(GuessUnit(39.0), LengthUnit::kMm);
}

TEST(LengthUnit, IsNotGuessedWhereNoneMakesALikelySize) {
  EXPECT_EQ(GuessUnit(1.7), std::nullopt);
  EXPECT_EQ(GuessUnit(60000.0), std::nullopt);
  EXPECT_EQ(GuessUnit(1e-6), std::nullopt);
}

TEST(LengthUnit, InchesAre25Point4Millimetres) {
  EXPECT_DOUBLE_EQ(MetersOf(LengthUnit::kInch), 0.0254);
  EXPECT_DOUBLE_EQ(MetersOf(LengthUnit::kMm) * 1000.0, MetersOf(LengthUnit::kM));
  EXPECT_DOUBLE_EQ(MetersOf(LengthUnit::kCm) * 100.0, 1.0);
}

using geometry::TriangleMesh;

#define SKIP_WITHOUT_COACD() \
  if (!CanCut()) GTEST_SKIP() << "CoACD is not there; scripts/setup fetches it"

// An L with two legs, 100 mm long, 20 mm thick: the outline, extruded by 30 mm.
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
  const TriangleMesh box = geometry::samples::BoxMesh({0.05, 0.025, 0.01}, {0.05, 0.025, 0.01});
  const auto parts = ConvexParts(box);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_NEAR(geometry::Volume(parts[0]), 1e-4, 1e-9);
}

// The hull of an L has nearly twice its volume; two boxes cover exactly the L.
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

using testing::AnyOf;
using testing::Contains;
using testing::HasSubstr;

class MeshObjectTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!CanCut()) GTEST_SKIP() << "CoACD is not there; scripts/setup fetches it";
  }
  // An OBJ of a box of 40 x 60 x 100 `unit`s.
  std::filesystem::path Box(const std::string& name, double unit, bool upside_in = false) {
    const TriangleMesh mesh = geometry::samples::BoxMesh(Eigen::Vector3d(20, 30, 50) * unit);
    std::string text;
    for (const auto& v : mesh.vertices) {
      text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", v.x() + 7.0 * unit, v.y(), v.z());
    }
    for (const auto& [a, b, c] : mesh.triangles) {
      text += upside_in ? fmt::format("f {} {} {}\n", a + 1, c + 1, b + 1)
                        : fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    return folder_.Write(name, text);
  }

  testing_support::TempFolder folder_;
};

// 0.24 l at 1000 kg/m3; moments of a box: m (b^2 + c^2) / 12.
TEST_F(MeshObjectTest, HasTheSizeMassAndInertiaOfItsSolidInAnyUnit) {
  MeshObjectOptions options;
  options.density_kg_m3 = 1000.0;
  const std::pair<const char*, double> units[] = {{"mm", 1.0}, {"cm", 0.1}, {"m", 0.001}};
  for (const auto& [unit, one] : units) {
    const MeshObject object = MakeMeshObject(Box("box.obj", one), options);
    EXPECT_TRUE(object.size_m.isApprox(Eigen::Vector3d(0.04, 0.06, 0.1), 1e-6)) << unit;
    EXPECT_NEAR(object.mass_kg, 0.24, 1e-6);
    EXPECT_LT(object.center_O.norm(), 1e-8);
    EXPECT_NEAR(object.inertia_O(0, 0), 0.24 * (0.06 * 0.06 + 0.1 * 0.1) / 12, 1e-9);
    EXPECT_NEAR(object.inertia_O(2, 2), 0.24 * (0.06 * 0.06 + 0.04 * 0.04) / 12, 1e-9);
    EXPECT_NEAR(object.inertia_O(0, 1), 0.0, 1e-12);
    EXPECT_THAT(object.said, Contains(HasSubstr(fmt::format("unit: {}, guessed", unit))));
  }
}

TEST_F(MeshObjectTest, IsScaledToALongestEdge) {
  MeshObjectOptions options;
  options.longest_m = 0.12;
  EXPECT_NEAR(MakeMeshObject(Box("a.obj", 1e-5), options).size_m.z(), 0.12, 1e-7);
  options.up = Up::kY;  // the file's size of 60 becomes the height
  const Eigen::Vector3d size_m = MakeMeshObject(Box("b.obj", 17.0), options).size_m;
  EXPECT_NEAR(size_m.y(), 0.12, 1e-7);
  EXPECT_NEAR(size_m.z(), 0.12 * 60 / 100, 1e-7);
}

// A cup of 80 x 95 mm with a wall of 3 mm and 48 sides: hulls over two or three sides deviate by at
// most 0.7 mm and by a third of that on average, but that is a tenth of the wall.
TEST_F(MeshObjectTest, AThinWallIsCutIntoFewHulls) {
  constexpr int kSides = 48;
  const std::array<std::pair<double, double>, 4> rings = {{{40, 0}, {40, 95}, {37, 95}, {37, 3}}};
  std::string text;
  for (const auto& [radius, z] : rings) {
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2.0 * base::kPi * i / kSides;
      text += fmt::format("v {} {} {}\n", radius * std::cos(angle), radius * std::sin(angle), z);
    }
  }
  text += "v 0 0 0\nv 0 0 3\n";
  for (int i = 1; i <= kSides; ++i) {
    const int j = i % kSides + 1;
    for (int ring = 0; ring < 3; ++ring) {
      const int a = ring * kSides + i, b = ring * kSides + j;
      text += fmt::format("f {} {} {}\nf {} {} {}\n", a, b, b + kSides, a, b + kSides, a + kSides);
    }
    text += fmt::format("f {} {} {}\n", j, i, 4 * kSides + 1);
    text += fmt::format("f {} {} {}\n", 3 * kSides + i, 3 * kSides + j, 4 * kSides + 2);
  }
  const MeshObject cup = MakeMeshObject(folder_.Write("cup.obj", text), {});
  EXPECT_LE(cup.hulls_O.size(), 30u);
  EXPECT_GT(cup.overlap.covered, 0.99);
  EXPECT_LT(cup.overlap.beyond, 0.2);
}

TEST_F(MeshObjectTest, TurnsWhatIsInsideOut) {
  const MeshObject object = MakeMeshObject(Box("in.obj", 1.0, true), {});
  EXPECT_GT(geometry::Volume(object.seen_O), 0.0);
  EXPECT_THAT(object.said, Contains(HasSubstr("inside out")));
}

TEST_F(MeshObjectTest, AMassGoesBeforeADensity) {
  MeshObjectOptions options;
  options.mass_kg = 0.5;
  EXPECT_EQ(MakeMeshObject(Box("a.obj", 1.0), options).mass_kg, 0.5);
}

TEST_F(MeshObjectTest, ATextureNeedsCoordinates) {
  EXPECT_THAT(testing_support::ErrorOf([&] { MakeMeshObject(Box("a.obj", 1.0), {}, true); }),
              HasSubstr("has no texture coordinates"));
}

}  // namespace
}  // namespace rangegrasp::objects
