#include "sim/world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "error_of.h"
#include "sim/scene_files.h"

namespace rangegrasp::sim {
namespace {

using samples::MakeObject;
using samples::PlaneScene;
using samples::RepositoryObject;
using samples::Tabletop;
using samples::WriteFile;
using ::testing::HasSubstr;

constexpr char kWorldBox[] = R"(<geom type="box" size="0.03 0.04 0.05" mass="0.3"/>)";

base::Pose At(double x, double y, double z) {
  return base::MakePose(Eigen::Matrix3d::Identity(), {x, y, z});
}

// The text of the InputError when building a world from these files.
std::string Complaint(const std::filesystem::path& scene, const std::vector<ObjectModel>& objects) {
  return testing_support::ErrorOf([&] { World(scene, objects, {}); });
}

// The engine would hardly finish a step, or overflow its stack while it reads the file.
TEST(World, RefusesFilesThatTheEngineDoesNotSurvive) {
  const auto heavy = MakeObject("heavy", R"(<geom type="box" size=".1 .1 .1" mass="1e100"/>)");
  EXPECT_NE(Complaint(PlaneScene(), {heavy})
                .find(heavy.mjcf.string() + ": an object's mass must be above 0 and at most 1e+06"),
            std::string::npos);
  const auto own = samples::WriteFile(
      "own.xml", R"(<mujoco><asset><model name="a" file="own.xml"/></asset></mujoco>)");
  EXPECT_NE(Complaint(own, {}).find("own.xml:1: <model file="), std::string::npos);
}

TEST(World, HoldsNothingByWeldOrAdhesion) {
  const World world(Tabletop(), {RepositoryObject("dextrose"), RepositoryObject("coffee_cup")}, {});
  const mjModel* model = world.model();
  for (int i = 0; i < model->neq; ++i) EXPECT_EQ(model->eq_type[i], mjEQ_JOINT);
  for (int i = 0; i < model->nu; ++i) {
    EXPECT_TRUE(model->actuator_trntype[i] == mjTRN_JOINT ||
                model->actuator_trntype[i] == mjTRN_TENDON);
  }
  EXPECT_EQ(world.Warnings(), "");
}

// The visual and the collision geometry get the same height.
TEST(World, WallsOfABoxAreAsHighAsTheOptionsSayToTheEyeAndToTheTouch) {
  const std::filesystem::path scene = Tabletop().parent_path() / "tabletop_box.xml";
  for (const double wall_m : {0.06, 0.09, 0.12}) {
    PhysicsOptions options;
    options.box_wall_m = wall_m;
    const World world(scene, {}, options);
    const auto interior = world.container();
    ASSERT_TRUE(interior);
    EXPECT_NEAR(interior->half_m.z(), 0.5 * wall_m, 1e-9);
    EXPECT_NEAR(interior->X_WI.translation().z() - interior->half_m.z(), 0.006, 1e-9);  // floor
    double seen_top_m = 0.0;
    for (const VisualMesh& visual : world.VisualMeshes()) {
      if (visual.label != kContainerLabel) continue;
      for (const auto& p_W : visual.mesh_W.vertices) seen_top_m = std::max(seen_top_m, p_W.z());
    }
    EXPECT_NEAR(seen_top_m, 0.006 + wall_m, 1e-6);
    int walls = 0;
    const mjModel* model = world.model();
    const int box = mj_name2id(model, mjOBJ_BODY, "box");
    for (int geom = 0; geom < model->ngeom; ++geom) {
      if (model->geom_bodyid[geom] != box || model->geom_contype[geom] == 0) continue;
      const double top_m = model->geom_pos[3 * geom + 2] + model->geom_size[3 * geom + 2];
      if (std::abs(top_m - 0.006) < 1e-9) continue;  // the floor
      EXPECT_NEAR(top_m, 0.006 + wall_m, 1e-9);
      ++walls;
    }
    EXPECT_EQ(walls, 4);
  }
}

TEST(World, AnObjectFallsFreely) {
  World world(PlaneScene(), {MakeObject("box", kWorldBox)}, {});
  world.PlaceObject(0, At(0, 0, 3.0));
  for (int i = 0; i < 250; ++i) world.Step();
  // With semi-implicit steps of h, the fall is g t (t + h) / 2.
  EXPECT_NEAR(world.ObjectPose(0).translation().z(), 3.0 - 0.5 * 9.81 * 0.5 * 0.502, 1e-9);
}

TEST(World, ABoxAtRestStays) {
  World world(PlaneScene(), {MakeObject("box", kWorldBox)}, {});
  world.PlaceObject(0, At(0.1, 0.2, 0.0501));
  ASSERT_TRUE(world.Settle());
  const Eigen::Vector3d before = world.ObjectPose(0).translation();
  const double end = world.time_s() + 2.0;
  while (world.time_s() < end) world.Step();
  EXPECT_LT((world.ObjectPose(0).translation() - before).norm(), 1e-5);
  EXPECT_NEAR(world.ObjectTop(0), 0.1, 2e-4);
  EXPECT_NEAR(world.ObjectMass(0), 0.3, 1e-12);
  EXPECT_LT((world.ObjectCenterOfMass(0) - before).norm(), 1e-9);
}

// The draw depends only on the random stream: it is the same for the same seed and different for
// each object, whatever its surface.
TEST(World, DrawsAPairForEachObjectFromItsRange) {
  World world(PlaneScene(), {MakeObject("box", kWorldBox), MakeObject("other", kWorldBox)}, {});
  EXPECT_EQ(world.glove_friction(0).static_mu, 0.6);
  double low = 1.0, high = 0.0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    base::Rng rng(seed);
    world.DrawFriction(rng);
    const double first = world.glove_friction(0).static_mu;
    EXPECT_NE(first, world.glove_friction(1).static_mu);
    EXPECT_NE(first, world.glove_friction(-1).static_mu);
    base::Rng again(seed);
    world.DrawFriction(again);
    EXPECT_EQ(world.glove_friction(0).static_mu, first);
    low = std::min(low, first);
    high = std::max(high, first);
  }
  EXPECT_GE(low, 0.45);
  EXPECT_LT(low, 0.49);
  EXPECT_GT(high, 0.75);
  EXPECT_LE(high, 0.80);
}

TEST(World, AParkedObjectTakesNoPart) {
  World world(PlaneScene(), {MakeObject("box", kWorldBox), MakeObject("other", kWorldBox)}, {});
  world.PlaceObject(0, At(0, 0, 0.0501));
  ASSERT_TRUE(world.Settle());
  EXPECT_TRUE(world.parked(1));
  EXPECT_GT((world.ObjectPose(1).translation() - world.ObjectPose(0).translation()).norm(), 100.0);
  EXPECT_EQ(world.VisualMeshes().size(), 2u);  // the scene and one object
  EXPECT_EQ(world.ObjectSpeed(1), 0.0);
}

// A box without support must fall even if it was asleep.
TEST(World, TakingTheSupportAwayWakesWhatRestedOnIt) {
  World world(PlaneScene(), {MakeObject("below", kWorldBox), MakeObject("above", kWorldBox)}, {});
  world.PlaceObject(0, At(0, 0, 0.0501));
  world.PlaceObject(1, At(0, 0, 0.1503));
  ASSERT_TRUE(world.Settle());
  for (int i = 0; i < 200; ++i) world.Step();
  world.PlaceObject(0, At(1, 0, 0.0501));
  ASSERT_TRUE(world.Settle());
  EXPECT_NEAR(world.ObjectPose(1).translation().z(), 0.05, 1e-3);
}

TEST(World, SettleTellsWhatFallsForEver) {
  const auto scene = WriteFile(
      "void.xml", R"(<mujoco><option timestep="0.002"><flag sleep="enable"/></option></mujoco>)");
  World world(scene, {MakeObject("box", kWorldBox)}, {});
  world.PlaceObject(0, At(0, 0, 0));
  EXPECT_FALSE(world.Settle());
}

TEST(World, VisualMeshesCarryLabelsSurfacesAndPoses) {
  World world(Tabletop(), {RepositoryObject("dextrose")}, {});
  world.PlaceObject(0, At(0.05, 0.02, 0.0675));
  const auto meshes = world.VisualMeshes();
  ASSERT_EQ(meshes.size(), 2u);
  EXPECT_EQ(meshes[0].label, 0u);
  EXPECT_EQ(meshes[1].label, 1u);
  EXPECT_NEAR(meshes[0].surface.albedo, 0.35, 1e-12);
  EXPECT_NEAR(meshes[1].surface.albedo, 0.65, 1e-12);
  const Eigen::AlignedBox3d box = geometry::BoundsOf(meshes[1].mesh_W.vertices);
  EXPECT_LT((box.center() - Eigen::Vector3d(0.05, 0.02, 0.0675)).norm(), 2e-3);
  EXPECT_GT(box.sizes().z(), 0.12);
  // The scanner's own stand is not included, or it would block the scanner's view.
  const Eigen::Vector3d scanner = world.SitePose("scanner").translation();
  for (const auto& v : meshes[0].mesh_W.vertices) EXPECT_GT((v - scanner).norm(), 0.2);
}

TEST(World, TheArmStandsWhereItIsPut) {
  World world(Tabletop(), {}, {});
  Eigen::VectorXd q = world.ArmPositions();
  ASSERT_EQ(q.size(), 7);
  q[0] += 0.3;
  world.SetArm(q);
  EXPECT_EQ(world.ArmPositions(), q);
  for (int i = 0; i < 500; ++i) world.Step();
  EXPECT_LT((world.ArmPositions() - q).norm(), 2e-3);  // the servos hold it against gravity
  EXPECT_THROW(world.SetArm(Eigen::VectorXd::Zero(3)), std::invalid_argument);
}

TEST(World, UnknownNamesAreNamedWithTheKnownOnes) {
  const World world(Tabletop(), {}, {});
  const std::string error = testing_support::ErrorOf([&] { world.SitePose("moon"); });
  EXPECT_THAT(error, HasSubstr("moon"));
  EXPECT_THAT(error, HasSubstr("delivery"));
}

std::string Body(const std::string& inside) {
  return "<mujoco><worldbody>" + inside + "</worldbody></mujoco>";
}

TEST(World, SaysWhyAnObjectIsNone) {
  const auto scene = PlaneScene();
  const auto complaint = [&](const std::string& xml) {
    return Complaint(scene, {{"odd", WriteFile("odd.xml", xml)}});
  };
  const std::string geom = R"(<geom type="sphere" size="0.02"/>)";
  EXPECT_THAT(complaint(Body("<body name='odd'>" + geom + "</body>")), HasSubstr("freejoint"));
  EXPECT_THAT(complaint(Body("<body name='odd'><joint/>" + geom + "</body>")),
              HasSubstr("freejoint"));
  EXPECT_THAT(complaint(Body("<body name='a'><freejoint/>" + geom + "</body><body name='b'>" +
                             geom + "</body>")),
              HasSubstr("one root body"));
  EXPECT_THAT(
      complaint(Body(
          "<body name='odd'><freejoint/><geom size='0.02' contype='0' conaffinity='0'/></body>")),
      HasSubstr("collision geom"));
  EXPECT_THAT(complaint(Body("<body name='odd'><freejoint/><geom size='0.02' mass='nan'/></body>")),
              HasSubstr("odd.xml"));
  EXPECT_THAT(complaint("<mujoco><worldbody>"), HasSubstr("odd.xml"));
  EXPECT_THAT(
      complaint(Body("<body name='odd'><freejoint/><geom type='mesh' mesh='none'/></body>")),
      HasSubstr("odd.xml"));
  EXPECT_THAT(complaint("<mujoco><custom><text name='surface' "
                        "data='velvet'/></custom><worldbody><body name='odd'>"
                        "<freejoint/><geom size='0.02'/></body></worldbody></mujoco>"),
              HasSubstr("velvet"));
  EXPECT_THAT(Complaint(scene, {{"odd", "nowhere.xml"}}), HasSubstr("nowhere.xml"));
  EXPECT_THAT(Complaint("noscene.xml", {}), HasSubstr("noscene.xml"));
  const std::string spread = RANGEGRASP_SOURCE_DIR "/models/objects/spread";
  for (const std::string& folder : {spread, spread + "/"}) {
    EXPECT_THAT(Complaint(folder, {}), HasSubstr("/spread.xml"));
    EXPECT_THAT(Complaint(folder, {}), HasSubstr("is a folder; name its file"));
  }
  // Of a folder of objects, one that exists.
  const std::string suggested = Complaint(RANGEGRASP_SOURCE_DIR "/models/objects", {});
  const std::string object = suggested.substr(suggested.rfind(' ') + 1);
  EXPECT_TRUE(std::filesystem::is_regular_file(object)) << suggested;
}

// The run repeats to the last bit, as if nothing had happened in between.
TEST(World, GoesBackToWhatWasSaved) {
  World world(PlaneScene(), {MakeObject("box", kWorldBox), MakeObject("other", kWorldBox)}, {});
  world.PlaceObject(0, At(0.0, 0.0, 0.2));
  for (int i = 0; i < 20; ++i) world.Step();
  const auto saved = world.Save();
  const auto run = [&] {
    world.PlaceObject(1, At(0.01, 0.0, 0.6));
    for (int i = 0; i < 200; ++i) world.Step();
    return world.ObjectPose(0).matrix().eval();
  };
  const Eigen::Matrix4d first = run();
  world.Restore(*saved);
  EXPECT_TRUE(world.parked(1));
  EXPECT_EQ(first, run());
}

TEST(World, KnowsHowFarThingsAreApart) {
  World world(PlaneScene(), {MakeObject("box", kWorldBox), MakeObject("other", kWorldBox)}, {});
  world.PlaceObject(0, At(0.0, 0.0, 0.06));
  world.PlaceObject(1, At(0.1, 0.0, 0.06));  // half edges are 30 mm along x, so 40 mm remain
  EXPECT_NEAR(world.ObjectDistance(0, 1, 1.0), 0.04, 1e-6);
  EXPECT_EQ(world.ObjectDistance(0, 1, 0.02), 0.02);
  EXPECT_NEAR(world.SceneDistance(0, 1.0), 0.01, 1e-9);
  EXPECT_NEAR(world.ObjectBounds(1).max().x(), 0.13, 1e-9);
  world.PlaceObject(1, At(0.055, 0.0, 0.06));
  EXPECT_NEAR(world.ObjectDistance(0, 1, 1.0), -0.005, 1e-6);
}

TEST(World, SeesAnOpenBoxUnderALabelOfItsOwn) {
  const World world(std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "scenes/tabletop_box.xml",
                    {RepositoryObject("dextrose")}, {});
  ASSERT_TRUE(world.container());
  EXPECT_NEAR(world.container()->half_m.y(), 0.21, 1e-12);
  EXPECT_EQ(std::ranges::count(world.VisualMeshes(), kContainerLabel, &VisualMesh::label), 1);
  EXPECT_FALSE(World(Tabletop(), {}, {}).container());
}

// Objects at rest after coarse steps also rest with the scene's own steps, with which no part of
// the robot ever sleeps.
TEST(World, WhatFellCoarselyRestsUnderTheScenesOwnSteps) {
  World world(Tabletop(), {RepositoryObject("dextrose"), RepositoryObject("salt_cylinder")}, {});
  world.StepCoarsely(true);
  world.PlaceObject(0, At(0.0, 0.0, 0.10));
  world.PlaceObject(1, At(0.0, 0.01, 0.25));
  const auto robot_sleeps = [&] { return world.data()->tree_asleep[0] >= 0; };
  ASSERT_TRUE(world.Settle());
  EXPECT_NEAR(world.model()->opt.timestep, 0.004, 1e-12);
  EXPECT_TRUE(robot_sleeps());
  const double coarse_s = world.time_s();
  world.StepCoarsely(false);
  const std::array<Eigen::Vector3d, 2> before_W = {world.ObjectCenterOfMass(0),
                                                   world.ObjectCenterOfMass(1)};
  EXPECT_TRUE(world.Settle());
  // Everything is awake at first: ten steps at rest are required before anything may sleep.
  EXPECT_GT(world.time_s() - coarse_s, 0.015);
  EXPECT_FALSE(robot_sleeps());
  EXPECT_EQ(world.model()->opt.timestep, 0.002);
  EXPECT_EQ(world.model()->opt.impratio, 10.0);
  EXPECT_EQ(world.model()->opt.noslip_iterations, 10);
  EXPECT_EQ(world.model()->opt.iterations, 110);  // the engine counts both together
  for (const int i : {0, 1}) {
    const Eigen::Vector3d way = world.ObjectCenterOfMass(i) - before_W[i];
    EXPECT_LT(way.norm(), 0.001) << i;
  }
}

// The hand presses down on a pile, in a state from a run that cleared a table (the file has all
// digits). The engine's Newton solver uses up its iterations, and the pile gains 70 J from nothing
// within the step.
TEST(World, AStepThatDoesNotConvergeIsDoneAgain) {
  std::vector<ObjectModel> objects;
  for (const char* name : {"salt_cylinder", "sweets_cylinder", "spread", "sweets_half_cylinder",
                           "melba_toast", "dextrose", "salt_cuboid", "sweets_pentagon",
                           "coffee_cup", "shower_gel", "cleaner", "sweets_prism"}) {
    objects.push_back(RepositoryObject(name));
  }
  World world(Tabletop(), objects, {});
  for (const int i : {1, 2, 5, 6, 7, 8, 9, 10, 11}) world.PlaceObject(i, At(0.0, 0.0, 1.0));
  std::ifstream file(RANGEGRASP_SOURCE_DIR "/tests/sim/pinched_heap.txt");
  mjModel* model = world.model();
  mjData* data = world.data();
  const auto read = [&](mjtNum* values, mjtSize count) {
    std::string heading;
    ASSERT_TRUE(std::getline(file >> std::ws, heading));
    for (mjtSize i = 0; i < count; ++i) ASSERT_TRUE(file >> values[i]);
  };
  read(data->qpos, model->nq);
  read(data->qvel, model->nv);
  read(data->qacc_warmstart, model->nv);
  read(data->ctrl, model->nu);
  const int robot_joints = 11;
  read(model->jnt_range, 2 * robot_joints);
  std::array<mjtNum, 44> friction;
  read(friction.data(), 44);
  for (std::size_t i = 0; i < friction.size(); ++i)
    model->geom_friction[3 * (57 + i)] = friction[i];
  std::vector<double> before_m_s;
  for (int i = 0; i < world.objects(); ++i) before_m_s.push_back(world.ObjectSpeed(i));
  const double start_s = world.time_s();
  world.Step();
  EXPECT_NEAR(world.time_s() - start_s, 0.002, 1e-12);
  for (int i = 0; i < world.objects(); ++i) {
    EXPECT_LT(world.ObjectSpeed(i), before_m_s[i] + 0.5) << i;
  }
  EXPECT_EQ(model->opt.solver, mjSOL_NEWTON);
  EXPECT_EQ(world.WarningCount(), 0);
  EXPECT_EQ(world.solver_counts().repeated, 1);
  EXPECT_EQ(world.solver_counts().unsolved, 0);
}

}  // namespace
}  // namespace rangegrasp::sim
