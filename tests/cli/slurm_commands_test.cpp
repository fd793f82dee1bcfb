// `submit` with Slurm's commands replaced by scripts of the test; tests/slurm has a real Slurm.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/file.h"
#include "cli/command.h"
#include "temp_folder.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing_support::ExpectRefusal;
using testing_support::Ran;
using testing_support::RunProgram;
using testing_support::TempFolder;

class SubmitTest : public testing::Test {
 protected:
  void SetUp() override {
    setenv("PATH", ((folder_ / "bin").string() + ":" + path_).c_str(), 1);
    SetCommand("sbatch", "exit 1");
    SetCommand("squeue", "exit 0");
  }
  void TearDown() override { setenv("PATH", path_.c_str(), 1); }

  void SetCommand(const std::string& name, const std::string& does) const {
    const auto file = folder_.Write("bin/" + name, "#!/bin/sh\n" + does + "\n");
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  Ran Submit(const std::string& tasks) const {
    return RunProgram({"submit", RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", "--tasks",
                       tasks, "--out", out_.string()});
  }
  std::string Submission() const { return base::ReadFile(out_ / "slurm/submission.json"); }

  const std::string path_ = std::getenv("PATH");
  const TempFolder folder_;
  const std::filesystem::path out_ = folder_ / "out";
};

TEST_F(SubmitTest, OfWhichNothingWasSubmittedCanBeReplaced) {
  SetCommand("squeue", "exit 1");
  EXPECT_THAT(Submit("4").err, HasSubstr("squeue ended with code 1: is Slurm running"));
  EXPECT_FALSE(std::filesystem::exists(out_ / "slurm"));
  SetCommand("squeue", "exit 0");
  EXPECT_THAT(Submit("4").err, HasSubstr("sbatch ended with code 1"));
  EXPECT_THAT(Submission(), HasSubstr("\"tasks\": 4"));
  EXPECT_THAT(Submit("3").err, HasSubstr("sbatch ended with code 1"));
  EXPECT_THAT(Submission(), HasSubstr("\"tasks\": 3"));
}

TEST_F(SubmitTest, WhoseShardsMayHaveBegunIsKept) {
  EXPECT_THAT(Submit("4").err, HasSubstr("sbatch ended with code 1"));
  SetCommand("squeue", "echo 17 1 PENDING");
  ExpectRefusal(Submit("3"), "--tasks 4; the same command");
  SetCommand("squeue", "exit 0");
  base::WriteFile(out_ / "slurm/shard-2.log", "");
  ExpectRefusal(Submit("3"), "--tasks 4; the same command");
  std::filesystem::remove(out_ / "slurm/shard-2.log");
  base::WriteFile(out_ / "shards/2/results.sqlite", "");
  ExpectRefusal(Submit("3"), "--tasks 4; the same command");
  EXPECT_THAT(Submission(), HasSubstr("\"tasks\": 4"));
}

}  // namespace
}  // namespace rangegrasp
