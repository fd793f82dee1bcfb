#include "geometry/mesh.h"

#include <gtest/gtest.h>

#include "geometry/random_points.h"
#include "geometry/shape.h"

namespace rangegrasp::geometry {
namespace {

TriangleMesh UnitCube() {
  Shape box;
  box.kind = Shape::Kind::kBox;
  box.size = {0.5, 0.5, 0.5};
  return Tessellate(box);
}

TEST(Mesh, VolumeIsThatOfTheSolidWhereverItStands) {
  base::Rng rng(1);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(rng.Uniform(0.0, 6.0), samples::RandomDirection(rng)).toRotationMatrix();
    const base::Pose X = base::MakePose(R, samples::RandomPoint(100.0, rng));
    EXPECT_NEAR(Volume(Transformed(UnitCube(), X)), 1.0, 1e-10);
  }
}

TEST(Mesh, VolumeOfAMeshTurnedInsideOutIsNegative) {
  TriangleMesh mesh = UnitCube();
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(Volume(mesh), -1.0, 1e-12);
  EXPECT_EQ(Volume(TriangleMesh{}), 0.0);
}

TEST(Mesh, AppendAddsUpEvenToItself) {
  TriangleMesh twice = UnitCube();
  for (Eigen::Vector3d& p : twice.vertices) p.z() *= 2.0;
  TriangleMesh mesh = UnitCube();
  Append(twice, mesh);
  EXPECT_NEAR(Volume(mesh), 3.0, 1e-12);
  Append(mesh, mesh);
  EXPECT_NEAR(Volume(mesh), 6.0, 1e-12);
  EXPECT_EQ(mesh.vertices.size(), 32u);
}

}  // namespace
}  // namespace rangegrasp::geometry
