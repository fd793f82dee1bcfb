#include "base/additions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "base/yaml_map.h"
#include "trial/options.h"

namespace rangegrasp::trial {
namespace {

const std::filesystem::path kAdditionsSource = RANGEGRASP_SOURCE_DIR;

// Every switch of every stage, by its key.
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
  return on;
}

/// A shipped file, with the keys of every kind of experiment read.
base::YamlMap MapOf(const std::string& file, const std::vector<std::string>& settings = {}) {
  auto map = base::YamlMap::FromFile(kAdditionsSource / "experiments" / file, settings);
  std::string name;
  std::uint64_t seed = 0;
  map.Read("name", name);
  map.Read("seed", seed);
  return map;
}

Options Read(const std::string& file, const std::vector<std::string>& settings = {}) {
  auto map = MapOf(file, settings);
  return ReadOptions(map);
}

TEST(Additions, AreAllOnInTheImprovedMethodAndAllOffInThePublishedOne) {
  const auto improved = SwitchesOf(Read("laser_single.yaml"));
  const auto published = SwitchesOf(Read("laser_single_as_published.yaml"));
  EXPECT_GE(improved.size(), 25u);  // not an empty table
  for (const auto& [key, on] : improved) EXPECT_TRUE(on) << key;
  for (const auto& [key, on] : published) EXPECT_FALSE(on) << key;
}

// Every key of the file with the value that it has where the file is silent, after the method.
std::map<std::string, std::string> DefaultsOf(const std::string& file) {
  auto map = MapOf(file);
  ReadOptions(map);
  std::map<std::string, std::string> defaults;
  for (const base::KeyDoc& key : map.Keys()) defaults[key.path] = key.default_value;
  return defaults;
}

// All keys are compared, not the switches alone. What differs beside the switches is listed here,
// and in docs/results.md.
TEST(Additions, AndThreeKeysAreAllThatTheTwoMethodsDiffer) {
  const auto improved = DefaultsOf("laser_single.yaml");
  const auto published = DefaultsOf("laser_single_as_published.yaml");
  ASSERT_EQ(improved.size(), published.size());
  EXPECT_GE(improved.size(), 80u);
  std::set<std::string> differ,
      listed = {"perception.segmentation", "hand.firm_from_deg", "max_approaches"};
  for (const AdditionKey& key : AdditionKeys()) listed.insert(key.path);
  for (const auto& [path, value] : improved) {
    if (published.at(path) != value) differ.insert(path);
  }
  EXPECT_EQ(differ, listed);
}

TEST(Additions, AKeyOfItsOwnWinsOverTheMethod) {
  for (const AdditionKey& key : AdditionKeys()) {
    const auto on = SwitchesOf(Read("laser_single_as_published.yaml", {key.path + "=true"}));
    const auto off = SwitchesOf(Read("laser_single.yaml", {key.path + "=false"}));
    for (const auto& [path, value] : on) EXPECT_EQ(value, path == key.path) << path;
    for (const auto& [path, value] : off) EXPECT_EQ(value, path != key.path) << path;
  }
}

TEST(Additions, EveryOneHasAKeyThatSaysWhatItDoes) {
  std::set<std::string> paths;
  for (const AdditionKey& key : AdditionKeys()) {
    EXPECT_TRUE(paths.insert(key.path).second) << key.path;
    EXPECT_GT(key.doc.size(), 10u) << key.path;
  }
  EXPECT_EQ(paths.size(), SwitchesOf(Options{}).size());
}

// What the table does not list does not compile; here the rule behind that on small structs.
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
