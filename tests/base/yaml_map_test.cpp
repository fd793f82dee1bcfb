#include "base/yaml_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "base/error.h"
#include "base/installation.h"
#include "base/units.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::base {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using testing_support::ErrorOf;
using testing_support::TempFolder;

enum class YamlMapColour { kRed, kGreen, kBlue };
constexpr std::array<std::string_view, 3> WordsOf(YamlMapColour) {
  return {"red", "green", "blue"};
}

class YamlMapTest : public testing::Test {
 protected:
  YamlMap Parse(const std::string& text) {
    return YamlMap::FromFile(file_ = folder_.Write("options.yaml", text));
  }
  /// The error must begin with file, line and key.
  auto At(int line, const std::string& key) const {
    return StartsWith(file_.string() + ":" + std::to_string(line) + ": key '" + key + "': ");
  }

  TempFolder folder_;
  std::filesystem::path file_;
};

TEST_F(YamlMapTest, ItsValuesAreListedByPathWhateverTheirStyle) {
  const YamlMap map = Parse("list:\n  - \"a\"\n  - b\nouter:\n  inner: {key: 'x'}\nnumber: 1\n");
  EXPECT_THAT(map.Values(),
              testing::ElementsAre(std::pair("list", "[a, b]"), std::pair("number", "1"),
                                   std::pair("outer.inner.key", "x")));
}

TEST_F(YamlMapTest, ValuesOfAMappingThatContainsItselfEnd) {
  EXPECT_EQ(Parse("a: &a\n  b: *a\n").Values().size(), 1u);
}

TEST_F(YamlMapTest, ReadsEveryKindOfValue) {
  YamlMap map = Parse(
      "text: hello\nyes: true\nseed: 18446744073709551615\nwords: [a, b]\ncount: -3\n"
      "length_mm: 2.5\nmaybe: 0.25\ncolour: green\nchild:\n  inner: 7\n");
  std::string text;
  bool yes = false;
  std::uint64_t seed = 0;
  std::vector<std::string> words;
  int count = 0;
  double length_m = 0.0;
  std::optional<double> maybe;
  YamlMapColour colour = YamlMapColour::kRed;
  int inner = 0;
  map.Read("text", text);
  map.Read("yes", yes);
  map.Read("seed", seed);
  map.Read("words", words);
  map.Read("count", count, -3, 3);
  map.ReadScaled("length_mm", length_m, 1e-3, 0.0, 10.0);
  map.Read("maybe", maybe, 0.0, 1.0);
  map.Read("colour", colour);
  YamlMap child = map.Child("child");
  child.Read("inner", inner, 0, 10);
  child.Finish();
  map.Finish();
  EXPECT_EQ(text, "hello");
  EXPECT_TRUE(yes);
  EXPECT_EQ(seed, ~std::uint64_t{0});
  EXPECT_EQ(words, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(count, -3);
  EXPECT_DOUBLE_EQ(length_m, 0.0025);
  EXPECT_EQ(maybe, 0.25);
  EXPECT_EQ(colour, YamlMapColour::kGreen);
  EXPECT_EQ(inner, 7);
}

TEST_F(YamlMapTest, AbsentKeysLeaveDefaultsUntouched) {
  YamlMap map = Parse("other: 1\n");
  std::string text = "default";
  bool yes = true;
  std::uint64_t seed = 5;
  std::vector<std::string> words = {"x"};
  int count = 6;
  double length_m = 7.0;
  std::optional<double> maybe;
  std::filesystem::path path = "here";
  map.Read("text", text);
  map.Read("yes", yes);
  map.Read("seed", seed);
  map.Read("words", words);
  map.Read("count", count, 0, 1);  // the default may lie outside the range
  map.ReadScaled("length_mm", length_m, 1e-3, 0.0, 1.0);
  map.Read("maybe", maybe, 0.0, 1.0);
  map.ReadPath("path", path);
  YamlMap child = map.Child("child");
  child.Read("count", count, 0, 1);
  child.Finish();
  EXPECT_EQ(text, "default");
  EXPECT_TRUE(yes);
  EXPECT_EQ(seed, 5u);
  EXPECT_EQ(words, std::vector<std::string>{"x"});
  EXPECT_EQ(count, 6);
  EXPECT_EQ(length_m, 7.0);
  EXPECT_FALSE(maybe);
  EXPECT_EQ(path, "here");
}

TEST_F(YamlMapTest, AFileThatIsNoMapOfKeysIsRefusedByName) {
  EXPECT_THAT(ErrorOf([&] { YamlMap::FromFile(folder_ / "none.yaml"); }),
              AllOf(StartsWith((folder_ / "none.yaml").string()), HasSubstr("no such file")));
  EXPECT_THAT(ErrorOf([&] { YamlMap::FromFile(folder_.path()); }),
              StartsWith(folder_.path().string()));
  for (const char* text : {"", "- a\n- b\n", "just words\n", "3\n"}) {
    EXPECT_THAT(
        ErrorOf([&] { Parse(text); }),
        AllOf(StartsWith((folder_ / "options.yaml").string() + ":1: "), HasSubstr("key: value")))
        << text;
  }
}

TEST_F(YamlMapTest, BrokenYamlIsRefusedWithItsLine) {
  const std::string error = ErrorOf([&] { Parse("a: 1\nb: [1, 2\nc: 3\n"); });
  EXPECT_THAT(error, StartsWith((folder_ / "options.yaml").string() + ":"));
  EXPECT_THAT(error, HasSubstr("not valid YAML"));
  EXPECT_THAT(ErrorOf([&] { Parse("a: 1\n\tb: 2\n"); }),
              StartsWith((folder_ / "options.yaml").string() + ":2: "));
  EXPECT_THAT(ErrorOf([&] { Parse(std::string("\x89PNG\r\n\x1a\n\0\0", 10)); }),
              StartsWith((folder_ / "options.yaml").string()));
}

TEST_F(YamlMapTest, NumbersOfTheWrongKindAreRefusedWithLineKeyAndValue) {
  double value = 1.0;
  for (const char* bad : {"abc", "nan", ".nan", ".inf", "-.inf", "inf", "1.5x", "''", "[1]",
                          "{a: 1}", "-0.1", "10.1", "1,5", "0x", "~", ""}) {
    YamlMap map = Parse(std::string("# comment\nlength: ") + bad + "\n");
    const std::string error = ErrorOf([&] { map.Read("length", value, 0.0, 10.0); });
    EXPECT_THAT(error, AllOf(At(2, "length"), HasSubstr("from 0 to 10"))) << bad;
  }
  EXPECT_EQ(value, 1.0);
  YamlMap map = Parse("length: 10.1\n");
  EXPECT_THAT(ErrorOf([&] { map.Read("length", value, 0.0, 10.0); }), HasSubstr("'10.1'"));
}

TEST_F(YamlMapTest, TheBoundsOfARangeBelongToIt) {
  double value = 1.0;
  Parse("length: 0\n").Read("length", value, 0.0, 10.0);
  EXPECT_EQ(value, 0.0);
  Parse("length: 10\n").Read("length", value, 0.0, 10.0);
  EXPECT_EQ(value, 10.0);
}

TEST_F(YamlMapTest, WholeNumbersMustBeWholeAndInRange) {
  int value = 1;
  for (const int bound : {0, 10}) {
    Parse("count: " + std::to_string(bound) + "\n").Read("count", value, 0, 10);
    EXPECT_EQ(value, bound);
  }
  for (const char* bad : {"1.5", "abc", "11", "-1", "99999999999", "[1]", "", "1e1", "true"}) {
    YamlMap map = Parse(std::string("count: ") + bad + "\n");
    EXPECT_THAT(ErrorOf([&] { map.Read("count", value, 0, 10); }),
                AllOf(At(1, "count"), HasSubstr("whole number from 0 to 10")))
        << bad;
  }
  std::uint64_t seed = 1;
  for (const char* bad : {"-1", "-0.5", "1.5", "abc", "18446744073709551616", "[1]", "", "''"}) {
    YamlMap map = Parse(std::string("seed: ") + bad + "\n");
    EXPECT_THAT(ErrorOf([&] { map.Read("seed", seed); }),
                AllOf(At(1, "seed"), HasSubstr("whole number from 0")))
        << bad;
  }
}

TEST_F(YamlMapTest, TextBoolListAndMapMustBeWhatTheyShould) {
  std::string text;
  bool yes = false;
  std::vector<std::string> words;
  for (const char* bad : {"[a]", "{a: b}", "''", ""}) {
    YamlMap map = Parse(std::string("key: ") + bad + "\n");
    EXPECT_THAT(ErrorOf([&] { map.Read("key", text); }), At(1, "key")) << bad;
  }
  for (const char* bad : {"maybe", "2", "[true]", ""}) {
    YamlMap map = Parse(std::string("key: ") + bad + "\n");
    EXPECT_THAT(ErrorOf([&] { map.Read("key", yes); }),
                AllOf(At(1, "key"), HasSubstr("true or false")))
        << bad;
  }
  for (const char* bad : {"word", "{a: b}", "[]", "[[a]]", ""}) {
    YamlMap map = Parse(std::string("key: ") + bad + "\n");
    EXPECT_THAT(ErrorOf([&] { map.Read("key", words); }), At(1, "key")) << bad;
  }
  for (const char* bad : {"word", "[a]", "3"}) {
    YamlMap map = Parse(std::string("a: 1\nkey: ") + bad + "\n");
    EXPECT_THAT(ErrorOf([&] { map.Child("key"); }), At(2, "key")) << bad;
  }
}

TEST_F(YamlMapTest, AMissingValueIsCalledMissing) {
  YamlMap map = Parse("file:\n");
  std::filesystem::path file;
  EXPECT_THAT(ErrorOf([&] { map.ReadPath("file", file); }),
              AllOf(At(1, "file"), HasSubstr("its value is missing; it must be a text")));
}

TEST_F(YamlMapTest, TheirPlacesAreThoseOfTheFileOrOfTheCommandLine) {
  YamlMap map = Parse("a: 1\nouter:\n  inner: 2\n");
  map.Override("outer.set=3");
  EXPECT_EQ(map.PlaceOf("a"), file_.string() + ":1");
  EXPECT_EQ(map.Inner("outer").PlaceOf("inner"), file_.string() + ":3");
  EXPECT_EQ(map.Inner("outer").PlaceOf("set"), "--set outer.set");
  EXPECT_EQ(map.Inner("outer").PlaceOf("a"), std::nullopt);
  EXPECT_EQ(map.Inner("none").PlaceOf("a"), std::nullopt);
}

TEST_F(YamlMapTest, AWordOfFewNamesTheNearest) {
  YamlMapColour colour = YamlMapColour::kRed;
  YamlMap map = Parse("colour: grean\n");
  EXPECT_THAT(ErrorOf([&] { map.Read("colour", colour); }),
              AllOf(At(1, "colour"), HasSubstr("'grean'"), HasSubstr("red, green, blue"),
                    HasSubstr("nearest: green")));
  EXPECT_EQ(colour, YamlMapColour::kRed);
}

TEST_F(YamlMapTest, AnUnknownKeyNamesTheNearestValidOne) {
  YamlMap map = Parse("name: a\ntrials_per_objct: 3\n");
  std::string text;
  int count = 0;
  map.Read("name", text);
  map.Read("name", text);  // a system reads it, too: it is listed once
  map.Read("trials_per_object", count, 1, 10);
  EXPECT_THAT(
      ErrorOf([&] { map.Finish(); }),
      AllOf(StartsWith(file_.string() + ":2: "), HasSubstr("unknown key 'trials_per_objct'"),
            HasSubstr("nearest valid key: 'trials_per_object'; "
                      "valid: name, trials_per_object")));
}

TEST_F(YamlMapTest, AnUnknownKeyIsSearchedInOtherMappingsToo) {
  YamlMap map = Parse("name: a\ntimestep_ms: 1\n");
  std::string text;
  double step = 0.0;
  map.Read("name", text);
  map.Child("physics").Read("timestep_ms", step, 0.0, 1.0);
  EXPECT_THAT(ErrorOf([&] { map.Finish(); }),
              HasSubstr("nearest valid key: 'physics.timestep_ms'"));
}

TEST_F(YamlMapTest, AMissingKeyNamesTheMisspeltOne) {
  YamlMap map = Parse("object: [a]\nobject_folder: b\n");
  EXPECT_THAT(ErrorOf([&] { map.Require("objects"); }), HasSubstr("is 'object' meant for it?"));
  YamlMap other = Parse("object_folder: b\n");
  EXPECT_THAT(ErrorOf([&] { other.Require("objects"); }), testing::Not(HasSubstr("meant")));
}

TEST_F(YamlMapTest, APathOfTheProgramsOwnFileIsNamed) {
  YamlMap map = Parse(
      "scene: ../scenes/tabletop.xml\nother: scenes/none.xml\n"
      "name: tabletop\nmisspelt: /home/me/line_scaner.yaml\n");
  std::filesystem::path path;
  EXPECT_THAT(ErrorOf([&] { map.ReadPath("name", path); }),
              HasSubstr("the program has " + (DataFolder() / "scenes/tabletop.xml").string()));
  EXPECT_THAT(ErrorOf([&] { map.ReadPath("misspelt", path); }),
              HasSubstr("the program has " + (DataFolder() / "models/sensors").string() +
                        "/line_scanner.yaml"));
  EXPECT_THAT(ErrorOf([&] { map.ReadPath("scene", path); }),
              HasSubstr("the program has " + (DataFolder() / "scenes/tabletop.xml").string()));
  EXPECT_THAT(ErrorOf([&] { map.ReadPath("other", path); }),
              testing::Not(HasSubstr("the program has")));
}

TEST_F(YamlMapTest, AnUnknownKeyOfAChildNamesItsOwnLineAndKeys) {
  YamlMap map = Parse("name: a\nphysics:\n  timestep: 1\n");
  YamlMap child = map.Child("physics");
  double step = 0.0;
  child.Read("timestep_ms", step, 0.0, 1.0);
  EXPECT_THAT(ErrorOf([&] { child.Finish(); }),
              AllOf(StartsWith(file_.string() + ":3: "), HasSubstr("'timestep_ms'")));
}

TEST_F(YamlMapTest, AKeyThatStandsTwiceIsRefused) {
  EXPECT_THAT(ErrorOf([&] { Parse("seed: 1\nname: x\nseed: 2\n"); }),
              AllOf(StartsWith((folder_ / "options.yaml").string() + ":3: key 'seed'"),
                    HasSubstr("twice")));
  YamlMap map = Parse("a:\n  b: 1\n  b: 2\n");
  EXPECT_THAT(ErrorOf([&] { map.Child("a"); }), At(3, "b"));
}

TEST_F(YamlMapTest, ErrorsNameTheKeysLineEvenIfTheValueBeginsLater) {
  YamlMap map = Parse("name: x\nwords:\n\n  - [a]\n");
  std::vector<std::string> words;
  EXPECT_THAT(ErrorOf([&] { map.Read("words", words); }), At(2, "words"));
}

TEST_F(YamlMapTest, RequireNamesTheMissingKey) {
  YamlMap map = Parse("name: a\n");
  map.Require("name");
  EXPECT_THAT(ErrorOf([&] { map.Require("scene"); }), AllOf(At(1, "scene"), HasSubstr("missing")));
}

TEST_F(YamlMapTest, PathsAreRelativeToTheFile) {
  folder_.Write("scenes/table.xml", "x");
  const auto file = folder_.Write(
      "experiments/e.yaml",
      "scene: ../scenes/table.xml\nabsolute: " + (folder_ / "scenes/table.xml").string() +
          "\nbad: ../scenes/tabel.xml\ndevice: /dev/zero\n");
  YamlMap map = YamlMap::FromFile(file);
  std::filesystem::path scene;
  std::filesystem::path absolute;
  std::filesystem::path bad = "kept";
  map.ReadPath("scene", scene);
  map.ReadPath("absolute", absolute);
  EXPECT_EQ(scene, folder_ / "scenes/table.xml");
  EXPECT_EQ(absolute, folder_ / "scenes/table.xml");
  EXPECT_THAT(ErrorOf([&] { map.ReadPath("bad", bad); }),
              AllOf(StartsWith(file.string() + ":3: key 'bad': "), HasSubstr("../scenes/tabel.xml"),
                    HasSubstr((folder_ / "scenes/tabel.xml").string())));
  EXPECT_THAT(ErrorOf([&] { map.ReadPath("device", bad); }),
              AllOf(HasSubstr(":4: key 'device': '/dev/zero'"), HasSubstr("device or pipe")));
  EXPECT_EQ(bad, "kept");
}

TEST(NearestWord, IsTheOneOfLeastEditDistance) {
  EXPECT_EQ(NearestWord("sead", {"name", "seed", "scene"}), "seed");
  EXPECT_EQ(NearestWord("", {"abc", "ab"}), "");  // no letter that could be right
  EXPECT_EQ(NearestWord("x", {}), "");
  EXPECT_EQ(NearestWord("kitten", {"sitting", "mitten"}), "mitten");
  // A letter changed, added or missing is one edit; the other words need two or more.
  EXPECT_EQ(NearestWord("cat", {"catch", "cut"}), "cut");
  EXPECT_EQ(NearestWord("seeds", {"trees", "seed"}), "seed");
  EXPECT_EQ(NearestWord("see", {"ate", "seed"}), "seed");
}

TEST_F(YamlMapTest, AnOverrideTakesTheFilesPlace) {
  const auto file = folder_.Write("o.yaml", "n: 1\nphysics:\n  step: 2\n");
  auto map = YamlMap::FromFile(file, {"physics.step=3", "fresh.key=0.5"});
  int n = 0, step = 0;
  double key = 0.0;
  map.Read("n", n, 0, 9);
  auto physics = map.Child("physics");
  physics.Read("step", step, 0, 9);
  physics.Finish();
  map.Child("fresh").Read("key", key, 0.0, 1.0);
  map.Finish();
  EXPECT_EQ(n, 1);
  EXPECT_EQ(step, 3);
  EXPECT_EQ(key, 0.5);
}

TEST_F(YamlMapTest, AWrongOverrideIsNamedAsSuch) {
  const auto file = folder_.Write("o.yaml", "n: 1\n");
  int n = 0;
  EXPECT_THAT(ErrorOf([&] { YamlMap::FromFile(file, {"n=12"}).Read("n", n, 0, 9); }),
              HasSubstr("--set n: key 'n': '12' must be a whole number from 0 to 9"));
  auto map = YamlMap::FromFile(file, {"outer={n: 12}"});
  EXPECT_THAT(ErrorOf([&] { map.Child("outer").Read("n", n, 0, 9); }),
              HasSubstr("--set outer.n: key 'n'"));
  EXPECT_THAT(ErrorOf([&] { YamlMap::FromFile(file, {"n"}); }), HasSubstr("must be KEY=VALUE"));
  EXPECT_THAT(ErrorOf([&] { YamlMap::FromFile(file, {"n.x=1"}); }), HasSubstr("has no keys"));
  auto other = YamlMap::FromFile(file, {"m=1"});
  other.Read("n", n, 0, 9);
  EXPECT_THAT(ErrorOf([&] { other.Finish(); }), StartsWith("--set m: unknown key 'm'"));
  auto inner = YamlMap::FromFile(file, {"m={k: 1}"});
  EXPECT_THAT(ErrorOf([&] { inner.Child("m").Finish(); }), StartsWith("--set m.k: unknown key"));
  const auto no_map = [&](const std::string& text) {
    return ErrorOf([&] { YamlMap::FromText(text, "o.yaml", {"m.k=1"}).Finish(); });
  };
  EXPECT_THAT(no_map("n: 1\n"), StartsWith("o.yaml:1: unknown key 'n'"));
  EXPECT_THAT(no_map("m: {}\n"), StartsWith("o.yaml:1: unknown key 'm'"));
  EXPECT_THAT(no_map("{}\n"), StartsWith("--set m.k: unknown key 'm'"));
}

TEST_F(YamlMapTest, AListOrMapInPlaceOfAValueIsNamedAsSuch) {
  YamlMap map = Parse("number: [1]\nlist: {a: 1}\n");
  int number = 0;
  std::vector<std::string> list;
  EXPECT_THAT(ErrorOf([&] { map.Read("number", number, 1, 30); }),
              testing::EndsWith("key 'number': must be a whole number from 1 to 30, not a list"));
  EXPECT_THAT(ErrorOf([&] { map.Read("list", list); }),
              testing::EndsWith("key 'list': must be a list, e.g. [a, b], not a map"));
}

// Results keep one override a line.
TEST_F(YamlMapTest, AnOverrideOfSeveralLinesIsRefused) {
  const auto file = folder_.Write("o.yaml", "n: 1\n");
  EXPECT_THAT(ErrorOf([&] { YamlMap::FromFile(file, {"words=\n- a\n- b"}); }),
              StartsWith("--set \"words=\\n- a\\n- b\": must be on one line"));
}

TEST_F(YamlMapTest, AKeyOfAnInnerMapIsNamedWithItsLineOrOverride) {
  const auto file = folder_.Write("o.yaml", "n: 1\nouter:\n  a: 1\n");
  const auto map = YamlMap::FromFile(file, {"outer.b=2"});
  EXPECT_EQ(ErrorOf([&] { map.Inner("outer").Fail("a", "is wrong"); }),
            file.string() + ":3: key 'a': is wrong");
  EXPECT_EQ(ErrorOf([&] { map.Inner("outer").Fail("b", "is wrong"); }),
            "--set outer.b: key 'b': is wrong");
}

TEST_F(YamlMapTest, TheReadingCodeIsTheTableOfKeys) {
  auto map = YamlMap::ForDocumentation();
  double step_s = 0.002;
  std::string name;
  map.Require("name");
  map.Read("name", name, "of the experiment");
  auto physics = map.Child("physics", "the engine");
  physics.ReadScaled("step_ms", step_s, 1e-3, 0.1, 4.0, "time step");
  physics.Finish();
  map.Finish();
  ASSERT_EQ(map.Keys().size(), 3u);
  EXPECT_TRUE(map.Keys()[0].required);
  EXPECT_EQ(map.Keys()[0].doc, "of the experiment");
  EXPECT_EQ(map.Keys()[2].path, "physics.step_ms");
  EXPECT_EQ(map.Keys()[2].default_value, "2");
  EXPECT_EQ(map.Keys()[2].range, "0.1 to 4");
}

TEST_F(YamlMapTest, TheTableOfKeysSaysWhatHasNoDefaultAndWhatAListMayHold) {
  auto map = YamlMap::ForDocumentation();
  std::optional<double> unset;
  std::optional<double> set = 0.5;
  std::vector<YamlMapColour> hues = {YamlMapColour::kRed};
  map.Read("unset", unset, 0.0, 1.0, "a");
  map.Read("set", set, 0.0, 1.0, "b");
  map.Read("hues", hues, "c");
  int deep = 4;
  auto outer = map.Child("outer", "d");
  outer.Child("inner", "e").Read("deep", deep, 0, 9, "f");
  ASSERT_EQ(map.Keys().size(), 6u);
  EXPECT_EQ(map.Keys()[0].default_value, "");
  EXPECT_EQ(map.Keys()[1].default_value, "0.5");
  EXPECT_EQ(map.Keys()[2].default_value, "[red]");
  EXPECT_EQ(map.Keys()[2].range, "of red, green, blue");
  EXPECT_EQ(map.Keys()[5].path, "outer.inner.deep");
}

TEST_F(YamlMapTest, AListOfWordsHoldsNoOthers) {
  std::vector<YamlMapColour> hues;
  Parse("hues: [green, red]\n").Read("hues", hues);
  EXPECT_EQ(hues, (std::vector{YamlMapColour::kGreen, YamlMapColour::kRed}));
  YamlMap map = Parse("hues: [red, grean]\n");
  EXPECT_THAT(ErrorOf([&] { map.Read("hues", hues); }),
              AllOf(At(1, "hues"), HasSubstr("'grean'"), HasSubstr("nearest: green")));
}

const RangeCheck kCheck("lamp");

std::string Fault(const auto& check) {
  return testing_support::MessageOf<std::invalid_argument>(check);
}

TEST(RangeCheck, NamesKeyValueAndRangeInTheFilesUnit) {
  EXPECT_EQ(Fault([] { kCheck.ReadScaled("width_mm", 0.07, kMm, 0.1, 50.0); }),
            "lamp: width_mm: 70 is out of range, must be from 0.1 to 50");
  EXPECT_EQ(Fault([] { kCheck.Read("bulbs", 9, 1, 8); }),
            "lamp: bulbs: 9 is out of range, must be from 1 to 8");
  EXPECT_EQ(Fault([] { kCheck.Read("share", -0.1, 0.0, 1.0); }),
            "lamp: share: -0.1 is out of range, must be from 0 to 1");
}

// A value that equals the bound in the file's unit is still in range after conversion to SI.
TEST(RangeCheck, BoundsSurviveTheirWayThroughUnits) {
  for (double bound = 0.1; bound < 1000.0; bound *= 1.37) {
    EXPECT_EQ(Fault([&] { kCheck.ReadScaled("a_deg", bound * kDeg, kDeg, bound, bound); }), "");
    EXPECT_EQ(Fault([&] { kCheck.ReadScaled("a_mm", bound * kMm, kMm, bound, bound); }), "");
    EXPECT_NE(Fault([&] { kCheck.Read("a", bound * 1.00001, 0.0, bound); }), "");
  }
  EXPECT_EQ(Fault([] { kCheck.Read("bulbs", 1, 1, 8); }), "");
  EXPECT_EQ(Fault([] { kCheck.Read("bulbs", 8, 1, 8); }), "");
  EXPECT_NE(Fault([] { kCheck.Read("bulbs", 0, 1, 8); }), "");
  EXPECT_NE(Fault([] { kCheck.Read("bulbs", 9, 1, 8); }), "");
}

TEST(RangeCheck, NoNumberIsInARange) {
  EXPECT_NE(Fault([] { kCheck.Read("a", std::numeric_limits<double>::quiet_NaN(), 0.0, 1.0); }),
            "");
}

}  // namespace
}  // namespace rangegrasp::base
