#include "base/data_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/error.h"
#include "temp_folder.h"

namespace rangegrasp::base {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::TempFolder;

constexpr const char* kVariable = "RANGEGRASP_DATA";

// A data folder of two experiments.
std::filesystem::path MakeData(const TempFolder& folder, const std::string& name) {
  folder.Write(name + "/models/cup.xml", "");
  folder.Write(name + "/scenes/table.xml", "");
  folder.Write(name + "/experiments/pile.yaml", "");
  folder.Write(name + "/experiments/box.yaml", "");
  folder.Write(name + "/experiments/reference/box.csv", "");
  return folder / name;
}

// Sets RANGEGRASP_DATA for as long as it lives.
class DataVariable {
 public:
  explicit DataVariable(const std::filesystem::path& folder) {
    setenv(kVariable, folder.c_str(), /*overwrite=*/1);
  }
  ~DataVariable() { unsetenv(kVariable); }
  DataVariable(const DataVariable&) = delete;
  DataVariable& operator=(const DataVariable&) = delete;
};

template <typename Call>
std::string DataFolderErrorOf(Call call) {
  try {
    call();
  } catch (const InputError& e) {
    return e.what();
  }
  return "nothing was thrown";
}

TEST(DataFolder, AnInstalledProgramFindsItBesideItself) {
  const TempFolder folder;
  const auto data = MakeData(folder, "moved/share/rangegrasp");
  EXPECT_EQ(DataFolderOf(folder.Write("moved/bin/rangegrasp", "")), data);
}

TEST(DataFolder, ABuiltProgramFindsTheSourceTreeThatItsBuildFolderLiesIn) {
  const TempFolder folder;
  const auto tree = MakeData(folder, "tree");
  EXPECT_EQ(DataFolderOf(folder.Write("tree/build/dev/src/cli/rangegrasp", "")), tree);
  EXPECT_EQ(DataFolder(), RANGEGRASP_SOURCE_DIR);
}

TEST(DataFolder, HoldsModelsScenesAndExperimentsOrIsNone) {
  for (const char* missing : {"models", "scenes", "experiments"}) {
    const TempFolder folder;
    const auto data = MakeData(folder, "share/rangegrasp");
    std::filesystem::remove_all(data / missing);
    const auto program = folder.Write("bin/rangegrasp", "");
    EXPECT_THAT(DataFolderErrorOf([&] { DataFolderOf(program); }), HasSubstr(kVariable)) << missing;
  }
}

TEST(DataFolder, SaysWhereItLookedAndWhatHelps) {
  const TempFolder folder;
  const auto program = folder.Write("bin/rangegrasp", "");
  const auto error = DataFolderErrorOf([&] { DataFolderOf(program); });
  EXPECT_THAT(error, HasSubstr((folder / "share/rangegrasp").string()));
  EXPECT_THAT(error, HasSubstr(kVariable));
}

TEST(DataFolder, TheEnvironmentComesFirstAndIsChecked) {
  const TempFolder folder;
  const auto data = MakeData(folder, "data");
  {
    const DataVariable variable(data);
    EXPECT_EQ(DataFolder(), data);
  }
  {
    const DataVariable variable(folder.path());
    EXPECT_THAT(DataFolderErrorOf([] { DataFolder(); }), HasSubstr(folder.path().string()));
  }
  const DataVariable variable("");
  EXPECT_EQ(DataFolder(), RANGEGRASP_SOURCE_DIR);
}

TEST(FindExperiment, NamesStandForTheFilesOfTheDataFolder) {
  const TempFolder folder;
  const auto data = MakeData(folder, "data");
  const DataVariable variable(data);
  EXPECT_THAT(ExperimentNames(data), ElementsAre("box", "pile"));
  for (const char* name : {"pile", "pile.yaml", "experiments/pile", "experiments/pile.yaml"}) {
    EXPECT_EQ(FindExperiment(name), data / "experiments/pile.yaml");
  }
}

TEST(FindExperiment, APathThatExistsIsTakenAsItIs) {
  const TempFolder folder;
  const auto data = MakeData(folder, "data");
  const DataVariable variable(data);
  const auto own = folder.Write("own/pile.yaml", "");
  EXPECT_EQ(FindExperiment(own), own);
}

TEST(FindExperiment, AMistakeIsToldWithTheNearestName) {
  const TempFolder folder;
  const auto data = MakeData(folder, "data");
  const DataVariable variable(data);
  EXPECT_THAT(DataFolderErrorOf([&] { FindExperiment("piel"); }), HasSubstr("nearest: 'pile'"));
  // A path to somewhere else never means one of the program's own experiments.
  EXPECT_THAT(DataFolderErrorOf([&] { FindExperiment(folder / "pile.yaml"); }),
              HasSubstr("no such file"));
}

}  // namespace
}  // namespace rangegrasp::base
