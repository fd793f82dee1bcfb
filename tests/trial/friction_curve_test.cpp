#include "trial/friction_curve.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace rangegrasp::trial {
namespace {

using experiment::Record;

Record Trial(const std::string& object, double friction, bool detected,
             const std::string& outcome) {
  Record record;
  record.which.group = object;
  record.result.outcome = outcome;
  record.result.data = fmt::format(R"({{"friction":{},"detected":{}}})", friction, detected);
  return record;
}

const std::vector<std::string> kObjects = {"prism", "box"};

TEST(FrictionCurve, CountsTheDetectedByBins) {
  const auto curve = FrictionCurveOf(
      {Trial("prism", 0.50, true, "dropped"), Trial("prism", 0.549, true, "delivered"),
       Trial("prism", 0.55, true, "delivered"), Trial("prism", 0.56, false, "not_segmented"),
       Trial("box", 0.60, true, "invalid_physics"), Trial("box", 0.5, true, "delivered")});
  EXPECT_EQ(curve.at("prism").at(10).detected, 2);
  EXPECT_EQ(curve.at("prism").at(10).delivered, 1);
  EXPECT_EQ(curve.at("prism").at(11).detected, 1);
  // 0.60 / 0.05 is a little below 12.
  EXPECT_EQ(curve.at("box").at(12).detected, 1);
  EXPECT_EQ(curve.at("box").at(12).delivered, 0);

  const auto grid = GridOf(curve, kObjects);
  const std::vector<std::vector<std::string>> rows = {
      {"prism", "1/2", "1/1", "-"}, {"box", "1/1", "-", "0/1"}, {"all", "2/3", "1/1", "0/1"}};
  EXPECT_EQ(grid.header,
            (std::vector<std::string>{"static friction from", "0.50", "0.55", "0.60"}));
  EXPECT_EQ(grid.rows, rows);

  const auto json = JsonOf(curve, kObjects);
  EXPECT_EQ(json[0]["object"], "prism");
  EXPECT_NEAR(json[0]["bins"][0]["low"].get<double>(), 0.50, 1e-12);
  EXPECT_EQ(json[0]["bins"][0]["delivered"], 1);
}

TEST(FrictionCurve, ThereIsNoneWhereFrictionWasNotDrawn) {
  const auto curve =
      FrictionCurveOf({Trial("prism", 0.6, true, "dropped"), Trial("prism", 0.6, true, "delivered"),
                       Trial("box", 0.5, true, "delivered")});
  EXPECT_TRUE(GridOf(curve, kObjects).rows.empty());
}

TEST(FrictionCurve, ATrialThatDiedBeforeItsDrawIsLeftOut) {
  Record died = Trial("box", 0.6, true, "crashed");
  died.result.data = "{}";
  EXPECT_TRUE(FrictionCurveOf({died}).empty());
}

}  // namespace
}  // namespace rangegrasp::trial
