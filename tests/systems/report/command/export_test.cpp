// The output of `export`: records, and data sets with ground truth.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdlib>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "cli/command.h"
#include "experiment/store.h"
#include "geometry/cloud_file.h"

namespace rangegrasp {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing_support::Command;
using testing_support::ExpectRefused;
using testing_support::Ran;
using testing_support::RunProgram;
using testing_support::Succeeded;
using testing_support::TempFolder;

const std::string kSource = RANGEGRASP_SOURCE_DIR;

// A run of four trials with a box of 75 x 45 x 120 mm, and its data set.
class ExportTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    made_ = new Ran(RunProgram({"run", kSource + "/experiments/laser_single.yaml", "--objects",
                                "salt_cuboid", "--trials", "4", "--out", Folder("run")}));
    if (made_->code == 0) {
      *made_ = RunProgram({"export", Folder("run"), "-o", Folder("set"), "--clouds"});
    }
  }
  static void TearDownTestSuite() {
    delete made_;
    delete shared_;
  }
  void SetUp() override { ASSERT_EQ(made_->code, 0) << made_->err; }

  static std::string Folder(const std::string& name) { return (*shared_ / name).string(); }
  static json Annotations() { return json::parse(base::ReadFile(Folder("set/annotations.json"))); }
  static Eigen::Isometry3d Pose(const json& numbers) {
    Eigen::Isometry3d X;
    for (int i = 0; i < 16; ++i) X.matrix()(i / 4, i % 4) = numbers.at(static_cast<std::size_t>(i));
    return X;
  }

  static inline TempFolder* shared_ = nullptr;
  static inline Ran* made_ = nullptr;
};

// The labels of a binary PCD with the fields x y z label state.
std::vector<std::uint32_t> LabelsOf(const std::string& file) {
  const std::string bytes = base::ReadFile(file);
  std::size_t at = bytes.find("DATA binary\n") + std::strlen("DATA binary\n");
  std::vector<std::uint32_t> labels;
  for (; at + 20 <= bytes.size(); at += 20) {
    std::memcpy(&labels.emplace_back(), bytes.data() + at + 12, 4);
  }
  return labels;
}

TEST_F(ExportTest, RecordsAreThoseOfTheStore) {
  const auto stored = experiment::Store::Open(Folder("run")).ReadAll();
  std::string lines;
  for (const auto& record : stored) lines += ToJson(record) + "\n";
  EXPECT_EQ(base::ReadFile(Folder("set/records.jsonl")), lines);
  const auto csv = base::CsvTable::Parse(base::ReadFile(Folder("set/records.csv")), "records.csv");
  ASSERT_EQ(csv.rows(), stored.size());
  for (std::size_t i = 0; i < stored.size(); ++i) {
    EXPECT_EQ(csv.Cell(i, csv.Column("id")), stored[i].which.id);
    EXPECT_EQ(csv.Cell(i, csv.Column("outcome")), stored[i].result.outcome);
    const auto data = json::parse(stored[i].result.data);
    EXPECT_EQ(csv.Cell(i, csv.Column("data.scan_points")), data["scan_points"].dump());
  }
}

// Samples lie within 3 mm of the box: ten times the scanner's noise plus its calibration error.
TEST_F(ExportTest, LabelledSamplesLieOnTheObjectInItsPose) {
  const json set = Annotations();
  ASSERT_EQ(set["clouds"].size(), 4u);
  ASSERT_EQ(set["annotations"].size(), 4u);
  EXPECT_EQ(set["categories"][0]["title"], "Salt Shaker (cuboid)");
  const Eigen::Array3d half(0.0375, 0.0225, 0.06);
  for (const json& box : set["annotations"]) {
    EXPECT_TRUE(box["target"]);
    const std::string file =
        Folder("set/") +
        set["clouds"][box["cloud_id"].get<std::size_t>()]["file_name"].get<std::string>();
    const auto cloud = geometry::ReadCloud(file);
    const auto labels = LabelsOf(file);
    ASSERT_EQ(labels.size(), cloud.points.size());
    const Eigen::Isometry3d X_OW = Pose(box["X_WO"]).inverse();
    int on_it = 0;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      if (labels[i] != box["label"] || !cloud.points[i].allFinite()) continue;
      ++on_it;
      const Eigen::Array3d outside = (X_OW * cloud.points[i]).array().abs() - half;
      EXPECT_LT(std::abs(outside.maxCoeff()), 0.003) << file << ", sample " << i;
    }
    EXPECT_GT(on_it, 200);
  }
}

TEST_F(ExportTest, TheGraspThatWasTriedHasTheTrialsOutcome) {
  const json set = Annotations();
  std::map<int, std::vector<std::string>> tried;
  for (const json& grasp : set["grasps"]) {
    EXPECT_EQ(grasp["annotation_id"], grasp["cloud_id"]);  // one object per cloud here
    if (!grasp["outcome"].is_null()) tried[grasp["cloud_id"]].push_back(grasp["outcome"]);
  }
  for (const json& cloud : set["clouds"]) {
    EXPECT_EQ(tried[cloud["id"].get<int>()], std::vector<std::string>{cloud["outcome"]});
  }
  EXPECT_EQ(made_->err.find("ended differently"), std::string::npos) << made_->err;
}

TEST_F(ExportTest, OneThatWasKilledGoesOnToTheSameFiles) {
  const std::vector<std::string> arguments = {"export",   Folder("run"), "-o", Folder("again"),
                                              "--clouds", "--jobs",      "1"};
  {
    Command command(arguments);
    while (command.Runs() && !std::filesystem::exists(Folder("again/clouds"))) usleep(1000);
    command.Kill();
  }
  EXPECT_FALSE(std::filesystem::exists(Folder("again/annotations.json")));
  const Ran ran = RunProgram(arguments);
  ASSERT_EQ(ran.code, 0) << ran.err;
  for (const char* name : {"annotations.json", "clouds/salt_cuboid-0000.pcd", "records.csv"}) {
    EXPECT_EQ(base::ReadFile(Folder("again/") + name), base::ReadFile(Folder("set/") + name));
  }
}

// Empty: there is none.
std::string PythonWithNumpy() {
  std::string python;
  for (const char* one : {"python3", "/usr/bin/python3"}) {
    if (std::system((std::string(one) + " -c 'import numpy' 2>/dev/null").c_str()) == 0)
      python = one;
  }
  return python;
}

TEST_F(ExportTest, PythonReadsItWithNumpyAlone) {
  const std::string python = PythonWithNumpy();
  if (python.empty()) GTEST_SKIP() << "no Python with numpy (Debian: python3-numpy)";
  const std::string command = python + " " + kSource + "/examples/read_data_set.py " +
                              Folder("set") + " > " + Folder("read");
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string text = base::ReadFile(Folder("read"));
  for (const json& cloud : Annotations()["clouds"]) {
    EXPECT_THAT(text, HasSubstr(cloud["case"].get<std::string>() + ": " +
                                cloud["outcome"].get<std::string>() + ", " +
                                cloud["measured"].dump() + " samples"));
  }
}

TEST_F(ExportTest, TheReaderNamesTheFoldersOfSeveralSeeds) {
  const std::string python = PythonWithNumpy();
  if (python.empty()) GTEST_SKIP() << "no Python with numpy (Debian: python3-numpy)";
  base::WriteFile(Folder("seeds/seed-5/annotations.json"), "{}");
  base::WriteFile(Folder("seeds/seed-6/annotations.json"), "{}");
  const std::string command = python + " " + kSource + "/examples/read_data_set.py " +
                              Folder("seeds") + " 2> " + Folder("refused");
  EXPECT_NE(std::system(command.c_str()), 0);
  EXPECT_EQ(base::ReadFile(Folder("refused")), "no annotations.json in " + Folder("seeds") +
                                                   "; it has seed-5, seed-6: name one of them\n");
}

TEST_F(ExportTest, ResultsOfAnotherRunAreNotTouched) {
  std::filesystem::copy(Folder("run"), Folder("other"));
  const std::string before = base::ReadFile(Folder("other/results.sqlite"));
  ExpectRefused({"export", Folder("run"), "-o", Folder("other"), "--clouds"},
                "holds the results of a run; choose another folder with --out");
  EXPECT_EQ(base::ReadFile(Folder("other/results.sqlite")), before);
  EXPECT_FALSE(std::filesystem::exists(Folder("other/records.csv")));
}

// A copy of the run with other values in its stamp, or the begun export of such a run.
void WriteChangedRun(const std::string& of, const std::string& folder,
                     const std::map<std::string, std::string>& identity, bool begun = false) {
  const auto run = experiment::Store::Open(of);
  auto another = experiment::Store::Create(folder);
  auto stamp = run.ReadStamp();
  for (const auto& [name, value] : identity) stamp.identity[name] = value;
  if (begun) stamp.data["export"] = "clouds";
  another.WriteStamp(stamp);
  for (const auto& record : run.ReadAll()) another.Write(record);
  another.Finish();
}

TEST_F(ExportTest, ExportsOfTwoRunsAreNotMixed) {
  WriteChangedRun(Folder("run"), Folder("changed"), {{"seed", "2"}});
  WriteChangedRun(Folder("run"), Folder("begun"), {{"seed", "2"}}, /*begun=*/true);
  WriteChangedRun(Folder("run"), Folder("resumed"), {{"cases", "5"}});
  const auto before = std::filesystem::last_write_time(Folder("set/records.csv"));
  ExpectRefused({"export", Folder("changed"), "-o", Folder("set")},
                "set: contains the export of another run (laser_single: rangegrasp ");
  ExpectRefused({"export", Folder("run"), "-o", Folder("changed")}, "holds the results of a run");
  ExpectRefused({"export", Folder("run"), "-o", Folder("begun")}, "results of another run");
  EXPECT_EQ(std::filesystem::last_write_time(Folder("set/records.csv")), before);
  for (const char* same : {"resumed", "run"}) {
    Succeeded(RunProgram({"export", Folder(same), "-o", Folder("set")}));
  }
}

TEST_F(ExportTest, ExportsOfOneAndOfSeveralSeedsAreNotMixed) {
  for (const char* seed : {"seeds/seed-1", "seeds/seed-2"}) {
    std::filesystem::create_directories(Folder(seed));
    std::filesystem::copy_file(Folder("run/results.sqlite"),
                               Folder(seed) + std::string("/results.sqlite"));
  }
  for (int i = 0; i < 2; ++i) {  // it may be repeated
    Succeeded(RunProgram({"export", Folder("seeds"), "-o", Folder("of_seeds")}));
  }
  ExpectRefused({"export", Folder("run"), "-o", Folder("of_seeds")}, "contains several seeds");
  ExpectRefused({"export", Folder("seeds"), "-o", Folder("set")},
                "contains the export of one seed");
}

TEST_F(ExportTest, WhatItCannotExportIsTold) {
  ExpectRefused({"export", Folder("run"), "-o", Folder("run"), "--clouds"},
                "is the folder of the run");
  EXPECT_TRUE(experiment::Store::Exists(Folder("run")));
  Succeeded(RunProgram(
      {"run", kSource + "/experiments/seam_base.yaml", "--trials", "3", "--out", Folder("seams")}));
  ExpectRefused({"export", Folder("seams"), "-o", Folder("seam_set"), "--clouds"},
                Folder("seams") + ": `task: seam` has no clouds, only `task: grasping` has");
  EXPECT_FALSE(std::filesystem::exists(Folder("seam_set")));
  Succeeded(RunProgram({"export", Folder("seams"), "-o", Folder("seam_set")}));
  EXPECT_EQ(RunProgram({"export", Folder("nowhere"), "-o", Folder("x")}).code, 2);
}

}  // namespace
}  // namespace rangegrasp
