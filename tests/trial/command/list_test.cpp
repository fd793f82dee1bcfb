#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "base/file.h"
#include "cli/command.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing_support::RunProgram;

TEST(List, NamesEveryKindOfExperiment) {
  const auto ran = RunProgram({"list"});
  EXPECT_EQ(ran.code, 0);
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
    const auto ran = RunProgram({"list", word});
    EXPECT_EQ(ran.code, 0) << ran.err;
    EXPECT_THAT(ran.out, HasSubstr(one)) << word;
    EXPECT_EQ(overview.find(ran.out) != std::string::npos, word != "additions") << word;
  }
}

TEST(List, ThePageOfKeysIsTheOneInTheDocuments) {
  const auto ran = RunProgram({"list", "keys"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_EQ(base::ReadFile(RANGEGRASP_SOURCE_DIR "/docs/experiment-file.md"), ran.out)
      << "make it anew: scripts/rangegrasp list keys > docs/experiment-file.md";
  // Every key says what it means.
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("` |  |")));
}

TEST(List, ThePageOfFormatsIsTheOneInTheDocuments) {
  const auto ran = RunProgram({"list", "formats"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_EQ(base::ReadFile(RANGEGRASP_SOURCE_DIR "/docs/profile-formats.md"), ran.out)
      << "make it anew: scripts/rangegrasp list formats > docs/profile-formats.md";
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("` |  |")));
}

}  // namespace
}  // namespace rangegrasp
