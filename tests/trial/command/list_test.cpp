#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "cli/command.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing_support::RunProgram;

TEST(List, NamesEveryKindOfExperiment) {
  const auto ran = Succeeded(RunProgram({"list"}));
  for (const char* kind : {"grasping", "seam", "parts"}) EXPECT_THAT(ran.out, HasSubstr(kind));
  EXPECT_EQ(RunProgram({"list", "nothing"}).code, 2);
}

TEST(List, TellsWhatThereIsByItsWord) {
  const std::string overview = RunProgram({"list"}).out;
  for (const auto& [word, one] :
       std::map<std::string, std::string>{{"kinds", "grasping"},
                                          {"experiments", "laser_single "},
                                          {"objects", "Coffee Cup"},
                                          {"surfaces", "painted_metal"},
                                          {"scenes", "tabletop_box"},
                                          {"sensors", "stereo_camera"},
                                          {"additions", "perception.robust_table"}}) {
    const auto ran = Succeeded(RunProgram({"list", word}));
    EXPECT_THAT(ran.out, HasSubstr(one)) << word;
    EXPECT_EQ(overview.find(ran.out) != std::string::npos, word != "additions") << word;
  }
}

TEST(List, HasTheSameAsJson) {
  const auto all = nlohmann::json::parse(RunProgram({"list", "--json"}).out);
  EXPECT_TRUE(all.contains("kinds"));
  EXPECT_FALSE(all.contains("keys"));  // as in the overview
  const auto objects = nlohmann::json::parse(RunProgram({"list", "objects", "--json"}).out);
  EXPECT_EQ(objects["objects"], all["objects"]);
  EXPECT_THAT(objects["objects"].dump(), HasSubstr(R"({"name":"coffee_cup","text":"Coffee Cup"})"));
  const auto keys = nlohmann::json::parse(RunProgram({"list", "keys", "--json"}).out)["keys"];
  const auto margin = std::ranges::find_if(keys, [](const auto& key) {
    return key["name"] == "workspace_margin_mm" && key["task"] == "grasping";
  });
  ASSERT_NE(margin, keys.end());
  EXPECT_EQ((*margin)["type"], "number");
  EXPECT_TRUE(margin->contains("default") && margin->contains("text"));
  const auto formats = nlohmann::json::parse(RunProgram({"list", "formats", "--json"}).out);
  EXPECT_GT(formats["formats"].size(), 5u);
}

TEST(List, ThePageOfKeysIsTheOneInTheDocuments) {
  const auto ran = Succeeded(RunProgram({"list", "keys"}));
  EXPECT_EQ(base::ReadFile(RANGEGRASP_SOURCE_DIR "/docs/experiment-file.md"), ran.out)
      << "make it anew: scripts/rangegrasp list keys > docs/experiment-file.md";
  // Every key has a description.
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("` |  |")));
}

TEST(List, ThePageOfFormatsIsTheOneInTheDocuments) {
  const auto ran = Succeeded(RunProgram({"list", "formats"}));
  EXPECT_EQ(base::ReadFile(RANGEGRASP_SOURCE_DIR "/docs/profile-formats.md"), ran.out)
      << "make it anew: scripts/rangegrasp list formats > docs/profile-formats.md";
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("` |  |")));
}

}  // namespace
}  // namespace rangegrasp
