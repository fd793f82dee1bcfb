#include "sim/bodies.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "base/error.h"
#include "sim/scene_files.h"

namespace rangegrasp::sim {
namespace {

using samples::MakeObject;
using samples::RepositoryObject;
using samples::Tabletop;
using samples::WriteFile;

// The meshes that sensors see of the same world are built by other code.
TEST(VisualBodies, StandWhereSensorsSeeThem) {
  World world(Tabletop(), {RepositoryObject("coffee_cup"), RepositoryObject("dextrose")}, {});
  const base::Pose X_WO = base::MakePose(
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix(),
      {0.1, -0.2, 0.3});
  world.PlaceObject(1, X_WO);
  world.Refresh();
  Eigen::AlignedBox3d drawn, seen;
  for (const VisualBody& body : VisualBodies(world)) {
    if (!body.object) continue;
    for (const auto& p : body.mesh_B.vertices) drawn.extend(BodyPose(world, body.body) * p);
  }
  for (const VisualMesh& mesh : world.VisualMeshes()) {
    EXPECT_NE(mesh.label, 1u) << "the cup is parked";
    if (mesh.label != 2) continue;
    for (const auto& p : mesh.mesh_W.vertices) seen.extend(p);
  }
  EXPECT_TRUE(drawn.isApprox(seen, 1e-9));
}

TEST(VisualBodies, HaveOneColorEach) {
  const auto model = MakeObject("flag", R"(<geom type="box" size="0.02 0.02 0.02" rgba="1 0 0 1"/>
      <geom type="box" size="0.02 0.02 0.02" pos="0 0 0.04" rgba="1 1 1 1"/>
      <geom type="box" size="0.02 0.02 0.02" pos="0 0 0.08" rgba="1 0 0 1"/>)");
  World world(Tabletop(), {model}, {});
  world.PlaceObject(0, base::Pose::Identity());
  std::vector<std::pair<float, std::size_t>> green;
  for (const VisualBody& body : VisualBodies(world)) {
    if (body.object) green.emplace_back(body.color.y(), body.mesh_B.triangles.size());
  }
  // Two red cubes in one mesh, and the white one, of 12 triangles each.
  EXPECT_EQ(green, (std::vector<std::pair<float, std::size_t>>{{0.0F, 24}, {1.0F, 12}}));
}

TEST(VisualBodies, HaveTheSameMeshesWhereverTheyStand) {
  World world(Tabletop(), {}, {});
  const auto before = VisualBodies(world);
  world.SetArm(world.ArmPositions().array() + 0.3);
  world.Refresh();
  const auto after = VisualBodies(world);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].mesh_B.vertices, after[i].mesh_B.vertices) << before[i].name;
  }
}

// A box rests on a fixed "hand"; its contacts carry its weight upwards.
TEST(HandForces, CarryTheWeightOfWhatLiesOnIt) {
  const auto scene = WriteFile("plate_hand.xml", R"(<mujoco><worldbody>
    <body name="hand" pos="0 0 0.5"><geom type="box" size="0.2 0.2 0.01"/></body>
    </worldbody></mujoco>)");
  World world(scene, {MakeObject("box", R"(<geom type="box" size="0.03 0.04 0.05" mass="0.3"/>)")},
              {});
  world.PlaceObject(0, base::MakePose(Eigen::Matrix3d::Identity(), {0.02, -0.01, 0.5605}));
  ASSERT_TRUE(world.Settle());
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto forces = HandForces(world, 0.0);
  for (const ContactForce& one : forces) {
    sum += one.force_W;
    EXPECT_NEAR(one.point_W.z(), 0.51, 0.001);
  }
  EXPECT_GE(forces.size(), 3u);
  // The box rests: forces from its remaining motion are below 1 % of its weight.
  EXPECT_NEAR(sum.z(), 0.3 * 9.81, 0.03);
  EXPECT_NEAR(sum.head<2>().norm(), 0.0, 0.03);
  EXPECT_TRUE(HandForces(world, 100.0).empty());
}

TEST(HandForces, NeedAHand) {
  const World world(samples::PlaneScene(), {}, {});
  EXPECT_THROW(HandForces(world, 0.0), base::InputError);
}

}  // namespace
}  // namespace rangegrasp::sim
