#include "robot/mjcf/files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>

#include "base/error.h"
#include "error_of.h"
#include "robot/robot.h"
#include "temp_folder.h"

namespace rangegrasp::mjcf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string ErrorOfFile(const std::filesystem::path& file) {
  return testing_support::ErrorOf([&] { CheckFiles(file); });
}

std::string InWorld(const std::string& elements) {
  return "<mujoco>\n<worldbody>\n" + elements + "\n</worldbody>\n</mujoco>\n";
}

// The engine guards only <include> against this, and overflows its stack.
TEST(CheckFiles, NamesTheLineThatClosesACycle) {
  const testing_support::TempFolder folder;
  const auto own = folder.Write(
      "own.xml", "<mujoco>\n<asset>\n<model name=\"a\" file=\"own.xml\"/></asset></mujoco>");
  EXPECT_THAT(ErrorOfFile(own), StartsWith(own.string() + ":3: <model file=\"own.xml\"> closes"));
  EXPECT_THAT(testing_support::ErrorOf([&] { robot::Robot::Load(own); }), HasSubstr("own.xml:3:"));
  // Through an included file in another folder, whose names are relative to the first file.
  const auto first =
      folder.Write("first.xml", "<mujoco><include file=\"parts/arm.xml\"/></mujoco>");
  const auto arm = folder.Write(
      "parts/arm.xml", "<mujoco>\n<asset><model name=\"b\" file=\"first.xml\"/></asset></mujoco>");
  EXPECT_THAT(ErrorOfFile(first), StartsWith(arm.string() + ":2: <model file=\"first.xml\">"));
}

TEST(CheckFiles, OneFileMayBeAttachedTwiceAndACommentedCycleIsNone) {
  const testing_support::TempFolder folder;
  folder.Write("finger.xml", InWorld("<body name=\"f\"><geom size=\"1\"/></body>"));
  CheckFiles(folder.Write("hand.xml",
                          "<mujoco><!-- <include file=\"hand.xml\"/> --><asset>"
                          "<model name=\"a\" file=\"finger.xml\"/>"
                          "<model name=\"b\" file=\"finger.xml\"/></asset></mujoco>"));
}

TEST(CheckFiles, TooManyFilesInsideEachOtherAreRefused) {
  const testing_support::TempFolder folder;
  for (int i = 0; i < 40; ++i) {
    folder.Write(fmt::format("{}.xml", i),
                 fmt::format("<mujoco><include file=\"{}.xml\"/></mujoco>", i + 1));
  }
  EXPECT_THAT(ErrorOfFile(folder / "0.xml"),
              HasSubstr("31.xml:1: <include file=\"32.xml\">: more "));
}

TEST(CheckFiles, TooLargeTexturesAndHeightFieldsAreRefused) {
  const testing_support::TempFolder folder;
  const auto asset = [&](const std::string& element) {
    return folder.Write("a.xml", "<mujoco><asset>\n" + element + "</asset></mujoco>");
  };
  EXPECT_THAT(ErrorOfFile(asset("<hfield nrow=\"60000\" ncol=\"60000\"/>")),
              AllOf(HasSubstr("a.xml:2: <hfield>"), HasSubstr("3.6e+09 values")));
  EXPECT_THAT(ErrorOfFile(asset("<texture width=\"1000000\" height=\"1000000\"/>")),
              HasSubstr("a.xml:2: <texture>"));
  CheckFiles(asset("<hfield nrow=\"2000\" ncol=\"2000\"/>"));
}

// The engine would wait for a writer forever.
TEST(CheckFiles, ANamedPipeIsRefusedWhereverItIsNamed) {
  const testing_support::TempFolder folder;
  std::filesystem::create_directories(folder / "meshes");
  for (const char* name : {"arm.xml", "meshes/cup.obj"}) {
    ASSERT_EQ(mkfifo((folder / name).c_str(), 0600), 0);
  }
  const auto include = folder.Write("i.xml", "<mujoco>\n<include file=\"arm.xml\"/></mujoco>");
  EXPECT_THAT(ErrorOfFile(include),
              HasSubstr("i.xml:2: <include file=\"arm.xml\">: is a named pipe"));
  const auto mesh = folder.Write("m.xml",
                                 "<mujoco><compiler meshdir=\"meshes\"/><asset>\n\n"
                                 "<mesh file=\"cup.obj\"/></asset></mujoco>");
  EXPECT_THAT(ErrorOfFile(mesh), HasSubstr("m.xml:3: file=\"cup.obj\": is a named pipe"));
}

// What is missing or no XML is left to the engine, which names the line.
TEST(CheckFiles, OtherMistakesAreLeftToTheEngine) {
  const testing_support::TempFolder folder;
  CheckFiles(folder.Write("a.xml", "<mujoco><include file=\"missing.xml\"/><include file=\"\"/>"));
  CheckFiles(folder.Write("b.xml", "no XML"));
}

}  // namespace
}  // namespace rangegrasp::mjcf
