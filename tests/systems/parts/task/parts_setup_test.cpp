#include "parts/task/parts_setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/file.h"
#include "error_of.h"
#include "parts/task/peanuts.h"

namespace rangegrasp::parts {
namespace {

using testing::HasSubstr;
using testing_support::Peanuts;

class PartsSetupTest : public testing::Test {
 protected:
  PartsSetup Read(const std::string& text) const {
    auto map = base::YamlMap::FromText(text, peanuts_.folder / "parts.yaml");
    return ReadPartsSetup(map);
  }
  std::string Refused(const std::string& text) const {
    return testing_support::ErrorOf([&] { Read(text); });
  }

  Peanuts peanuts_;
};

TEST_F(PartsSetupTest, TheFileNamesClassesSplitsAndMethods) {
  const auto setup = Read(Peanuts::kGood);
  EXPECT_EQ(setup.methods, (std::vector{Method::kKMeans, Method::kSdf}));
  ASSERT_EQ(setup.classes.size(), 2U);
  EXPECT_EQ(setup.classes[0].name, "peanut");
  EXPECT_EQ(setup.classes[0].tune, std::vector{1});
  EXPECT_EQ(setup.classes[0].report, (std::vector{2, 3}));
  EXPECT_TRUE(setup.classes[1].tune.empty());
}

TEST_F(PartsSetupTest, ARangeNamesAllModelsThatAreAtHand) {
  const std::string rest = "data: .\nclasses: [a]\nmodels: {a: {tune: [1], report: [2-10]}}\n";
  EXPECT_EQ(Read(rest).classes[0].report, (std::vector{2, 3}));
  for (const char* wrong : {"3-2", "1-2000", "2-", "-3", "a-b"}) {
    EXPECT_THAT(
        Refused("data: .\nclasses: [a]\nmodels:\n  a: {report: [" + std::string(wrong) + "]}\n"),
        HasSubstr("must be a model's number, as in off/<number>.off, or a range such as 61-80"));
  }
  EXPECT_THAT(Refused("data: .\nclasses: [a]\nmodels: {a: {tune: [2], report: [1-3]}}\n"),
              HasSubstr("model 2 is given twice"));
}

TEST_F(PartsSetupTest, WithoutMethodsAllAreRun) {
  const auto setup = Read("data: .\nclasses: [a]\nmodels: {a: {report: [1]}}\n");
  EXPECT_EQ(setup.methods.size(), base::ValuesOf<Method>().size());
}

TEST_F(PartsSetupTest, MistakesAreToldWithLineAndKey) {
  const std::string models = "models: {a: {report: [1]}}\ndata: .\n";
  EXPECT_THAT(Refused("methods: [kmeens]\nclasses: [a]\n" + models),
              HasSubstr("parts.yaml:1: key 'methods': 'kmeens' must be one of mirror, hierarchy, "
                        "kmeans, sdf, core; nearest: kmeans"));
  EXPECT_THAT(Refused(models), HasSubstr("key 'classes': is missing"));
  EXPECT_THAT(Refused("classes: [a, b]\n" + models),
              HasSubstr("parts.yaml:2: key 'models': has no models of class 'b'"));
  EXPECT_THAT(Refused("data: .\nclasses: [a]\nmodels: {a: {report: [1]}, b: {report: [2]}}\n"),
              HasSubstr("unknown key 'b'; nearest valid key: 'a'"));
  EXPECT_THAT(Refused("data: .\nclasses: [a]\nmodels:\n  a: {report: [1, x1]}\n"),
              HasSubstr("parts.yaml:4: key 'report': 'x1' must be a model's number"));
  EXPECT_THAT(Refused("data: .\nclasses: [a]\nmodels:\n  a: {tune: [1], report: [1]}\n"),
              HasSubstr("model 1 is given twice"));
  EXPECT_THAT(Refused("data: .\nclasses: [a]\nmodels:\n  a: {}\n"), HasSubstr("must list models"));
  EXPECT_THAT(Refused("data: .\nclasses: [a]\nmodel: {a: {report: [1]}}\n"),
              HasSubstr("key 'models': is missing"));
  EXPECT_THAT(Refused("classes: [a]\nruntimes: none.csv\n" + models), HasSubstr("none.csv"));
  EXPECT_THAT(Refused("data: .\nclasses: ['a,b']\nmodels: {'a,b': {report: [1]}}\n"),
              HasSubstr("'a,b' must consist of letters"));
  EXPECT_THAT(Refused("models_per_class: -1\nclasses: [a]\n" + models),
              HasSubstr("key 'models_per_class'"));
}

TEST_F(PartsSetupTest, ABrokenPublishedTableIsToldWithItsLineBeforeTheRun) {
  peanuts_.folder.Write("6.1.csv", "method,average_s\nSDF,8.9\nK-Means,fast\n");
  EXPECT_THAT(Refused(std::string(Peanuts::kGood) + "runtimes: 6.1.csv\n"),
              testing::AllOf(HasSubstr("6.1.csv:3: "), HasSubstr("'fast'")));
}

TEST_F(PartsSetupTest, AFolderWithoutTheDataIsToldBeforeTheRun) {
  const std::string models = "classes: [a]\nmodels: {a: {report: [1]}}\n";
  EXPECT_THAT(Refused("data: off\n" + models),
              testing::AllOf(HasSubstr("has no folder 'off'"), HasSubstr("--set data=DIR")));
  EXPECT_THAT(Refused(models), HasSubstr("key 'data': is missing"));
}

TEST_F(PartsSetupTest, TheShippedExperimentHasFourModelsOfEachClassForTuning) {
  const std::filesystem::path file = RANGEGRASP_SOURCE_DIR "/experiments/parts_psb.yaml";
  auto map = base::YamlMap::FromFile(file, {"data=" + peanuts_.folder.path().string()});
  std::string word;
  map.Read("task", word);  // as the engine does
  map.Read("name", word);
  const auto setup = ReadPartsSetup(map);
  EXPECT_EQ(setup.classes.size(), 19U);
  EXPECT_EQ(setup.methods.size(), base::ValuesOf<Method>().size());
  EXPECT_FALSE(setup.published.empty());
  for (const auto& one : setup.classes) {
    EXPECT_EQ(one.tune.size(), 4U) << one.name;
    // The default ids are ranges, of which this folder contains only a few people.
    EXPECT_EQ(one.report.empty(), one.name != "human") << one.name;
  }
}

// A number of models per class limits each split; k-means still gets the same number of parts.
TEST_F(PartsSetupTest, FewerModelsAClassAreTheFirstOfEachSplit) {
  const auto all = Read(Peanuts::kGood);
  const auto some = Read(std::string(Peanuts::kGood) + "models_per_class: 1\n");
  EXPECT_EQ(some.classes[0].tune, std::vector{1});
  EXPECT_EQ(some.classes[0].report, std::vector{2});
  EXPECT_EQ(some.classes[0].human_segments, all.classes[0].human_segments);
}

TEST_F(PartsSetupTest, TheStampBringsItBack) {
  peanuts_.folder.Write("6.1.csv", "method,average_s\nSDF,8.9\n");
  const auto setup = Read(std::string(Peanuts::kGood) + "runtimes: 6.1.csv\n");
  experiment::Stamp stamp;
  AddTo(stamp, setup);
  const auto again = PartsSetupOf(stamp);
  EXPECT_EQ(again.methods, setup.methods);
  EXPECT_EQ(again.published, setup.published);
  ASSERT_EQ(again.classes.size(), setup.classes.size());
  for (std::size_t c = 0; c < setup.classes.size(); ++c) {
    EXPECT_EQ(again.classes[c].name, setup.classes[c].name);
    EXPECT_EQ(again.classes[c].tune, setup.classes[c].tune);
    EXPECT_EQ(again.classes[c].report, setup.classes[c].report);
  }
}

TEST_F(PartsSetupTest, TheHashOfTheModelsChangesWithAnyFile) {
  const auto hash = [&] {
    experiment::Stamp stamp;
    AddTo(stamp, Read(Peanuts::kGood));
    return stamp.identity.at("models_hash");
  };
  const std::string before = hash();
  EXPECT_EQ(hash(), before);
  const std::string seg = base::ReadFile(peanuts_.folder / "seg/3/3_10.seg");
  peanuts_.folder.Write("seg/3/3_10.seg", seg + "\n");
  EXPECT_NE(hash(), before);
  peanuts_.folder.Write("seg/3/3_10.seg", seg);
  EXPECT_EQ(hash(), before);
  std::filesystem::remove(peanuts_.folder / "off/11.off");
  EXPECT_NE(hash(), before);
}

// Every key of the shipped experiment is documented.
TEST_F(PartsSetupTest, EveryKeyHasItsLineOfDocumentation) {
  auto map = base::YamlMap::ForDocumentation();
  ReadPartsKeys(map);
  std::vector<std::string> paths;
  for (const base::KeyDoc& key : map.Keys()) {
    paths.push_back(key.path);
    EXPECT_FALSE(key.doc.empty()) << key.path;
  }
  EXPECT_THAT(paths, testing::UnorderedElementsAre(
                         "methods", "clouds", "clouds.points", "clouds.noise_percent", "classes",
                         "models_per_class", "runtimes", "data", "models", "models.<class>",
                         "models.<class>.tune", "models.<class>.report"));
}

}  // namespace
}  // namespace rangegrasp::parts
