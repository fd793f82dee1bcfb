// Tests a short version of every experiment file for what a run must not depend on.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "experiment/store.h"

namespace rangegrasp {
namespace {

using experiment::Store;
using testing_support::Command;
using testing_support::RunProgram;
using testing_support::TempFolder;

const std::filesystem::path kSource = RANGEGRASP_SOURCE_DIR;

std::vector<std::string> AllExperiments() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kSource / "experiments")) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

// Arguments for a short version: a few cases of at most a few seconds.
std::vector<std::string> Short(const std::string& name) {
  if (name == "parts_clouds") {
    return {"--objects", "cup", "--trials", "1", "--set", "clouds.points=[2000]"};
  }
  if (name.starts_with("parts_")) {
    return {"--objects", "cup", "--trials", "1", "--set", "methods=[mirror, kmeans, core]"};
  }
  if (name.starts_with("seam_track") || name.starts_with("seam_hazards") ||
      name == "seam_half_circle") {
    return {"--trials", "2", "--set", "track.length_mm=150"};
  }
  if (name.starts_with("seam_")) return {"--trials", "4", "--set", "profiles_per_seam=40"};
  if (name == "laser_bowl") return {"--trials", "3"};
  if (name.starts_with("laser_and_stereo_")) return {"--objects", "spread", "--trials", "3"};
  if (name == "known_pile") {
    return {"--objects", "spread", "--trials",
            "3",         "--set",  "objects=[spread, salt_cuboid, dextrose]"};
  }
  if (name == "known_touching" || name == "known_color") {
    return {"--objects", "spread", "--trials", "3"};
  }
  if (name == "bring") {
    return {"--objects", "spread,coffee_cup", "--trials", "2", "--set", "arrangement=single"};
  }
  if (name.starts_with("clear_")) {
    return {"--trials", "3",
            "--set",    "objects=[spread, salt_cuboid, dextrose]",
            "--set",    "clearing.max_grasps=3"};
  }
  if (name == "stage_times") {
    return {"--trials",         "2", "--set", "repeats=1", "--set", "object_points=2000", "--set",
            "table_points=2000"};
  }
  if (name == "segmentation_times") {
    return {"--objects", "mesh", "--trials", "3", "--set", "repeats=1"};
  }
  if (name == "survey_clouds") return {"--objects", "learn2,learn6"};
  if (name == "cylinder_demo" || name == "cylinder_recall") return {"--trials", "4"};
  if (name == "cylinder_resolution" || name == "cylinder_iterations") {
    return {"--objects", "perfect,scanned",
            "--trials",  "2",
            "--set",     "iterations=[1, 10]",
            "--set",     "rows=['10, 100, 1000', '25.75, 173, 2000']"};
  }
  if (name == "outside_python") {  // works without a sandbox, too
    return {"--objects", "spread,salt_cuboid,dextrose", "--trials", "1",
            "--set",     "detector.sandbox=false"};
  }
  return {"--objects", "spread,salt_cuboid,dextrose", "--trials", "1"};
}

// Computation times are in columns among the others.
void RemoveColumnsOfSeconds(nlohmann::json& table) {
  nlohmann::json& columns = table["columns"];
  for (std::size_t i = columns.size(); i-- > 0;) {
    if (!columns[i].get<std::string>().ends_with("[s]")) continue;
    columns.erase(i);
    for (auto& row : table["rows"]) row.erase(i);
  }
}

class ReproducibleTest : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if ((GetParam().starts_with("parts_") || GetParam() == "survey_clouds") &&
        !std::filesystem::exists(kSource / "../shared/data")) {
      GTEST_SKIP() << "the benchmark's meshes and clouds (../shared/data) are not here";
    }
    if (GetParam() == "outside_python" &&
        std::system("python3 -c 'import numpy' 2>/dev/null") != 0) {
      GTEST_SKIP() << "python3 has no numpy here (Debian package python3-numpy)";
    }
    if (CalibratedBefore()) {
      Succeeded(RunProgram({"calibrate-stereo", Experiment(), "--out", Folder("stereo.yaml")}));
    }
  }
  // One experiment calibrates the camera in each run, which takes seconds; the others do it once.
  static bool CalibratedBefore() {
    return GetParam().find("stereo") != std::string::npos &&
           GetParam() != "laser_and_stereo_single";
  }
  static std::string Experiment() { return kSource / "experiments" / (GetParam() + ".yaml"); }
  std::string Folder(const std::string& name) const { return folder_ / name; }
  std::vector<std::string> Arguments(const std::string& name,
                                     const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"run", Experiment(), "--out", Folder(name)};
    if (CalibratedBefore()) {
      arguments.insert(arguments.end(), {"--set", "stereo.calibration=" + Folder("stereo.yaml")});
    }
    for (const auto& list : {Short(GetParam()), more}) {
      arguments.insert(arguments.end(), list.begin(), list.end());
    }
    return arguments;
  }
  void RunInto(const std::string& name, const std::vector<std::string>& more) const {
    Succeeded(RunProgram(Arguments(name, more)));
  }
  // Every row without its times.
  std::vector<std::string> Rows(const std::string& name) const {
    std::vector<std::string> rows;
    for (auto record : Store::Open(Folder(name)).ReadAll()) {
      record.result.seconds.clear();
      rows.push_back(ToJson(record));
    }
    return rows;
  }
  nlohmann::json TableOf(const std::string& name) const {
    auto json = nlohmann::json::parse(Succeeded(RunProgram({"table", Folder(name), "--json"})).out);
    json.erase("stage_seconds");
    if (json.contains("tables")) {  // computation times have their own table
      std::erase_if(json["tables"].get_ref<nlohmann::json::array_t&>(), [](const auto& table) {
        return table["title"].template get<std::string>().find("time") != std::string::npos;
      });
      for (auto& table : json["tables"]) RemoveColumnsOfSeconds(table);
    }
    return json;
  }
  // Runs with a heap with other addresses and other old contents, which reveals uninitialized reads
  // and results that depend on addresses. Sanitizers have their own heap.
  void RunStirred(const std::string& name, const std::vector<std::string>& more) const {
    Command command(Arguments(name, more), "", "/dev/null", RANGEGRASP_STIRRED_HEAP);
    ASSERT_EQ(command.Wait(), 0) << command.Err();
  }
  void KillAfterItsFirstRow(const std::string& name) const {
    Command command(Arguments(name, {"--jobs", "2"}));
    const auto rows = [&] {
      try {
        return Store::Open(Folder(name)).Count();
      } catch (const std::exception&) {
        return 0;  // does not exist yet
      }
    };
    while (command.Runs() && rows() < 1) usleep(500);
    command.Kill();
  }

  TempFolder folder_;
};

// Runs twice and varies everything that must not matter: merged shards with one job each and
// another heap, and a run of all cases with two jobs that is killed and resumed.
TEST_P(ReproducibleTest, JobsShardsAKillAndAnotherHeapGiveTheSameRowsAndTables) {
  for (const char* shard : {"1", "2", "3"}) {
    RunStirred(std::string("shard") + shard, {"--jobs", "1", "--shard", std::string(shard) + "/3"});
  }
  Succeeded(RunProgram(
      {"merge", Folder("shard2"), Folder("shard3"), Folder("shard1"), "-o", Folder("merged")}));
  const auto rows = Rows("merged");
  ASSERT_GE(rows.size(), 3u);
  for (const auto& row : rows) {
    EXPECT_THAT(row, testing::Not(testing::HasSubstr("\"outcome\":\"crashed\"")));
    EXPECT_THAT(row, testing::Not(testing::HasSubstr("\"outcome\":\"timed_out\"")));
  }

  KillAfterItsFirstRow("killed");
  const auto before = Rows("killed");
  for (const auto& row : before) EXPECT_THAT(rows, testing::Contains(row));
  RunInto("killed", {"--jobs", "2", "--resume"});
  EXPECT_EQ(Rows("killed"), rows);
  EXPECT_EQ(TableOf("killed"), TableOf("merged"));
}

INSTANTIATE_TEST_SUITE_P(Experiments, ReproducibleTest, testing::ValuesIn(AllExperiments()),
                         [](const auto& name) { return name.param; });

}  // namespace
}  // namespace rangegrasp
