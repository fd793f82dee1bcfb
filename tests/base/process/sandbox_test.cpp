#include "base/process/sandbox.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "base/process/ask.h"
#include "base/process/own_folder.h"
#include "temp_folder.h"

namespace rangegrasp::process {
namespace {

class InTheSandbox : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const auto why = WhyNoSandbox()) GTEST_SKIP() << "no sandbox here: " << *why;
  }
  std::string Try(const std::string& script) {
    Program program;
    program.folder = folder_.path();
    program.command = InSandbox({"/bin/sh", "-c", script}, box_);
    const Reply reply = Ask(program, "");
    return reply.line.value_or("failed: " + reply.failure + ": " + reply.last_words);
  }

  OwnFolder folder_;
  testing_support::TempFolder other_;  // among the temporary ones, as everybody's
  Box box_{folder_.path(), {}, {}};
};

TEST_F(InTheSandbox, AProgramWritesItsOwnFolderOnly) {
  EXPECT_EQ(Try("echo hello > own; cat own"), "hello");
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "own"));
  const auto home = std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "written_by_a_detector";
  for (const std::string& place :
       {home.string(), (other_ / "x").string(), std::string("/tmp/x"), std::string("/var/tmp/x"),
        std::string("/usr/x"), (folder_.path() / "../x").string()}) {
    EXPECT_EQ(Try("(echo x > " + place + ") 2>/dev/null && echo written || echo refused"),
              "refused")
        << place;
    EXPECT_FALSE(std::filesystem::exists(place)) << place;
  }
}

TEST_F(InTheSandbox, ResultsAndTemporaryFilesCannotBeRead) {
  const testing_support::TempFolder results;
  const auto truth = results.Write("results.sqlite", "truth");
  const std::string see = "cat " + truth.string() + " 2>/dev/null || echo nothing";
  EXPECT_EQ(Try(see), "nothing");
  box_.shown = {results.path()};
  EXPECT_EQ(Try(see), "truth");
  box_.hidden = {results.path()};
  EXPECT_EQ(Try(see), "nothing") << "hidden wins over shown";
}

TEST_F(InTheSandbox, AFileIsShownWhereItsFolderIsNot) {
  const auto program = other_.Write("program.sh", "echo shown");
  const auto secret = other_.Write("secret", "hidden");
  box_.hidden = {other_.path()};
  box_.shown = {other_.path(), program};
  EXPECT_EQ(Try("sh " + program.string()), "shown");
  EXPECT_EQ(Try("cat " + secret.string() + " 2>/dev/null || echo nothing"), "nothing");
}

TEST_F(InTheSandbox, ThereIsNoNetworkAndNobodyElse) {
  // Of the loopback device alone, which is down.
  EXPECT_EQ(Try("tail -n +3 /proc/net/dev | cut -d: -f1 | tr -d ' '"), "lo");
  EXPECT_EQ(Try("wc -l < /proc/net/route"), "1") << "the heading";
  // bwrap, which is the first process there, and what the shell starts.
  EXPECT_EQ(Try("ls -d /proc/[0-9]* | head -1"), "/proc/1");
  EXPECT_EQ(Try("kill -0 " + std::to_string(getpid()) + " 2>/dev/null && echo seen || echo not"),
            "not");
  EXPECT_EQ(Try("grep CapEff /proc/self/status | tr -d '\\t'"), "CapEff:0000000000000000");
}

TEST(OwnFolder, GoesWithItsContents) {
  std::filesystem::path path;
  {
    const OwnFolder folder;
    path = folder.path();
    std::ofstream(path / "file") << "x";
    EXPECT_EQ(std::filesystem::status(path).permissions(), std::filesystem::perms::owner_all);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace rangegrasp::process
