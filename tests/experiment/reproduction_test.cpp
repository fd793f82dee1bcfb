#include "experiment/reproduction.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "experiment/format.h"

namespace rangegrasp::experiment {
namespace {

using testing::HasSubstr;
using testing::Not;

// A table of one better and one worse figure that is whole, one that was begun, one without
// results, one that cannot be run.
Reproduction Some(bool is_short) {
  const auto figure = [](const char* row, Share own, Share published) {
    return PublishedFigure{.row = row,
                           .unit = "%",
                           .published = 100.0 * published.k / published.n,
                           .own = 100.0 * own.k / own.n,
                           .evidence = TrialsEvidence{own, published}};
  };
  Reproduction all{is_short, {}, {}};
  all.tables.push_back({.number = "5.2", .title = "alone", .experiment = "single"});
  all.tables[0].done = all.tables[0].cases = 20;
  all.tables[0].judged =
      Judge({figure("cup", {10, 10}, {0, 10}), figure("box", {0, 10}, {10, 10})});
  all.tables.push_back({.number = "5.3", .title = "touching", .experiment = "touching"});
  all.tables[1].done = 3;
  all.tables[1].cases = 20;
  all.tables.push_back({.number = "5.4", .title = "box", .experiment = "box"});
  all.tables[2].cases = 20;
  all.tables.push_back({.number = "6.1", .title = "parts", .experiment = "parts"});
  all.tables[3].left_out = "there is no folder psb";
  return all;
}

std::string TextOf(const Reproduction& all, TableFormat format) {
  return Format(PageOf(all), all.stamp, format);
}

TEST(Page, TellsOfEachTableHowFarItIsAndWhyItIsNotThere) {
  const std::string text = TextOf(Some(false), TableFormat::kMarkdown);
  EXPECT_THAT(text, HasSubstr("| 5.2 | alone | single | done | 20 | 2 | 1 | 0 | 1 | 0 |"));
  EXPECT_THAT(text, HasSubstr("| 5.3 | touching | touching | 3 of 20 cases |"));
  EXPECT_THAT(text, HasSubstr("| 5.4 | box | box | not run yet |"));
  EXPECT_THAT(text, HasSubstr("| 6.1 | parts | parts | left out |"));
  EXPECT_THAT(text, HasSubstr("6.1 is left out: there is no folder psb"));
  EXPECT_THAT(text, HasSubstr("| cup | 0.0 | 100.0 | % | higher | 10 of 10, published 0 of 10 |"));
  EXPECT_THAT(text, HasSubstr("Fisher's exact test"));
  EXPECT_THAT(text, Not(HasSubstr("weak")));
}

TEST(Page, SaysThatVerdictsOfAShortRunAreWeak) {
  const std::string text = TextOf(Some(true), TableFormat::kMarkdown);
  EXPECT_THAT(text, HasSubstr("| better (weak) |"));
  EXPECT_THAT(text, HasSubstr("| worse (weak) |"));
  EXPECT_THAT(text, HasSubstr("weak: of a tenth of the trials"));
}

TEST(Page, IsTheSameForPrograms) {
  const auto json = nlohmann::json::parse(TextOf(Some(true), TableFormat::kJson));
  EXPECT_EQ(json["short"], true);
  ASSERT_EQ(json["tables"].size(), 4u);
  EXPECT_EQ(json["tables"][0]["rows"][1]["verdict"], "worse");
  EXPECT_EQ(json["tables"][0]["rows"][1]["reproduced"], 0.0);
  EXPECT_EQ(json["tables"][3]["left_out"], "there is no folder psb");
  const std::string csv = TextOf(Some(true), TableFormat::kCsv);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_THAT(csv, HasSubstr("5.2,single,cup,%,0,0,100,\"10 of 10, published 0 of 10\","));
}

}  // namespace
}  // namespace rangegrasp::experiment
