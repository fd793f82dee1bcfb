// Whole runs with detectors that are separate programs.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/process/program.h"
#include "base/words.h"
#include "cli/command.h"
#include "experiment/store.h"

namespace rangegrasp {
namespace {

using experiment::Store;
using nlohmann::json;
using testing::HasSubstr;
using testing_support::Command;
using testing_support::Ran;
using testing_support::RunProgram;

const std::string kExperiment = RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml";
const std::string kPythonExample = RANGEGRASP_SOURCE_DIR "/examples/detectors/antipodal.py";

class OutsideRun : public testing::Test {
 protected:
  std::string Folder(const std::string& name) const { return (folder_ / name).string(); }
  std::vector<std::string> Arguments(const std::string& name, const json& command,
                                     const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {
        "run",       kExperiment,
        "--objects", "spread,salt_cuboid",
        "--trials",  "2",
        "--out",     Folder(name),
        "--set",     "detector={command: " + command.dump() + "}"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  std::vector<std::string> Rows(const std::string& name) const {
    std::vector<std::string> rows;
    for (auto record : Store::Open(Folder(name)).ReadAll()) {
      record.result.seconds.clear();
      rows.push_back(ToJson(record));
    }
    return rows;
  }

  testing_support::TempFolder folder_;
};

TEST_F(OutsideRun, TheExampleInCppDeliversAndItsBytesDoNotDependOnTheWorkers) {
  for (const char* jobs : {"1", "2"}) {
    const Ran ran = RunProgram(Arguments(jobs, {RANGEGRASP_FROM_ABOVE}, {"--jobs", jobs}));
    ASSERT_EQ(ran.code, 0) << ran.err;
  }
  EXPECT_EQ(Rows("1"), Rows("2"));
  int delivered = 0;
  for (const auto& record : Store::Open(Folder("1")).ReadAll()) {
    EXPECT_NE(record.result.outcome, "detector_failed") << record.result.detail;
    delivered += record.result.outcome == "delivered" ? 1 : 0;
  }
  EXPECT_GT(delivered, 0);
  const Ran replay = RunProgram({"trial", Folder("1"), "spread-0001", "--run-detector"});
  EXPECT_EQ(replay.code, 0) << replay.err;
  EXPECT_THAT(replay.err, testing::Not(HasSubstr("differs")));
  const Ran compare = RunProgram({"compare", Folder("1"), Folder("2")});
  EXPECT_THAT(compare.out, HasSubstr("same outcome 4"));
}

TEST_F(OutsideRun, TheExampleInPythonIsUnderstood) {
  const std::string python = std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") == 0
                                 ? "/usr/bin/python3"
                                 : "python3";
  if (std::system((python + " -c 'import numpy' 2>/dev/null").c_str()) != 0) {
    GTEST_SKIP() << "python3 has no numpy here (Debian package python3-numpy)";
  }
  const Ran ran = RunProgram({"check", "--detector", python + " " + kPythonExample});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("grasps in the answer; 1 object; 200 grasps of the first"));
  EXPECT_THAT(ran.out, HasSubstr("the first object is the target"));
  if (!process::WhyNoSandbox()) {
    EXPECT_THAT(ran.out, HasSubstr("the same answer"));
  }
}

TEST_F(OutsideRun, ACheckOfADetectorRefusesTheOptionsOfAFile) {
  for (const char* option : {"--json", "--quick", "--fix", "--as=scene"}) {
    const Ran ran = RunProgram({"check", "--detector", "/bin/false", option});
    EXPECT_EQ(ran.code, 2) << option;
    EXPECT_EQ(ran.out, "") << option;
    EXPECT_THAT(ran.err, HasSubstr(base::Split(option, '=').front())) << option;
    EXPECT_THAT(ran.err, HasSubstr("excludes")) << option;
  }
}

TEST_F(OutsideRun, ADetectorThatAlwaysFailsFailsTheRunButStaysInTheDenominators) {
  const Ran ran = RunProgram(Arguments("failed", {"sh", "-c", "echo oh no >&2; exit 3"}));
  EXPECT_EQ(ran.code, 1) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("all cases ended in detector_failed"));
  EXPECT_THAT(ran.err, HasSubstr("oh no"));
  const Ran table = RunProgram({"table", Folder("failed"), "--json"});
  const json row = json::parse(table.out)["rows"][0];
  EXPECT_EQ(row["trials"], 2);
  EXPECT_EQ(row["detected"], 0);
  EXPECT_EQ(row["outcomes"]["detector_failed"], 2);
  for (const auto& record : Store::Open(Folder("failed")).ReadAll()) {
    EXPECT_EQ(record.result.detail, "ended with code 3 without an answer; stderr: oh no");
  }
}

TEST_F(OutsideRun, AKilledRunLeavesNoDetectorBehind) {
  const std::string pids = Folder("pids");
  Command run(Arguments("killed", {"sh", "-c", "sh -c 'echo $$ >> " + pids + "; sleep 1000'"},
                        {"--jobs", "1"}));
  const base::Stopwatch watch;
  pid_t pid = 0;
  while (pid <= 0 && watch.Seconds() < 60.0) {
    std::ifstream(pids) >> pid;
    usleep(10'000);
  }
  ASSERT_GT(pid, 0) << run.Err();
  ASSERT_EQ(kill(pid, 0), 0);
  run.Kill();
  while (kill(pid, 0) == 0 && watch.Seconds() < 70.0) usleep(10'000);
  EXPECT_NE(kill(pid, 0), 0);
}

// Results from someone else, with a detector command that shows whether it was started.
TEST_F(OutsideRun, AProgramThatResultsNameIsStartedOnlyWithTheOption) {
  const auto trace = Folder("started");
  const json command = {"sh", "-c", "echo >" + trace + "; printf '\033[2J'; exit 3"};
  ASSERT_EQ(RunProgram(Arguments("theirs", command)).code, 1);  // it never answers
  ASSERT_TRUE(std::filesystem::remove(trace));
  const std::string theirs = Folder("theirs");
  const std::vector<std::vector<std::string>> commands = {
      {"trial", theirs, "spread-0001"},
      {"export", theirs, "--clouds", "-o", Folder("set")},
      {"report", theirs, "-o", Folder("pages")}};
  for (auto words : commands) {
    const Ran refused = RunProgram(words);
    EXPECT_EQ(refused.code, 2) << words.front();
    for (const std::string& said :
         {theirs, std::string(R"(["sh", "-c", "echo >)"), std::string("--run-detector")}) {
      EXPECT_THAT(refused.err, HasSubstr(said));
    }
    EXPECT_THAT(refused.err, testing::Not(HasSubstr("\033")));
    EXPECT_FALSE(std::filesystem::exists(trace)) << words.front();
    EXPECT_FALSE(std::filesystem::exists(words.back())) << words.front() << " wrote something";
    words.emplace_back("--run-detector");
    EXPECT_EQ(RunProgram(words).code, 0) << words.front();
    EXPECT_TRUE(std::filesystem::remove(trace)) << words.front();
  }
  EXPECT_EQ(RunProgram({"report", theirs, "--views", "none"}).code, 0);
  EXPECT_FALSE(std::filesystem::exists(trace));
}

TEST_F(OutsideRun, InTheSandboxResultsAreOutOfSight) {
  if (const auto why = process::WhyNoSandbox()) GTEST_SKIP() << "no sandbox here: " << *why;
  // The results are next to the program, where they are visible unless the sandbox hides them.
  const std::filesystem::path beside = RANGEGRASP_FROM_ABOVE;
  const auto script = beside.parent_path() / "look_for_results.sh";
  const auto out = beside.parent_path() / "results_of_a_test";
  std::ofstream(script) << "ls " << out.string() << "/results.sqlite >&2; exit 1\n";
  for (const std::string sandbox : {"true", "false"}) {
    auto arguments = Arguments("", {"sh", script.string()},
                               {"--set", "detector.sandbox=" + sandbox, "--overwrite"});
    *(std::find(arguments.begin(), arguments.end(), "--out") + 1) = out.string();
    const Ran ran = RunProgram(arguments);
    ASSERT_EQ(ran.code, 1) << ran.err;  // the detector always fails
    const auto detail = Store::Open(out.string()).ReadAll().front().result.detail;
    const bool seen = detail.find("No such file") == std::string::npos;
    EXPECT_EQ(seen, sandbox == "false") << detail;
  }
  std::filesystem::remove_all(out);
  std::filesystem::remove(script);
}

TEST_F(OutsideRun, WithoutBubblewrapARunThatAsksForASandboxDoesNotBegin) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/no/such/folder", 1);
  const Ran ran =
      RunProgram(Arguments("boxed", {"/bin/sh", "-c", "true"}, {"--set", "detector.sandbox=true"}));
  setenv("PATH", path.c_str(), 1);
  testing_support::ExpectRefusal(ran, "apt-get install bubblewrap");
  EXPECT_THAT(ran.err, HasSubstr("sandbox: false"));
  EXPECT_FALSE(std::filesystem::exists(Folder("boxed")));
}

}  // namespace
}  // namespace rangegrasp
