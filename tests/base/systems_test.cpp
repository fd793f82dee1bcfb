#include "base/systems.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/yaml_map.h"
#include "error_of.h"

namespace rangegrasp::base {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// What CMake writes of systems that are left out, for words that no system has.
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
  EXPECT_THAT(testing_support::ErrorOf([] { CheckBuilt("command", "juggle"); }),
              AllOf(HasSubstr("command 'juggle'"), HasSubstr("the system 'circus'"),
                    HasSubstr("-DRANGEGRASP_SYSTEMS=circus")));
  EXPECT_EQ(SystemMissingFor([] { CheckBuilt("command", "juggle"); }), "circus");
}

TEST_F(SystemsTest, OtherWordsAndOtherKindsOfWordsAreNot) {
  EXPECT_NO_THROW(CheckBuilt("command", "run"));
  EXPECT_NO_THROW(CheckBuilt("task", "juggle"));
}

TEST_F(SystemsTest, AKeyOfAFileSaysWhereItStandsAndWhoseItIs) {
  const auto read = [](const std::string& text) {
    auto map = YamlMap::FromText(text, "show.yaml");
    auto show = map.Child("show");
    std::string kind = "theatre";
    show.Read("kind", kind, {"theatre", "opera"}, "of show");
    show.Finish();
    map.Finish();
  };
  EXPECT_THAT(
      testing_support::ErrorOf([&] { read("show:\n  clowns: 3\n"); }),
      AllOf(HasSubstr("show.yaml:2: "), HasSubstr("key 'show.clowns'"), HasSubstr("'circus'")));
  EXPECT_EQ(SystemMissingFor([&] { read("show: {clowns: 3}\n"); }), "circus");
  EXPECT_EQ(SystemMissingFor([&] { read("show: {kind: circus}\n"); }), "circus");
  EXPECT_EQ(SystemMissingFor([&] { read("show: {kind: opera}\n"); }), "");
  // A misspelt word is nobody's.
  EXPECT_THAT(testing_support::ErrorOf([&] { read("show: {clown: 3}\n"); }),
              HasSubstr("unknown key 'clown'"));
  EXPECT_EQ(SystemMissingFor([&] {
              try {
                read("show: {kind: circuss}\n");
              } catch (const NotBuilt&) {
                throw;
              } catch (const InputError&) {
              }
            }),
            "");
}

}  // namespace
}  // namespace rangegrasp::base
