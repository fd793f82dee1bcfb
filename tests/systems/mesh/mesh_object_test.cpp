#include "mesh/mesh_object.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "error_of.h"
#include "geometry/shape.h"
#include "temp_folder.h"

namespace rangegrasp::objects {
namespace {

using testing::AnyOf;
using testing::Contains;
using testing::HasSubstr;

class MeshObjectTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!CanCut()) GTEST_SKIP() << "CoACD is not there; scripts/setup fetches it";
  }
  // A box of 40 x 60 x 100 in the file's unit, as OBJ.
  std::filesystem::path Box(const std::string& name, double unit, bool upside_in = false) {
    geometry::Shape box;
    box.kind = geometry::Shape::Kind::kBox;
    box.size = Eigen::Vector3d(20, 30, 50) * unit;
    const geometry::TriangleMesh mesh = Tessellate(box);
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

TEST_F(MeshObjectTest, IsScaledToAHeightOrALongestEdge) {
  MeshObjectOptions options;
  options.height_m = 0.08;
  EXPECT_NEAR(MakeMeshObject(Box("a.obj", 17.0), options).size_m.z(), 0.08, 1e-7);
  options.up = Up::kY;  // 60 of the file's are the height
  EXPECT_NEAR(MakeMeshObject(Box("b.obj", 17.0), options).size_m.y(), 0.08 * 100 / 60, 1e-7);
  options = {};
  options.longest_m = 0.12;
  EXPECT_NEAR(MakeMeshObject(Box("c.obj", 1e-5), options).size_m.maxCoeff(), 0.12, 1e-7);
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

TEST_F(MeshObjectTest, ATextureWithoutCoordinatesGoesRoundIt) {
  const MeshObject object = MakeMeshObject(Box("a.obj", 1.0), {}, true);
  ASSERT_EQ(object.uv.size(), object.seen_O.triangles.size());
  for (const auto& corners : object.uv) {
    for (const auto& uv : corners) {
      EXPECT_GE(uv.y(), 0.0);
      EXPECT_LE(uv.y(), 1.0);
      EXPECT_LE((uv - corners[0]).cwiseAbs().x(), 0.5 + 1e-9);
    }
  }
}

}  // namespace
}  // namespace rangegrasp::objects
