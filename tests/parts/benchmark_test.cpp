#include "parts/benchmark.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"
#include "core/file.h"
#include "parts/files.h"
#include "parts/solids.h"
#include "temp_folder.h"

namespace rangegrasp::parts {
namespace {

using ::testing::HasSubstr;
using testing_support::TempFolder;
using Labels = std::vector<std::int32_t>;

std::string OffOf(const Shape& shape) {
  std::string text = "OFF\n" + std::to_string(shape.points.size()) + " " +
                     std::to_string(shape.faces.size()) + " 0\n";
  for (const auto& p : shape.points) {
    for (const double x : p) text += std::to_string(x) + " ";
    text += "\n";
  }
  for (const auto& [a, b, c] : shape.faces) {
    text += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
  }
  return text;
}

// A small benchmark of peanuts, laid out as the real one; every model has two human segmentations:
// halves, and halves with a stripe between them.
class BenchmarkTest : public ::testing::Test {
 protected:
  BenchmarkTest() {
    for (const int id : {1, 2, 3, 11}) AddModel(id);
    Experiment(kGood);
  }

  void AddModel(int id) {
    const Shape shape = testing::Ball(
        6, [&](const Eigen::Vector3d& p) { return 0.6 + (1.0 + 0.1 * id) * p.x() * p.x(); });
    Labels halves, stripe;
    for (const auto& [a, b, c] : shape.faces) {
      const double x = (shape.points[a] + shape.points[b] + shape.points[c]).x();
      halves.push_back(x < 0.0 ? 0 : 1);
      stripe.push_back(x < -0.6 ? 0 : x < 0.6 ? 1 : 2);
    }
    const std::string name = std::to_string(id);
    folder_.Write("off/" + name + ".off", OffOf(shape));
    folder_.Write("seg/" + name + "/.keep", "");
    WriteLabels(folder_ / ("seg/" + name + "/" + name + "_0.seg"), halves);
    WriteLabels(folder_ / ("seg/" + name + "/" + name + "_10.seg"), stripe);
  }

  void Experiment(const std::string& text) { file_ = folder_.Write("parts.yaml", text); }
  BenchmarkOptions Options() const { return ReadBenchmark(file_, folder_.path()); }
  std::string Refused(const std::string& text) {
    Experiment(text);
    try {
      Options();
    } catch (const core::InputError& e) {
      return e.what();
    }
    return "not refused";
  }

  static constexpr const char* kGood =
      "name: peanuts\nmethods: [kmeans, sdf]\nclasses: [peanut, other]\nmodels:\n"
      "  peanut: {tune: [1], report: [2, 3]}\n  other: {report: [11]}\n";
  TempFolder folder_;
  std::filesystem::path file_;
};

// All that must not differ between runs.
void ExpectSame(const std::vector<BenchmarkRow>& a, const std::vector<BenchmarkRow>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].class_name, b[i].class_name) << i;
    EXPECT_EQ(a[i].id, b[i].id) << i;
    EXPECT_EQ(a[i].split, b[i].split) << i;
    EXPECT_EQ(a[i].method, b[i].method) << i;
    EXPECT_EQ(a[i].parts, b[i].parts) << i;
    EXPECT_EQ(a[i].rand_error, b[i].rand_error) << i;
    EXPECT_EQ(a[i].cut_discrepancy, b[i].cut_discrepancy) << i;
    EXPECT_EQ(a[i].note, b[i].note) << i;
    EXPECT_EQ(a[i].failed, b[i].failed) << i;
  }
}

// ---- the experiment file ----

TEST_F(BenchmarkTest, TheFileNamesClassesSplitsAndMethods) {
  const auto options = Options();
  EXPECT_EQ(options.name, "peanuts");
  EXPECT_EQ(options.methods, (std::vector{Method::kKMeans, Method::kSdf}));
  ASSERT_EQ(options.classes.size(), 2U);
  EXPECT_EQ(options.classes[0].name, "peanut");
  EXPECT_EQ(options.classes[0].tune, std::vector{1});
  EXPECT_EQ(options.classes[0].report, (std::vector{2, 3}));
  EXPECT_TRUE(options.classes[1].tune.empty());
}

TEST_F(BenchmarkTest, WithoutMethodsAllAreRun) {
  Experiment("classes: [a]\nmodels: {a: {report: [1]}}\n");
  EXPECT_EQ(Options().methods.size(), kMethods.size());
  EXPECT_EQ(Options().name, "parts");
}

TEST_F(BenchmarkTest, MistakesAreToldWithLineAndKey) {
  const std::string models = "models: {a: {report: [1]}}\n";
  EXPECT_THAT(Refused("methods: [kmeens]\nclasses: [a]\n" + models),
              HasSubstr("parts.yaml:1: key 'methods': 'kmeens' is no method; nearest: 'kmeans'"));
  EXPECT_THAT(Refused("methods: [sdf, sdf]\nclasses: [a]\n" + models), HasSubstr("stands twice"));
  EXPECT_THAT(Refused(models), HasSubstr("key 'classes': is missing"));
  EXPECT_THAT(Refused("classes: [a, b]\n" + models),
              HasSubstr("parts.yaml:2: key 'models': has no models of class 'b'"));
  EXPECT_THAT(Refused("classes: [a]\nmodels: {a: {report: [1]}, b: {report: [2]}}\n"),
              HasSubstr("unknown key 'b'"));
  EXPECT_THAT(Refused("classes: [a]\nmodels:\n  a: {report: [1, x1]}\n"),
              HasSubstr("parts.yaml:3: key 'report': 'x1' must be a model's number"));
  EXPECT_THAT(Refused("classes: [a]\nmodels:\n  a: {tune: [1], report: [1]}\n"),
              HasSubstr("model 1 stands twice"));
  EXPECT_THAT(Refused("classes: [a]\nmodels:\n  a: {}\n"), HasSubstr("must name models"));
  EXPECT_THAT(Refused("classes: [a]\nmodel: {a: {report: [1]}}\n"),
              HasSubstr("key 'models': is missing"));
  EXPECT_THAT(Refused("classes: [a]\nruntimes: none.csv\n" + models), HasSubstr("none.csv"));
  EXPECT_THAT(Refused("classes: ['a,b']\nmodels: {'a,b': {report: [1]}}\n"),
              HasSubstr("without comma"));
}

TEST_F(BenchmarkTest, AFolderWithoutTheDataIsToldBeforeTheRun) {
  try {
    ReadBenchmark(file_, folder_ / "off");
    FAIL();
  } catch (const core::InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("has no folder 'off'"));
    EXPECT_THAT(e.what(), HasSubstr("--data"));
  }
  EXPECT_THROW(ReadBenchmark(file_, {}), core::InputError);
}

TEST_F(BenchmarkTest, TheShippedExperimentHasTheTenClassesTwoAndTwo) {
  const auto file = std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "experiments/parts_psb.yaml";
  const auto options = ReadBenchmark(file, folder_.path());
  EXPECT_EQ(options.classes.size(), 10U);
  EXPECT_EQ(options.methods.size(), kMethods.size());
  for (const auto& one : options.classes) {
    EXPECT_EQ(one.tune.size(), 2U) << one.name;
    EXPECT_EQ(one.report.size(), 2U) << one.name;
    EXPECT_LT(one.tune.back(), one.report.front()) << one.name;
  }
}

// ---- the run ----

TEST_F(BenchmarkTest, RowsStandInTheOrderOfTheFileWithTheirSplits) {
  const auto rows = RunBenchmark(Options(), 2, {}, {});
  ASSERT_EQ(rows.size(), 8U);
  const std::vector<int> ids = {1, 1, 2, 2, 3, 3, 11, 11};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].id, ids[i]);
    EXPECT_EQ(rows[i].split, ids[i] == 1 ? Split::kTune : Split::kReport);
    EXPECT_EQ(rows[i].method, i % 2 == 0 ? Method::kKMeans : Method::kSdf);
    EXPECT_FALSE(rows[i].failed) << rows[i].note;
    EXPECT_GT(rows[i].parts, 0);
    EXPECT_GE(rows[i].seconds, 0.0);
  }
}

TEST_F(BenchmarkTest, JobsChangeNothingButTheTime) {
  ExpectSame(RunBenchmark(Options(), 1, {}, {}), RunBenchmark(Options(), 4, {}, {}));
}

TEST_F(BenchmarkTest, KMeansTakesTheMeanNumberOfHumanSegments) {
  // Two and three segments: 2.5, rounded up.
  EXPECT_EQ(MeanHumanSegments(folder_.path(), Options().classes[0]), 3);
  for (const auto& row : RunBenchmark(Options(), 1, {}, {})) {
    if (row.method != Method::kKMeans) continue;
    EXPECT_EQ(row.parts, 3);
  }
}

TEST_F(BenchmarkTest, AModelThatFailsMakesRowsThatSayWhyAndTheOthersGoOn) {
  folder_.Write("off/2.off", "OFF\nrubbish\n");
  std::filesystem::remove_all(folder_ / "seg/3");
  folder_.Write("seg/11/11_3.seg", "0\n1\n");
  const auto rows = RunBenchmark(Options(), 2, {}, {});
  ASSERT_EQ(rows.size(), 8U);
  for (const auto& row : rows) {
    EXPECT_EQ(row.failed, row.id != 1) << row.id;
    if (!row.failed) continue;
    EXPECT_EQ(row.rand_error + row.parts + row.seconds, 0.0);
  }
  EXPECT_THAT(rows[2].note, HasSubstr("2.off"));
  EXPECT_THAT(rows[4].note, HasSubstr("holds no human segmentation 3_<k>.seg"));
  EXPECT_THAT(rows[6].note, HasSubstr("11_3.seg:3: has 2 labels"));
}

TEST_F(BenchmarkTest, ARunThatWasStoppedAnywhereGoesOnToTheSameRows) {
  const auto all = RunBenchmark(Options(), 1, {}, {});
  for (std::size_t kept = 0; kept <= all.size(); kept += 3) {
    const std::vector<BenchmarkRow> done(all.begin(), all.begin() + static_cast<long>(kept));
    std::size_t fresh = 0;
    const auto rows = RunBenchmark(Options(), 2, done, [&](const BenchmarkRow&) { ++fresh; });
    EXPECT_EQ(fresh, all.size() - kept);
    ExpectSame(rows, all);
    for (std::size_t i = 0; i < kept; ++i) EXPECT_EQ(rows[i].seconds, all[i].seconds);
  }
}

TEST_F(BenchmarkTest, WhatFailedIsTriedAgain) {
  auto done = RunBenchmark(Options(), 1, {}, {});
  const auto all = done;
  done[3].failed = true;
  done[3].note = "the disk was away";
  ExpectSame(RunBenchmark(Options(), 1, done, {}), all);
}

// ---- rows.csv ----

std::vector<BenchmarkRow> SomeRows() {
  BenchmarkRow a{"cup", 21, Split::kTune, Method::kMirror, 7, 1.0 / 3.0, 0.1, 1e-6, "", false};
  BenchmarkRow b{"cup", 22, Split::kReport, Method::kCore, 1, 0.25, {}, 2.5, "one part", false};
  BenchmarkRow c{
      "vase", 361, Split::kReport, Method::kSdf, 0, 0.0, {}, 0.0, "a \"quoted\", long; text", true};
  return {a, b, c};
}

TEST(Rows, AreReadBackAsTheyWereAppended) {
  const TempFolder folder;
  const auto csv = folder / "rows.csv";
  EXPECT_TRUE(ReadRows(csv).empty());
  for (const auto& row : SomeRows()) AppendRow(csv, row);
  ExpectSame(ReadRows(csv), SomeRows());
  EXPECT_EQ(ReadRows(csv)[0].seconds, 1e-6);
  const std::string text = core::ReadFile(csv);
  WriteRows(csv, SomeRows());
  EXPECT_EQ(core::ReadFile(csv), text);
}

TEST(Rows, WhatAKilledRunLeftHalfWrittenIsDropped) {
  const TempFolder folder;
  const auto csv = folder / "rows.csv";
  WriteRows(csv, SomeRows());
  const std::string text = core::ReadFile(csv);
  for (std::size_t length = 0; length <= text.size(); ++length) {
    folder.Write("rows.csv", text.substr(0, length));
    const auto whole = std::count(text.begin(), text.begin() + static_cast<long>(length), '\n');
    EXPECT_EQ(ReadRows(csv).size(), static_cast<std::size_t>(std::max<long>(0, whole - 1)));
  }
}

TEST(Rows, AWholeLineThatIsNoRowIsToldWithItsPlace) {
  const TempFolder folder;
  const auto csv = folder / "rows.csv";
  WriteRows(csv, SomeRows());
  const std::string text = core::ReadFile(csv);
  const auto error = [&](const std::string& from, const std::string& to) -> std::string {
    std::string broken = text;
    broken.replace(broken.find(from), from.size(), to);
    folder.Write("rows.csv", broken);
    try {
      ReadRows(csv);
    } catch (const core::InputError& e) {
      return e.what();
    }
    return "not refused";
  };
  EXPECT_THAT(error(",21,", ",2l,"), HasSubstr("rows.csv:2: '2l' in column 'id'"));
  EXPECT_THAT(error(",mirror,", ",miror,"), HasSubstr("one of mirror, improved"));
  EXPECT_THAT(error(",report,core,1,0.25,,2.5,0,\"one part\"", ""), HasSubstr("rows.csv:3: "));
  EXPECT_THAT(error("class,id", "klass,id"), HasSubstr("rows.csv:1: "));
}

TEST(Rows, AFullDiskIsAFailedRun) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(AppendRow("/dev/full", SomeRows()[0]), core::RunError);
}

TEST(Names, AreDifferentAndStable) {
  EXPECT_STREQ(Name(Method::kMirror), "mirror");
  EXPECT_STREQ(Name(Method::kCore), "core");
  EXPECT_STREQ(Name(Split::kTune), "tune");
}

}  // namespace
}  // namespace rangegrasp::parts
