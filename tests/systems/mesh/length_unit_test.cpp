#include "mesh/length_unit.h"

#include <gtest/gtest.h>

namespace rangegrasp::objects {
namespace {

TEST(LengthUnit, IsGuessedFromWhatAHandMayGrasp) {
  EXPECT_EQ(GuessUnit(95.0), LengthUnit::kMm);
  EXPECT_EQ(GuessUnit(9.5), LengthUnit::kCm);
  EXPECT_EQ(GuessUnit(0.095), LengthUnit::kM);
  // 30 mm or 300 mm: in proportion 100 mm is as far from both, but 33 is nearer to 330 than to 33.
  EXPECT_EQ(GuessUnit(25.0), LengthUnit::kCm);
  EXPECT_EQ(GuessUnit(39.0), LengthUnit::kMm);
}

TEST(LengthUnit, IsNotGuessedWhereNoneMakesALikelySize) {
  EXPECT_EQ(GuessUnit(1.7), std::nullopt);
  EXPECT_EQ(GuessUnit(60000.0), std::nullopt);
  EXPECT_EQ(GuessUnit(1e-6), std::nullopt);
}

TEST(LengthUnit, InchesAre25Point4Millimetres) {
  EXPECT_DOUBLE_EQ(MetersOf(LengthUnit::kInch), 0.0254);
  EXPECT_DOUBLE_EQ(MetersOf(LengthUnit::kMm) * 1000.0, MetersOf(LengthUnit::kM));
  EXPECT_DOUBLE_EQ(MetersOf(LengthUnit::kCm) * 100.0, 1.0);
}

}  // namespace
}  // namespace rangegrasp::objects
