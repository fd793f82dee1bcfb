#include "experiment/experiment_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"
#include "core/file.h"
#include "temp_folder.h"

namespace rangegrasp::experiment {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using testing_support::TempFolder;

const std::filesystem::path kSource = RANGEGRASP_SOURCE_DIR;

std::vector<std::filesystem::path> ShippedExperiments() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(kSource / "experiments")) {
    // Seams and parts have experiment files of their own.
    const std::string name = entry.path().filename().string();
    if (name.starts_with("seam_") || name.starts_with("parts_")) continue;
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

TEST(ReadExperiment, ReadsEveryShippedExperiment) {
  const auto files = ShippedExperiments();
  ASSERT_FALSE(files.empty());
  for (const auto& file : files) {
    const Experiment e = ReadExperiment(file);
    EXPECT_EQ(e.name, file.stem().string());
    EXPECT_FALSE(e.objects.empty()) << file;
    for (const auto& object : e.objects) {
      EXPECT_TRUE(std::filesystem::exists(ObjectModelOf(e, object).mjcf)) << file << " " << object;
    }
  }
}

TEST(ReadExperiment, Table52HasTwelveObjectsOfTenTrials) {
  const Experiment e = ReadExperiment(kSource / "experiments/laser_single.yaml");
  EXPECT_EQ(e.objects.size(), 12u);
  EXPECT_EQ(e.trials_per_object, 10);
  EXPECT_EQ(e.arrangement, Arrangement::kSingle);
  EXPECT_EQ(e.scene.filename(), "tabletop.xml");
  EXPECT_TRUE(std::filesystem::exists(e.reference));
}

// A small project of its own: experiments/e.yaml with a scene, a sensor and two objects.
class ExperimentFileTest : public testing::Test {
 protected:
  ExperimentFileTest() {
    folder_.Write("scenes/table.xml", "<mujoco><include file=\"../models/arm.xml\"/></mujoco>");
    folder_.Write("models/arm.xml", "<mujoco><mesh file=\"arm.stl\"/></mujoco>");
    folder_.Write("models/arm.stl", "mesh");
    folder_.Write("models/sensor.yaml", "samples: 512\n");
    for (const char* object : {"mug", "box"}) {
      folder_.Write(std::string("models/objects/") + object + "/" + object + ".xml", object);
    }
  }
  std::filesystem::path Write(const std::string& text) {
    return folder_.Write("experiments/e.yaml", text);
  }
  std::string ErrorOf(const std::string& text) {
    try {
      ReadExperiment(Write(text));
    } catch (const core::InputError& e) {
      return e.what();
    } catch (const std::exception& e) {
      ADD_FAILURE() << "another error: " << e.what();
      return "";
    }
    ADD_FAILURE() << "no error for\n" << text;
    return "";
  }

  TempFolder folder_;
  const std::string good_ =
      "name: demo\n"
      "scene: ../scenes/table.xml\n"
      "sensor: ../models/sensor.yaml\n"
      "objects: [mug, box]\n";
};

TEST_F(ExperimentFileTest, WhatIsNotGivenKeepsTheDefaultOfItsStruct) {
  const Experiment e = ReadExperiment(Write(good_));
  EXPECT_EQ(e.scene, folder_ / "scenes/table.xml");
  EXPECT_EQ(e.object_folder, folder_ / "models/objects");
  EXPECT_EQ(e.trials_per_object, Experiment{}.trials_per_object);
  EXPECT_EQ(e.seed, Experiment{}.seed);
  EXPECT_EQ(e.physics.timestep_s, sim::PhysicsOptions{}.timestep_s);
  EXPECT_EQ(e.perception.segment.method, perception::SegmentMethod::kMesh);
  EXPECT_TRUE(e.reference.empty());
}

TEST_F(ExperimentFileTest, EveryKeyArrivesInItsOptionInSiUnits) {
  const Experiment e = ReadExperiment(
      Write(good_ +
            "trials_per_object: 3\nseed: 7\ntrial_limit_s: 90\nmost_plans: 5\nmin_tipping_deg: 12\n"
            "workspace_margin_mm: 200\n"
            "physics: {timestep_ms: 1, static_friction_offset: -0.15, kinetic_only: true, "
            "glove_friction: 0.4}\n"
            "hand: {initial_force_n: 30, max_force_n: 60, slip_control: false}\n"
            "perception: {segmentation: region_growing, filter: false, smooth: false, "
            "normal_radius_mm: 6, plane_distance_mm: 3, table_clearance_mm: 5}\n"
            "grasp: {refine: false, table_clearance_mm: 6, most: 9}\n"
            "planning: {approach_mm: 150, lift_mm: 250}\n"));
  EXPECT_EQ(e.trials_per_object, 3);
  EXPECT_EQ(e.seed, 7u);
  EXPECT_EQ(e.trial_limit_s, 90.0);
  EXPECT_EQ(e.most_plans, 5);
  EXPECT_DOUBLE_EQ(e.workspace_margin_m, 0.2);
  EXPECT_NEAR(e.min_tipping_rad, 0.20943951, 1e-8);
  EXPECT_DOUBLE_EQ(e.physics.timestep_s, 0.001);
  EXPECT_DOUBLE_EQ(e.physics.static_friction_offset, -0.15);
  EXPECT_TRUE(e.physics.kinetic_only);
  EXPECT_EQ(e.physics.glove_friction, 0.4);
  EXPECT_DOUBLE_EQ(e.hand.initial_force_N, 30.0);
  EXPECT_DOUBLE_EQ(e.hand.max_force_N, 60.0);
  EXPECT_FALSE(e.hand.slip_control);
  EXPECT_EQ(e.perception.segment.method, perception::SegmentMethod::kRegionGrowing);
  EXPECT_FALSE(e.perception.preprocess.filter);
  EXPECT_FALSE(e.perception.preprocess.smooth);
  EXPECT_DOUBLE_EQ(e.perception.preprocess.normal_radius_m, 0.006);
  EXPECT_DOUBLE_EQ(e.perception.preprocess.plane_distance_m, 0.003);
  EXPECT_DOUBLE_EQ(e.perception.preprocess.table_clearance_m, 0.005);
  EXPECT_FALSE(e.grasp.refine);
  EXPECT_DOUBLE_EQ(e.grasp.table_clearance_m, 0.006);
  EXPECT_EQ(e.grasp.most, 9);
  EXPECT_DOUBLE_EQ(e.planning.approach_m, 0.15);
  EXPECT_DOUBLE_EQ(e.planning.lift_m, 0.25);
}

TEST_F(ExperimentFileTest, WhatIsWrongIsNamedWithFileLineAndKey) {
  struct Case {
    std::string text;
    int line;
    std::string says;
  };
  const std::vector<Case> cases = {
      {good_ + "trials: 3\n", 5, "unknown key 'trials'"},
      {good_ + "trials_per_objects: 3\n", 5, "nearest valid key: 'trials_per_object'"},
      {good_ + "trials_per_object: 0\n", 5, "'trials_per_object'"},
      {good_ + "trials_per_object: many\n", 5, "'many'"},
      {good_ + "seed: -1\n", 5, "'seed'"},
      {good_ + "trial_limit_s: nan\n", 5, "'trial_limit_s'"},
      {good_ + "arrangement: piled\n", 5, "single"},
      {good_ + "reference: none.csv\n", 5, "none.csv"},
      {good_ + "object_folder: ../scenes/table.xml\n", 5, "'object_folder'"},
      {good_ + "physics: 3\n", 5, "'physics'"},
      {good_ + "physics:\n  timestep_ms: 100\n", 6, "from 0.1 to 4"},
      {good_ + "physics:\n  timestep: 1\n", 6, "nearest valid key: 'timestep_ms'"},
      {good_ + "hand:\n  initial_force_n: 80\n  max_force_n: 60\n", 7, "'max_force_n'"},
      {good_ + "perception:\n  segmentation: magic\n", 6, "mesh, region_growing"},
      {good_ + "name: twice\n", 5, "twice"},
      {"scene: ../scenes/table.xml\nsensor: ../models/sensor.yaml\nobjects: [mug]\n", 1,
       "'name': is missing"},
      {"name: a/b\nscene: ../scenes/table.xml\nsensor: ../models/sensor.yaml\nobjects: [mug]\n", 1,
       "'a/b'"},
      {"name: demo\nscene: ../scenes/tabel.xml\nsensor: ../models/sensor.yaml\nobjects: [mug]\n", 2,
       "'../scenes/tabel.xml'"},
      {"name: demo\nscene: ../scenes/table.xml\nsensor: ../models/sensor.yaml\nobjects: mug\n", 4,
       "must be a list"},
      {"name: demo\nscene: ../scenes/table.xml\nsensor: ../models/sensor.yaml\nobjects: []\n", 4,
       "must be a list"},
      {"name: demo\nscene: ../scenes/table.xml\nsensor: ../models/sensor.yaml\nobjects: [mog]\n", 4,
       "nearest: 'mug'"},
      {"name: demo\nscene: ../scenes/table.xml\nsensor: ../models/sensor.yaml\n"
       "objects: [mug, box, mug]\n",
       4, "'mug' twice"},
  };
  for (const Case& c : cases) {
    EXPECT_THAT(ErrorOf(c.text), AllOf(StartsWith((folder_ / "experiments/e.yaml").string() + ":" +
                                                  std::to_string(c.line) + ": "),
                                       HasSubstr(c.says)))
        << c.text;
  }
}

TEST_F(ExperimentFileTest, AMissingObjectFolderIsNamed) {
  std::filesystem::remove_all(folder_ / "models/objects");
  EXPECT_THAT(ErrorOf(good_), HasSubstr((folder_ / "models/objects").string()));
}

TEST_F(ExperimentFileTest, AMissingFileIsNamed) {
  EXPECT_THROW(ReadExperiment(folder_ / "experiments/none.yaml"), core::InputError);
  EXPECT_THROW(ReadExperiment(folder_.path()), core::InputError);
}

TEST_F(ExperimentFileTest, TheExperimentHashLeavesOutSeedAndNumberOfTrialsAlone) {
  const std::string hash = ExperimentHash(ReadExperiment(Write(good_)));
  EXPECT_EQ(ExperimentHash(ReadExperiment(Write(good_ + "seed: 5\ntrials_per_object: 2\n"))), hash);
  EXPECT_NE(ExperimentHash(ReadExperiment(Write(good_ + "most_plans: 5\n"))), hash);
  EXPECT_NE(ExperimentHash(ReadExperiment(Write(good_ + "physics: {timestep_ms: 1}\n"))), hash);
}

TEST_F(ExperimentFileTest, TheSceneHashFollowsEveryFileThatTheSceneRefersTo) {
  const Experiment e = ReadExperiment(Write(good_));
  std::string last = SceneHash(e);
  EXPECT_EQ(SceneHash(e), last);
  for (const char* file : {"scenes/table.xml", "models/arm.xml", "models/arm.stl",
                           "models/sensor.yaml", "models/objects/mug/mug.xml"}) {
    folder_.Write(file, core::ReadFile(folder_ / file) + " ");
    const std::string now = SceneHash(e);
    EXPECT_NE(now, last) << file;
    last = now;
  }
}

TEST_F(ExperimentFileTest, TheSceneHashIsTheSameInAnotherFolder) {
  const std::string hash = SceneHash(ReadExperiment(Write(good_)));
  const TempFolder other;
  std::filesystem::copy(folder_.path(), other.path(), std::filesystem::copy_options::recursive);
  EXPECT_EQ(SceneHash(ReadExperiment(other / "experiments/e.yaml")), hash);
}

}  // namespace
}  // namespace rangegrasp::experiment
