#include "trial/arranger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "error_of.h"
#include "experiment/experiment.h"
#include "shipped_cell.h"
#include "temp_folder.h"
#include "trial/grasping_task.h"
#include "trial/judge.h"
#include "trial/trial.h"

namespace rangegrasp::trial {
namespace {

experiment::Experiment Open(const std::string& name, const std::vector<std::string>& set = {}) {
  return experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_" + name + ".yaml",
                                    {.set = set});
}

TrialSpec SpecFor(const std::string& object, int index) {
  return {object, index, TrialSeed(11, object, index)};
}

std::optional<Arrangement> Arrange(const experiment::Experiment& experiment,
                                   const std::string& object, int index) {
  return ArrangeTrial(CellOf(*experiment.task), SpecFor(object, index));
}

// From the engine's own list of contacts, with nothing asleep: the objects that overlap with the
// target, and the deepest penetration of any two objects.
struct Contacts {
  std::set<int> of_target;  // root bodies
  bool robot = false;
  double deepest_m = 0.0;
};
Contacts ContactsOf(sim::World& world) {
  const mjModel* model = world.model();
  world.model()->opt.enableflags &= ~mjENBL_SLEEP;
  mj_forward(model, world.data());
  std::set<int> roots;
  for (int object = 0; object < world.objects(); ++object) roots.insert(world.object_body(object));
  Contacts found;
  for (int i = 0; i < world.data()->ncon; ++i) {
    const mjContact& contact = world.data()->contact[i];
    int body[2];
    for (const int side : {0, 1}) {
      body[side] = model->body_rootid[model->geom_bodyid[contact.geom[side]]];
    }
    for (const int side : {0, 1}) {
      if (!roots.contains(body[side])) continue;
      found.deepest_m = std::max(found.deepest_m, -contact.dist);
      const int other = body[1 - side];
      if (body[side] == world.object_body(0) && roots.contains(other)) {
        found.of_target.insert(other);
      }
      const int part = model->geom_bodyid[contact.geom[1 - side]];
      found.robot |= !roots.contains(other) && model->body_weldid[part] != 0;
    }
  }
  return found;
}

class Clutter : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Arrangements, Clutter,
                         ::testing::Values("touching", "side_by_side", "box", "pile"));

TEST(FewInAPile, AreAsManyAsTheFileSaysAndNotAlwaysTheSame) {
  const auto experiment = Open("pile", {"clutter.draw_others=true"});
  std::set<std::string> others;
  for (int index = 0; index < 3; ++index) {
    auto arranged = Arrange(experiment, "dextrose", index);
    ASSERT_TRUE(arranged);
    EXPECT_GE(arranged->world.objects(), 3);
    EXPECT_LE(arranged->world.objects(), 6);
    for (int object = 1; object < arranged->world.objects(); ++object) {
      others.insert(arranged->world.object_name(object));
    }
  }
  EXPECT_GT(others.size(), 5U);
}

TEST_P(Clutter, IsWhatItsDefinitionSays) {
  const std::string kind = GetParam();
  const auto experiment = Open(kind);
  int index = 0;
  for (const char* object : {"dextrose", "coffee_cup", "sweets_prism"}) {
    auto arranged = Arrange(experiment, object, index++);
    ASSERT_TRUE(arranged) << object;
    sim::World& world = arranged->world;
    EXPECT_EQ(world.object_name(arranged->target), object);
    if (kind == "touching" || kind == "side_by_side") {
      EXPECT_GE(world.objects(), 3);
      EXPECT_LE(world.objects(), 6);
      EXPECT_GE(arranged->touching, kind == "touching" ? 2 : 1);
    } else {
      EXPECT_EQ(world.objects(), 12);
      EXPECT_GE(arranged->touching, 1);
    }
    for (int other = 1; other < world.objects(); ++other) {
      EXPECT_FALSE(world.parked(other));
      EXPECT_LT(world.ObjectTop(other), world.ObjectTop(0)) << object << other;
      if (kind != "box") continue;
      const Eigen::Vector3d center_W = world.ObjectCenterOfMass(other);
      EXPECT_LT(std::abs(center_W.x()), 0.16);
      EXPECT_LT(std::abs(center_W.y()), 0.21);
      EXPECT_GT(world.ObjectBottom(other), 0.005);
    }
    const Contacts contacts = ContactsOf(world);
    // Overlapping objects touch; counted objects may also be just closer than half a millimetre.
    EXPECT_LE(contacts.of_target.size(), static_cast<std::size_t>(arranged->touching));
    EXPECT_LT(contacts.deepest_m, 0.001);
    EXPECT_FALSE(contacts.robot);
  }
}

// The objects connected to the target through surfaces closer than kTouch_m.
std::set<int> GroupOfTarget(const sim::World& world) {
  std::set<int> group = {0};
  for (std::size_t before = 0; before != group.size();) {
    before = group.size();
    for (int object = 1; object < world.objects(); ++object) {
      const auto touches = [&](int other) {
        return other != object && world.ObjectDistance(object, other, 0.1) < kTouch_m;
      };
      if (std::ranges::any_of(group, touches)) group.insert(object);
    }
  }
  return group;
}

TEST(SideBySide, AllStandOnTheTableInOneGroupThatTouchesAndNoneIsBelowAnother) {
  const auto experiment = Open("side_by_side");
  for (const char* object : {"dextrose", "sweets_prism", "shower_gel", "melba_toast"}) {
    auto arranged = Arrange(experiment, object, 1);
    ASSERT_TRUE(arranged) << object;
    const sim::World& world = arranged->world;
    EXPECT_EQ(GroupOfTarget(world).size(), static_cast<std::size_t>(world.objects())) << object;
    for (int i = 0; i < world.objects(); ++i) EXPECT_LT(world.ObjectBottom(i), 0.001) << object;
    EXPECT_NE(arranged->pose_class, "leaning") << object;
  }
}

TEST(SideBySide, NeedsEnoughOtherObjects) {
  EXPECT_THROW(Open("side_by_side", {"objects=[spread, dextrose]"}), base::InputError);
}

// Uses the scene's own contact settings, and nothing may sleep.
TEST_P(Clutter, StaysAtRest) {
  const auto experiment = Open(GetParam());
  const Cell& cell = CellOf(*experiment.task);
  for (const char* object : {"melba_toast", "sweets_prism"}) {
    auto arranged = Arrange(experiment, object, 0);
    ASSERT_TRUE(arranged) << object;
    sim::World& world = arranged->world;
    EXPECT_GT(world.model()->opt.noslip_iterations, 0);
    world.model()->opt.enableflags &= ~mjENBL_SLEEP;
    const auto before_W = CentersOf(world);
    const double end_s = world.time_s() + 0.5;
    while (world.time_s() < end_s) world.Step();
    for (int i = 0; i < world.objects(); ++i) {
      EXPECT_LT(world.ObjectSpeed(i), cell.options.clutter.rest_speed_m_s) << object << i;
      const Eigen::Vector3d way =
          world.ObjectCenterOfMass(i) - before_W[static_cast<std::size_t>(i)];
      EXPECT_LT(way.norm(), 0.001) << object << i;
    }
  }
}

TEST_P(Clutter, IsTheSameForTheSameSeed) {
  const auto experiment = Open(GetParam());
  const Cell& cell = CellOf(*experiment.task);
  const auto poses = [&](int index, Redraws& redraws) {
    const auto arranged = ArrangeTrial(cell, SpecFor("salt_cuboid", index), redraws);
    std::vector<double> numbers;
    for (int i = 0; arranged && i < arranged->world.objects(); ++i) {
      const base::Pose X_WO = arranged->world.ObjectPose(i);
      numbers.insert(numbers.end(), X_WO.matrix().data(), X_WO.matrix().data() + 16);
    }
    return numbers;
  };
  Redraws first, again, other;
  const auto numbers = poses(0, first);
  EXPECT_EQ(numbers, poses(0, again));
  EXPECT_EQ(first, again);
  EXPECT_NE(numbers, poses(1, other));
}

// Two objects that are always among the others; one of them is the target.
experiment::Experiment OpenScattered(const std::vector<std::string>& set) {
  std::vector<std::string> all = {
      "arrangement=scattered",
      "objects=[sweets_cylinder, salt_cylinder]",
      "clutter.always=[sweets_cylinder, salt_cylinder]",
      "clutter.others=[spread, dextrose, coffee_cup, shower_gel, melba_toast]",
      "clutter.min_others=2",
      "clutter.max_others=3"};
  all.insert(all.end(), set.begin(), set.end());
  return Open("single", all);
}

TEST(Scattered, HasWhatIsAlwaysThereAndADrawnNumberOfOthersAllOnTheTable) {
  const auto experiment = OpenScattered({});
  std::set<int> counts;
  for (int index = 0; index < 8; ++index) {
    auto arranged = Arrange(experiment, "salt_cylinder", index);
    ASSERT_TRUE(arranged);
    sim::World& world = arranged->world;
    counts.insert(world.objects());
    EXPECT_EQ(world.object_name(0), "salt_cylinder");
    EXPECT_EQ(world.object_name(1), "sweets_cylinder");
    for (int object = 0; object < world.objects(); ++object) {
      EXPECT_LT(world.ObjectBottom(object), 0.001);  // no object lies on another
    }
    EXPECT_LT(ContactsOf(world).deepest_m, 0.001);
  }
  EXPECT_EQ(counts, (std::set<int>{4, 5}));
}

TEST(Scattered, TargetsStandAsOftenAsTheyAreToldTo) {
  for (const double share : {0.0, 1.0}) {
    const auto experiment = OpenScattered({"clutter.standing_share=" + std::to_string(share)});
    for (int index = 0; index < 4; ++index) {
      const auto arranged = Arrange(experiment, "sweets_cylinder", index);
      ASSERT_TRUE(arranged);
      for (const int object : {0, 1}) {
        const double upright = std::abs(arranged->world.ObjectPose(object).linear()(2, 2));
        EXPECT_NEAR(upright, share, 0.1) << index;
      }
    }
  }
}

TEST(Scattered, NeedsEnoughOtherObjects) {
  EXPECT_THROW(OpenScattered({"clutter.max_others=6"}), base::InputError);
}

// As drawn they are 135, 65, 95 and 60 mm high.
experiment::Experiment OpenAsDrawn(const std::string& arrangement) {
  return Open("single", {"arrangement=" + arrangement, "as_drawn=true",
                         "objects=[dextrose, spread, coffee_cup, black_cube]",
                         "clutter.min_others=2", "clutter.max_others=3"});
}

// A drop hardly ever leaves a carton upright.
TEST(AsDrawn, SeveralObjectsAllStand) {
  for (const char* arrangement : {"scattered", "side_by_side"}) {
    const auto experiment = OpenAsDrawn(arrangement);
    for (const char* target : {"dextrose", "coffee_cup"}) {
      const auto arranged = Arrange(experiment, target, 0);
      ASSERT_TRUE(arranged) << arrangement << target;
      const sim::World& world = arranged->world;
      EXPECT_GE(world.objects(), 3) << arrangement << target;
      for (int object = 0; object < world.objects(); ++object) {
        // A pose may be tilted by 0.1 rad, and an object may turn by as much before it is redrawn.
        EXPECT_GT(world.ObjectPose(object).linear()(2, 2), std::cos(0.2)) << arrangement << object;
      }
    }
  }
}

// A column of 20 x 20 x 200 mm tips over at atan(10 / 100) = 5.7 deg, which a search in steps of
// half a degree rounds down; the other box is drawn on its edge.
TEST(AsDrawn, AnObjectThatTipsOverIsNamedWithItsAngle) {
  const testing_support::TempFolder folder;
  const auto error = [&](const std::string& box) {
    folder.Write("objects/own/own.xml",
                 "<mujoco><worldbody><body name=\"own\"><freejoint/><geom type=\"box\" "
                 "mass=\"0.2\" " +
                     box + "/></body></worldbody></mujoco>");
    const auto file = folder.Write("e.yaml", "scene: " RANGEGRASP_SOURCE_DIR
                                             "/scenes/tabletop.xml\nsensor: " RANGEGRASP_SOURCE_DIR
                                             "/models/sensors/line_scanner.yaml\n"
                                             "object_folders: [objects]\nobjects: [own]\n"
                                             "as_drawn: true\n");
    return testing_support::ErrorOf([&] { experiment::OpenExperiment(file, {}); });
  };
  const std::string cure = " deg (min_tipping_deg: 10); set as_drawn: false, leave the object out";
  EXPECT_THAT(
      error("size=\".01 .01 .1\""),
      testing::HasSubstr("own.xml: with as_drawn: true it must stand as in its model, z up, "
                         "but then tips over at 5.5" +
                         cure));
  EXPECT_THAT(error("size=\".03 .03 .05\" euler=\"45 0 0\""),
              testing::HasSubstr("tips over at 0.0" + cure));
}

TEST(Arranger, TooFewObjectsAreNamedWithTheKey) {
  EXPECT_THAT(
      testing_support::ErrorOf<base::InputError>(
          [] { Open("touching", {"objects=[spread, dextrose]"}); }),
      testing::HasSubstr("needs 5 objects next to the target, but objects lists 1 besides "
                         "it; list more, or lower clutter.min_others and clutter.max_others"));
}

TEST(Arranger, TouchingNeedsTwoOthers) {
  const auto error = [](const std::string& arrangement) {
    return testing_support::MessageOf([&] {
      Open(arrangement, {"clutter.min_others=1", "clutter.max_others=1"});
    });
  };
  EXPECT_THAT(error("touching"), testing::HasSubstr("max_others': must be at least 2"));
  EXPECT_EQ(error("side_by_side"), "");
}

TEST(Arranger, WhatAnArrangementLacksIsNamedWithFileAndLine) {
  const testing_support::TempFolder folder;
  const auto error = [&](const std::string& arrangement) {
    const auto file = folder.Write(
        "e.yaml", testing_support::kShippedCell +
                      ("objects: [spread, dextrose]\narrangement: " + arrangement) + "\n");
    return testing_support::ErrorOf<base::InputError>(
        [&] { experiment::OpenExperiment(file, {}); });
  };
  const std::string at = (folder / "e.yaml").string() + ":5: key 'arrangement': ";
  EXPECT_THAT(error("touching"), testing::StartsWith(at + "touching needs 5 objects"));
  EXPECT_THAT(error("side_by_side"), testing::StartsWith(at + "side_by_side needs 5 objects"));
  EXPECT_THAT(error("scattered"), testing::StartsWith(at + "scattered needs 5 objects"));
  EXPECT_THAT(error("box"),
              testing::AllOf(testing::StartsWith(at), testing::HasSubstr("has no box")));
  EXPECT_THAT(error("tuching"),
              testing::AllOf(testing::StartsWith(at), testing::HasSubstr("touching")));
}

TEST(Arranger, CountsWhyItDrewAgain) {
  // No object is slower than this just after it was dropped.
  const auto experiment = Open("pile", {"clutter.max_draws=2", "clutter.rest_speed_mm_s=0.01",
                                        "clutter.settle_limit_s=0.5"});
  Redraws redraws;
  EXPECT_FALSE(ArrangeTrial(CellOf(*experiment.task), SpecFor("spread", 0), redraws));
  EXPECT_EQ(redraws, (Redraws{{Redraw::kNotAtRest, 2}}));
  EXPECT_EQ(Text(redraws), "not_at_rest x2");
  EXPECT_EQ(Total(redraws), 2);
}

TEST(Arranger, WhatDoesNotFitIntoTheBoxEndsTheTrialAndSaysSo) {
  // A prism of 300 mm does not fit into the box of 60 x 60 mm.
  const auto experiment = Open(
      "box", {"scene=" RANGEGRASP_SOURCE_DIR "/tests/trial/small_box.xml", "clutter.max_draws=7"});
  const auto result = RunTrial(CellOf(*experiment.task), SpecFor("sweets_prism", 0));
  EXPECT_EQ(result.outcome, "crashed");
  EXPECT_EQ(result.stage, "arrange");
  EXPECT_EQ(result.detail, "no arrangement: does_not_fit x7");
}

TEST(Arranger, ABoxNeedsASceneWithABox) {
  EXPECT_THROW(Open("box", {"scene=../scenes/tabletop.xml"}), base::InputError);
}

TEST(Arranger, WallsOfABoxNeedASceneWithABox) {
  EXPECT_THROW(Open("single", {"clutter.box_wall_mm=60"}), base::InputError);
  EXPECT_THAT(testing_support::ErrorOf([] { Open("pile", {"clutter.box_wall_mm=60"}); }),
              testing::StartsWith("--set clutter.box_wall_mm: "));
}

// The keys of `clutter` that an experiment with this arrangement is warned of.
std::set<std::string> Ignored(const std::string& arrangement, std::vector<std::string> set) {
  set.push_back("arrangement=" + arrangement);
  auto map = base::YamlMap::FromFile(RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", set);
  std::string task;
  map.Read("task", task);
  experiment::Common common;
  experiment::ReadCommon(map, common);
  std::set<std::string> keys;
  for (const base::Finding& finding : IgnoredKeys(map, ReadOptions(map, 1))) {
    EXPECT_FALSE(finding.error);
    EXPECT_EQ("key '" + finding.where.substr(std::string("--set ").size()) + "'", finding.element);
    keys.insert(finding.element);
  }
  return keys;
}

// Every key, also one that is added later: `single` reads none but the height of the scene's walls.
TEST(Arranger, KeysThatAnArrangementDoesNotReadAreWarnedOf) {
  auto documentation = base::YamlMap::ForDocumentation();
  ReadOptions(documentation, 1);
  std::vector<std::string> set;
  for (const base::KeyDoc& key : documentation.Keys()) {
    if (!key.path.starts_with("clutter.") || key.path == "clutter.box_wall_mm") continue;
    const std::string otherwise = key.type == "list" ? "[spread]" : "0.5";
    set.push_back(key.path + "=" + (key.default_value.empty() ? otherwise : key.default_value));
  }
  EXPECT_EQ(Ignored("single", set).size(), set.size());
  // Texts begin with the arrangements that read the key, if these are not all.
  for (const std::string arrangement : {"scattered", "touching", "side_by_side", "pile"}) {
    const auto ignored = Ignored(arrangement, set);
    for (const base::KeyDoc& key : documentation.Keys()) {
      const auto colon = key.doc.find(": ");
      if (!key.path.starts_with("clutter.") || colon == std::string::npos) continue;
      const bool read = key.doc.substr(0, colon).find(arrangement) != std::string::npos;
      EXPECT_NE(ignored.contains("key '" + key.path + "'"),
                read || key.path.ends_with("box_wall_mm"))
          << arrangement << " " << key.path;
    }
  }
  EXPECT_EQ(Ignored("pile", {"clutter.max_others=3", "clutter.max_draws=40"}),
            std::set<std::string>{"key 'clutter.max_others'"});
  EXPECT_TRUE(Ignored("pile", {"clutter.max_others=3", "clutter.draw_others=true"}).empty());
}

TEST(Arranger, AScatteredTargetOfAGraspIsWarnedOf) {
  const auto warned = [](const std::string& arrangement) {
    bool found = false;
    experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml",
                               {.set = {"arrangement=" + arrangement}},
                               [&](const std::vector<base::Finding>& findings) {
                                 found = std::ranges::find(findings, "--set arrangement",
                                                           &base::Finding::where) != findings.end();
                                 return false;
                               });
    return found;
  };
  EXPECT_TRUE(warned("scattered"));
  EXPECT_FALSE(warned("touching"));
}

TEST(Arranger, ABoxWithLowWallsHoldsAllObjects) {
  const auto experiment = Open("box", {"clutter.box_wall_mm=60"});
  const auto arranged = Arrange(experiment, "dextrose", 0);
  ASSERT_TRUE(arranged);
  EXPECT_NEAR(arranged->world.container()->half_m.z(), 0.030, 1e-9);
  EXPECT_EQ(arranged->world.objects(), 12);
}

TEST(JudgeOthers, CountsWhatMovedAndWhatLeftTheTable) {
  const auto experiment = Open("touching");
  auto arranged = Arrange(experiment, "dextrose", 0);
  ASSERT_TRUE(arranged);
  sim::World& world = arranged->world;
  const auto before_W = CentersOf(world);
  EXPECT_EQ(JudgeOthers(before_W, world, 0).moved, 0);
  base::Pose X_WO = world.ObjectPose(1);
  X_WO.translation().x() += 0.004;
  world.PlaceObject(1, X_WO);
  EXPECT_EQ(JudgeOthers(before_W, world, 0).moved, 0);
  X_WO.translation().x() += 0.004;
  world.PlaceObject(1, X_WO);
  EXPECT_EQ(JudgeOthers(before_W, world, 0).moved, 1);
  EXPECT_EQ(JudgeOthers(before_W, world, 0).left_table, 0);
  X_WO.translation().x() += 1.0;
  world.PlaceObject(1, X_WO);
  EXPECT_EQ(JudgeOthers(before_W, world, 0).left_table, 1);
  // The target's own motion is the purpose of the trial.
  EXPECT_EQ(JudgeOthers(before_W, world, 1).moved, 0);
}

}  // namespace
}  // namespace rangegrasp::trial
