#include "base/installation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/yaml_map.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::base {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::TempFolder;

constexpr const char* kVariable = "RANGEGRASP_DATA";

// Makes a data folder with two experiments.
std::filesystem::path MakeData(const TempFolder& folder, const std::string& name) {
  folder.Write(name + "/models/cup.xml", "");
  folder.Write(name + "/scenes/table.xml", "");
  folder.Write(name + "/experiments/pile.yaml", "");
  folder.Write(name + "/experiments/box.yaml", "");
  folder.Write(name + "/experiments/reference/box.csv", "");
  return folder / name;
}

// Sets RANGEGRASP_DATA during its lifetime.
class DataVariable {
 public:
  explicit DataVariable(const std::filesystem::path& folder) {
    setenv(kVariable, folder.c_str(), /*overwrite=*/1);
  }
  ~DataVariable() { unsetenv(kVariable); }
  DataVariable(const DataVariable&) = delete;
  DataVariable& operator=(const DataVariable&) = delete;
};

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
    EXPECT_THAT(ErrorOf([&] { DataFolderOf(program); }), HasSubstr(kVariable)) << missing;
  }
}

TEST(DataFolder, SaysWhereItLookedAndWhatHelps) {
  const TempFolder folder;
  const auto program = folder.Write("bin/rangegrasp", "");
  const auto error = ErrorOf([&] { DataFolderOf(program); });
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
    EXPECT_THAT(ErrorOf([] { DataFolder(); }), HasSubstr(folder.path().string()));
  }
  const DataVariable variable("");
  EXPECT_EQ(DataFolder(), RANGEGRASP_SOURCE_DIR);
}

class FindExperimentTest : public testing::Test {
 protected:
  const TempFolder folder_;
  const std::filesystem::path data_ = MakeData(folder_, "data");
  const DataVariable variable_{data_};
};

TEST_F(FindExperimentTest, NamesStandForTheFilesOfTheDataFolder) {
  EXPECT_THAT(ExperimentNames(data_), ElementsAre("box", "pile"));
  for (const char* name : {"pile", "pile.yaml", "experiments/pile", "experiments/pile.yaml"}) {
    EXPECT_EQ(FindExperiment(name), data_ / "experiments/pile.yaml");
  }
}

TEST_F(FindExperimentTest, APathThatExistsIsTakenAsItIs) {
  const auto own = folder_.Write("own/pile.yaml", "");
  EXPECT_EQ(FindExperiment(own), own);
}

TEST_F(FindExperimentTest, AMistakeIsToldWithTheNearestName) {
  EXPECT_THAT(ErrorOf([&] { FindExperiment("piel"); }), HasSubstr("nearest: 'pile'"));
  // A path elsewhere never refers to one of the program's own experiments.
  EXPECT_THAT(ErrorOf([&] { FindExperiment(folder_ / "pile.yaml"); }), HasSubstr("no such file"));
}

using testing::AllOf;

// Registers words as CMake does for systems that are not built. No real system has these words.
class SystemsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    AddWordNotBuilt({"command", "juggle", "circus"});
    AddWordNotBuilt({"key", "show.clowns", "circus"});
    AddWordNotBuilt({"value", "show.kind=circus", "circus"});
  }
  static std::string SystemMissingFor(const std::function<void()>& run) {
    try {
      run();
    } catch (const NotBuilt& missing) {
      return missing.system();
    }
    return "";
  }
};

TEST_F(SystemsTest, AWordOfASystemThatIsNotBuiltIsNamedWithIt) {
  EXPECT_THAT(ErrorOf([] { CheckBuilt("command", "juggle"); }),
              AllOf(HasSubstr("command 'juggle'"), HasSubstr("the system 'circus'"),
                    HasSubstr("-DRANGEGRASP_SYSTEMS=circus")));
  EXPECT_EQ(SystemMissingFor([] { CheckBuilt("command", "juggle"); }), "circus");
}

TEST_F(SystemsTest, TheWordsOfAKindThatAreNotBuiltAreListed) {
  EXPECT_THAT(WordsNotBuilt("command"), testing::Contains("juggle"));
  EXPECT_THAT(WordsNotBuilt("task"), testing::Not(testing::Contains("juggle")));
}

TEST_F(SystemsTest, OtherWordsAndOtherKindsOfWordsAreNot) {
  EXPECT_NO_THROW(CheckBuilt("command", "run"));
  EXPECT_NO_THROW(CheckBuilt("task", "juggle"));
}

TEST_F(SystemsTest, AKeyOfAFileSaysWhereItStandsAndWhoseItIs) {
  const auto read = [](const std::string& text, const std::vector<std::string>& set = {}) {
    auto map = YamlMap::FromText(text, "show.yaml", set);
    auto show = map.Child("show");
    std::string kind = "theatre";
    show.Read("kind", kind, {"theatre", "opera"}, "of show");
    show.Finish();
    map.Finish();
  };
  EXPECT_THAT(
      ErrorOf([&] { read("show:\n  clowns: 3\n"); }),
      AllOf(HasSubstr("show.yaml:2: "), HasSubstr("key 'show.clowns'"), HasSubstr("'circus'")));
  EXPECT_EQ(SystemMissingFor([&] { read("show: {clowns: 3}\n"); }), "circus");
  EXPECT_EQ(SystemMissingFor([&] { read("show: {kind: circus}\n"); }), "circus");
  EXPECT_EQ(SystemMissingFor([&] { read("show: {kind: opera}\n"); }), "");
  EXPECT_THAT(ErrorOf([&] { read("show: {kind: opera}\n", {"show.kind=circus"}); }),
              testing::StartsWith("--set show.kind: "));
  // A misspelt word belongs to no system.
  EXPECT_THAT(ErrorOf([&] { read("show: {clown: 3}\n"); }), HasSubstr("unknown key 'clown'"));
  EXPECT_THAT(ErrorOf([&] { read("show: {kind: circuss}\n"); }), HasSubstr("must be one of"));
}

}  // namespace
}  // namespace rangegrasp::base
