#include "experiment/slurm.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/file.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::experiment {
namespace {

using testing::HasSubstr;
using testing_support::TempFolder;

TEST(ArrayText, JoinsNeighborsToRanges) {
  EXPECT_EQ(ArrayText({1}), "1");
  EXPECT_EQ(ArrayText({1, 2, 3, 4}), "1-4");
  EXPECT_EQ(ArrayText({2, 4, 5, 9, 11, 12}), "2,4-5,9,11-12");
}

TEST(ParseQueue, KnowsTasksAndTheirJobs) {
  const Queue queue = ParseQueue("17 1 RUNNING\n17 3 PENDING\n21 2 CONFIGURING\n22 N/A PENDING\n");
  EXPECT_EQ(queue.state_of_task,
            (std::map<int, std::string>{{1, "RUNNING"}, {2, "CONFIGURING"}, {3, "PENDING"}}));
  EXPECT_EQ(queue.job_ids, (std::vector<std::string>{"17", "21", "22"}));
  EXPECT_TRUE(ParseQueue("").state_of_task.empty());
}

// Checked with the shell itself.
TEST(ShellQuoted, AnyWordStaysOneWordAsItIs) {
  const TempFolder folder;
  const std::string word = "a 'b' \"c\" $HOME `id` \\ ;\n*";
  const std::string file = (folder / "out").string();
  ASSERT_EQ(std::system(("printf %s " + ShellQuoted(word) + " > " + ShellQuoted(file)).c_str()), 0);
  EXPECT_EQ(base::ReadFile(file), word);
}

TEST(Submission, IsFoundAgainInItsFolder) {
  const TempFolder folder;
  const Submission written{"/x/e.yaml", {"--set", "a=b c"}, 7, folder.path()};
  EXPECT_FALSE(HasSubmission(folder.path()));
  WriteSubmission(written);
  const Submission read = ReadSubmission(folder.path());
  EXPECT_EQ(read.experiment, written.experiment);
  EXPECT_EQ(read.run, written.run);
  EXPECT_EQ(read.tasks, 7);
  EXPECT_EQ(read.JobName(), written.JobName());
  base::WriteFile(folder / "slurm/submission.json", "{\"run\": []}");
  EXPECT_THAT(testing_support::MessageOf([&] { ReadSubmission(folder.path()); }),
              HasSubstr("submission.json"));
  for (const auto& [text, said] :
       {std::pair{R"(["--seed", "abc"], "tasks": 2)", "--seed 'abc' must be a whole number"},
        {R"(["--trials", "99999999999999"], "tasks": 2)", "--trials '99999999999999' must be"},
        {R"([], "tasks": 2000000000)", "tasks is 2000000000, but must be from 1 to 1000000"},
        {R"([], "tasks": 4294967298)", "tasks is 4294967298, but"},
        {R"([], "tasks": -5)", "tasks is -5, but"}}) {
    base::WriteFile(folder / "slurm/submission.json",
                    std::string(R"({"experiment": "/x/e.yaml", "run": )") + text + "}");
    EXPECT_THAT(testing_support::MessageOf([&] { ReadSubmission(folder.path()); }),
                testing::AllOf(HasSubstr("submission.json: "), HasSubstr(said)));
  }
  EXPECT_THAT(testing_support::MessageOf([&] { ReadSubmission(folder / "none"); }),
              HasSubstr("nothing was submitted"));
}

}  // namespace
}  // namespace rangegrasp::experiment
