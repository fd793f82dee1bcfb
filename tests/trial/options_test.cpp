#include "trial/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"
#include "base/yaml_map.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::trial {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using testing_support::TempFolder;

const std::filesystem::path kOptionsSource = RANGEGRASP_SOURCE_DIR;

// The options of a file; the common keys, which the experiment engine reads, are read first.
Options OptionsRead(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  std::string text;
  std::uint64_t seed = 0;
  double limit_s = 0.0;
  map.Read("task", text);
  map.Read("name", text);
  map.Read("seed", seed);
  map.Read("trial_limit_s", limit_s, 0.0, 1e9);
  const Options options = ReadOptions(map, seed);
  EXPECT_EQ(options.seed, seed);
  CheckObjects(map, options);
  return options;
}

TEST(ReadOptions, ReadsEveryShippedExperiment) {
  int read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kOptionsSource / "experiments")) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("laser_") && !name.starts_with("stereo_")) continue;
    const Options o = OptionsRead(entry.path());
    EXPECT_FALSE(o.objects.empty()) << name;
    ++read;
  }
  EXPECT_GE(read, 6);
}

TEST(ReadOptions, Table52HasTwelveObjectsOfTenTrials) {
  const Options o = OptionsRead(kOptionsSource / "experiments/laser_single.yaml");
  EXPECT_EQ(o.objects.size(), 12u);
  EXPECT_EQ(o.trials_per_object, 10);
  EXPECT_EQ(o.arranger, "single");
  EXPECT_EQ(o.scene.filename(), "tabletop.xml");
  EXPECT_TRUE(std::filesystem::exists(o.reference));
}

TEST(ReadOptions, EveryKeyIsDocumented) {
  auto map = base::YamlMap::ForDocumentation();
  ReadOptions(map, 1);
  EXPECT_GT(map.Keys().size(), 40u);
  for (const auto& key : map.Keys()) EXPECT_FALSE(key.doc.empty()) << key.path;
}

// A small separate project: experiments/e.yaml with a scene, a sensor and two objects.
class OptionsTest : public testing::Test {
 protected:
  OptionsTest() {
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
    SCOPED_TRACE(text);
    return testing_support::ErrorOf([&] { OptionsRead(Write(text)); });
  }

  TempFolder folder_;
  const std::string no_objects_ =
      "name: demo\n"
      "scene: ../scenes/table.xml\n"
      "sensor: ../models/sensor.yaml\n";
  const std::string good_ = no_objects_ + "objects: [mug, box]\n";
};

TEST_F(OptionsTest, WhatIsNotGivenKeepsTheDefaultOfItsStruct) {
  const Options e = OptionsRead(Write(good_));
  EXPECT_EQ(e.scene, folder_ / "scenes/table.xml");
  EXPECT_EQ(e.object_folders.front(), folder_ / "models/objects");
  EXPECT_EQ(e.trials_per_object, Options{}.trials_per_object);
  EXPECT_EQ(e.physics.timestep_s, sim::PhysicsOptions{}.timestep_s);
  EXPECT_EQ(e.perception.segment.method, perception::SegmentOptions{}.method);
  EXPECT_TRUE(e.reference.empty());
}

TEST_F(OptionsTest, EveryKeyArrivesInItsOptionInSiUnits) {
  const Options e = OptionsRead(
      Write(good_ +
            "trials_per_object: 3\nseed: 7\ntrial_limit_s: 90\nmax_plans: 5\nmin_tipping_deg: 12\n"
            "workspace_margin_mm: 200\n"
            "physics: {timestep_ms: 1, friction: high, "
            "glove_friction: 0.4}\n"
            "hand: {initial_force_n: 30, max_force_n: 60, slip_control: false}\n"
            "perception: {segmentation: region_growing, filter: false, smooth: false, "
            "normal_radius_mm: 6, plane_distance_mm: 3, table_clearance_mm: 5}\n"
            "grasp: {preshape: false, pitches: false, table_clearance_mm: 6}\n"
            "planning: {approach_mm: 150, lift_mm: 250, brushing: false}\n"));
  EXPECT_EQ(e.trials_per_object, 3);
  EXPECT_EQ(e.max_plans, 5);
  EXPECT_DOUBLE_EQ(e.workspace_margin_m, 0.2);
  EXPECT_NEAR(e.min_tipping_rad, 0.20943951, 1e-8);
  EXPECT_DOUBLE_EQ(e.physics.timestep_s, 0.001);
  EXPECT_EQ(e.physics.friction, sim::FrictionChoice::kHigh);
  EXPECT_EQ(e.physics.glove_friction, 0.4);
  EXPECT_EQ(e.hand.initial_force_N, 30.0);
  EXPECT_EQ(e.hand.max_force_N, 60.0);
  EXPECT_FALSE(e.hand.slip_control);
  EXPECT_EQ(e.perception.segment.method, perception::SegmentMethod::kRegionGrowing);
  EXPECT_FALSE(e.perception.preprocess.filter);
  EXPECT_FALSE(e.perception.preprocess.smooth);
  EXPECT_DOUBLE_EQ(e.perception.preprocess.normal_radius_m, 0.006);
  EXPECT_DOUBLE_EQ(e.perception.preprocess.plane_distance_m, 0.003);
  EXPECT_DOUBLE_EQ(e.perception.preprocess.table_clearance_m, 0.005);
  EXPECT_FALSE(e.grasp.preshape);
  EXPECT_FALSE(e.grasp.pitches);
  EXPECT_DOUBLE_EQ(e.grasp.table_clearance_m, 0.006);
  EXPECT_DOUBLE_EQ(e.planning.approach_m, 0.15);
  EXPECT_DOUBLE_EQ(e.planning.lift_m, 0.25);
  EXPECT_FALSE(e.brushing);
}

TEST_F(OptionsTest, WhatIsWrongIsNamedWithFileLineAndKey) {
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
      {good_ + "arrangement: piled\n", 5, "single"},
      {good_ + "reference: none.csv\n", 5, "none.csv"},
      {good_ + "physics: 3\n", 5, "'physics'"},
      {good_ + "physics:\n  timestep_ms: 100\n", 6, "from 0.1 to 4"},
      {good_ + "physics:\n  timestep: 1\n", 6, "nearest valid key: 'timestep_ms'"},
      {good_ + "hand:\n  initial_force_n: 80\n  max_force_n: 60\n", 7, "'max_force_n'"},
      {good_ + "perception:\n  segmentation: magic\n", 6, "mesh, region_growing"},
      {good_ + "grasp: {take: handle, approach: sides}\n", 5, "`take: handle` determines"},
      {good_ + "detector: {command: [cat]}\ngrasp: {approach: sides}\n", 6,
       "detector: dissertation"},
      {good_ + "detector: {command: [cat]}\ngrasp: {take: handle}\n", 6, "detector: dissertation"},
      {good_ + "name: twice\n", 5, "twice"},
      {"name: demo\nsensor: ../models/sensor.yaml\nobjects: [mug]\n", 1, "'scene': is missing"},
      {"name: demo\nscene: ../scenes/tabel.xml\nsensor: ../models/sensor.yaml\nobjects: [mug]\n", 2,
       "'../scenes/tabel.xml'"},
      {no_objects_ + "objects: mug\n", 4, "must be a list"},
      {no_objects_ + "objects: []\n", 4, "is an empty list"},
      {good_ + "object_folders: []\n", 5, "is an empty list"},
      {good_ + "object_folders: [../mine]\n", 5, "no folder '../mine'"},
      {no_objects_ + "objects: [mog]\n", 4, "nearest: 'mug'"},
      {good_ + "clutter:\n  always: [mug]\n  others: [box, mog]\n", 7,
       "key 'others': no object 'mog'"},
      {good_ + "clutter:\n  always: [mog]\n", 6, "key 'always': no object 'mog'"},
      {no_objects_ + "objects: [mug, box, mug]\n", 4, "'mug' twice"},
  };
  for (const Case& c : cases) {
    EXPECT_THAT(ErrorOf(c.text), AllOf(StartsWith((folder_ / "experiments/e.yaml").string() + ":" +
                                                  std::to_string(c.line) + ": "),
                                       HasSubstr(c.says)))
        << c.text;
  }
}

TEST_F(OptionsTest, ObjectsComeFromSeveralFoldersAndShippedOnesByName) {
  folder_.Write("mine/mug/mug.xml", "my mug");
  folder_.Write("yours/duck/duck.xml", "duck");
  folder_.Write("yours/mug/mug.xml", "your mug");
  const std::string both = no_objects_ + "object_folders: [../mine, ../yours]\n";
  const Options o = OptionsRead(Write(both + "objects: [mug, duck, box]\n"));
  EXPECT_EQ(ObjectModelOf(o, "mug").mjcf, folder_ / "mine/mug/mug.xml");
  EXPECT_EQ(ObjectModelOf(o, "duck").mjcf, folder_ / "yours/duck/duck.xml");
  EXPECT_EQ(ObjectModelOf(o, "box").mjcf, folder_ / "models/objects/box/box.xml");
  const std::string error = ErrorOf(both + "objects: [duk]\n");
  EXPECT_THAT(error, HasSubstr("nearest: 'duck'"));
  EXPECT_THAT(error, HasSubstr("no duk/duk.xml in " + (folder_ / "mine").string() + ", " +
                               (folder_ / "yours").string()));
}

// Without a models/objects folder next to it, the experiment finds the program's objects.
TEST_F(OptionsTest, ShippedObjectsAreFoundFromElsewhere) {
  std::filesystem::rename(folder_ / "models/objects", folder_ / "mine");
  const Options o =
      OptionsRead(Write(no_objects_ + "object_folders: [../mine]\nobjects: [mug, salt_cuboid]\n"));
  EXPECT_EQ(ObjectModelOf(o, "salt_cuboid").mjcf,
            kOptionsSource / "models/objects/salt_cuboid/salt_cuboid.xml");
}

TEST_F(OptionsTest, TheSceneHashFollowsSurfaces) {
  const Options e = OptionsRead(Write(good_));
  const std::string without = SceneHash(e);
  folder_.Write("models/objects/surfaces.yaml", "rubber: {}");
  EXPECT_NE(SceneHash(e), without);
}

TEST_F(OptionsTest, AMissingFileIsNamed) {
  EXPECT_THROW(OptionsRead(folder_ / "experiments/none.yaml"), base::InputError);
  EXPECT_THROW(OptionsRead(folder_.path()), base::InputError);
}

TEST_F(OptionsTest, TheSceneHashFollowsEveryFileThatTheSceneRefersTo) {
  const Options e = OptionsRead(Write(good_));
  std::string last = SceneHash(e);
  EXPECT_EQ(SceneHash(e), last);
  for (const char* file : {"scenes/table.xml", "models/arm.xml", "models/arm.stl",
                           "models/sensor.yaml", "models/objects/mug/mug.xml"}) {
    folder_.Write(file, base::ReadFile(folder_ / file) + " ");
    const std::string now = SceneHash(e);
    EXPECT_NE(now, last) << file;
    last = now;
  }
}

// MJCF names files relative to the folders of its <compiler>, also of a file that includes it.
TEST_F(OptionsTest, TheSceneHashFollowsFilesInFoldersOfTheCompilerInEitherQuotes) {
  folder_.Write("scenes/table.xml",
                "<mujoco><compiler meshdir=\"meshes\" texturedir='textures'/>"
                "<mesh file=\"table.stl\"/><mesh file = 'leg.stl'/><texture file='wood.png'/>"
                "<include file='parts/lamp.xml'/></mujoco>");
  folder_.Write("scenes/parts/lamp.xml", "<mujoco><mesh file=\"lamp.stl\"/></mujoco>");
  const std::vector<std::string> files = {"scenes/meshes/table.stl", "scenes/meshes/leg.stl",
                                          "scenes/textures/wood.png", "scenes/parts/lamp.xml",
                                          "scenes/meshes/lamp.stl"};
  for (const std::string& file : files) {
    if (!file.ends_with(".xml")) folder_.Write(file, file);
  }
  const Options e = OptionsRead(Write(good_));
  std::string last = SceneHash(e);
  for (const std::string& file : files) {
    folder_.Write(file, base::ReadFile(folder_ / file) + " ");
    const std::string now = SceneHash(e);
    EXPECT_NE(now, last) << file;
    last = now;
  }
}

TEST_F(OptionsTest, TheSceneHashIsTheSameFromARelativePath) {
  const auto file = Write(good_);
  EXPECT_EQ(SceneHash(OptionsRead(std::filesystem::relative(file))), SceneHash(OptionsRead(file)));
}

TEST_F(OptionsTest, TheSceneHashIsTheSameInAnotherFolder) {
  const std::string hash = SceneHash(OptionsRead(Write(good_)));
  const TempFolder other;
  std::filesystem::copy(folder_.path(), other.path(), std::filesystem::copy_options::recursive);
  EXPECT_EQ(SceneHash(OptionsRead(other / "experiments/e.yaml")), hash);
}

// All switches of all stages, by key.
std::map<std::string, bool> SwitchesOf(const Options& o) {
  std::map<std::string, bool> on;
  const auto add = [&on](const std::string& prefix, const auto& switches) {
    using Switches = std::remove_cvref_t<decltype(switches)>;
    for (const auto& row : base::AdditionsTable<Switches>()) {
      on[prefix + std::string(row.key)] = switches.*row.on;
    }
  };
  add("perception.", static_cast<const perception::PreprocessAdditions&>(o.perception.preprocess));
  add("perception.", static_cast<const perception::SegmentAdditions&>(o.perception.segment));
  add("perception.", static_cast<const perception::FeatureAdditions&>(o.perception.features));
  add("grasp.", static_cast<const grasp::GraspAdditions&>(o.grasp));
  add("planning.", static_cast<const grasp::ObstacleAdditions&>(o.obstacles));
  add("planning.", static_cast<const grasp::MoverAdditions&>(o));
  return on;
}

/// A shipped file, with the keys common to all experiments already read.
base::YamlMap MapOf(const std::string& file, const std::vector<std::string>& settings = {}) {
  auto map = base::YamlMap::FromFile(kOptionsSource / "experiments" / file, settings);
  std::string name;
  std::uint64_t seed = 0;
  map.Read("name", name);
  map.Read("seed", seed);
  return map;
}

Options Read(const std::string& file, const std::vector<std::string>& settings = {}) {
  auto map = MapOf(file, settings);
  return ReadOptions(map, 1);
}

TEST(Additions, AreAllOnInTheImprovedMethodAndAllOffInThePublishedOne) {
  const auto improved = SwitchesOf(Read("laser_single.yaml"));
  const auto published = SwitchesOf(Read("laser_single_as_published.yaml"));
  EXPECT_GE(improved.size(), 25u);  // not an empty table
  for (const auto& [key, on] : improved) EXPECT_TRUE(on) << key;
  for (const auto& [key, on] : published) EXPECT_FALSE(on) << key;
}

// Every key of the file with its default value for the file's method.
std::map<std::string, std::string> DefaultsOf(const std::string& file) {
  auto map = MapOf(file);
  ReadOptions(map, 1);
  std::map<std::string, std::string> defaults;
  for (const base::KeyDoc& key : map.Keys()) defaults[key.path] = key.default_value;
  return defaults;
}

// All keys are compared, not only the switches.
TEST(Additions, AreAllThatTheTwoMethodsDiffer) {
  const auto improved = DefaultsOf("laser_single.yaml");
  const auto published = DefaultsOf("laser_single_as_published.yaml");
  ASSERT_EQ(improved.size(), published.size());
  EXPECT_GE(improved.size(), 80u);
  std::set<std::string> differ, listed;
  for (const auto& difference : MethodDifferences()) {
    EXPECT_TRUE(listed.insert(difference.key).second) << difference.key;
    EXPECT_GT(difference.doc.size(), 10u) << difference.key;
    EXPECT_EQ(improved.at(difference.key), difference.improved) << difference.key;
    EXPECT_EQ(published.at(difference.key), difference.published) << difference.key;
  }
  for (const auto& [path, value] : improved) {
    if (published.at(path) != value) differ.insert(path);
  }
  EXPECT_EQ(differ, listed);
  EXPECT_GE(listed.size(), SwitchesOf(Options{}).size());
}

TEST(Additions, AKeyOfItsOwnWinsOverTheMethod) {
  for (const auto& [key, on] : SwitchesOf(Options{})) {
    const auto one = SwitchesOf(Read("laser_single_as_published.yaml", {key + "=true"}));
    const auto others = SwitchesOf(Read("laser_single.yaml", {key + "=false"}));
    for (const auto& [path, value] : one) EXPECT_EQ(value, path == key) << path;
    for (const auto& [path, value] : others) EXPECT_EQ(value, path != key) << path;
  }
}

// A switch that the table does not list does not compile; this tests that rule on small structs.
struct Listed {
  bool salt = true;
  bool pepper = true;
};
constexpr std::array<base::Addition<Listed>, 2> AdditionsOf(const Listed*) {
  return {{{"salt", &Listed::salt, ""}, {"pepper", &Listed::pepper, ""}}};
}
struct Forgotten {
  bool salt = true;
  bool pepper = true;
};
constexpr std::array<base::Addition<Forgotten>, 1> AdditionsOf(const Forgotten*) {
  return {{{"salt", &Forgotten::salt, ""}}};
}
struct Twice {
  bool salt = true;
  bool pepper = true;
};
constexpr std::array<base::Addition<Twice>, 2> AdditionsOf(const Twice*) {
  return {{{"salt", &Twice::salt, ""}, {"pepper", &Twice::salt, ""}}};
}
struct Number {
  bool salt = true;
  double pepper_g = 1.0;
};
constexpr std::array<base::Addition<Number>, 1> AdditionsOf(const Number*) {
  return {{{"salt", &Number::salt, ""}}};
}
static_assert(base::AllAdditionsListed<Listed>());
static_assert(!base::AllAdditionsListed<Forgotten>());
static_assert(!base::AllAdditionsListed<Twice>());
static_assert(!base::AllAdditionsListed<Number>());

}  // namespace
}  // namespace rangegrasp::trial
