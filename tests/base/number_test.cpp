#include "base/number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace rangegrasp::base {
namespace {

TEST(NumberFrom, TakesAWholeTextOrNothing) {
  EXPECT_EQ(NumberFrom<int>("-12"), -12);
  EXPECT_EQ(NumberFrom<double>("1.5e-3"), 0.0015);
  EXPECT_TRUE(std::isinf(NumberFrom<double>("inf").value_or(0.0)));
  for (const char* text : {"", " 1", "1 ", "1x", "+1", "one", "0x10", "1,5"}) {
    EXPECT_FALSE(NumberFrom<int>(text)) << text;
    EXPECT_FALSE(NumberFrom<double>(text)) << text;
  }
  EXPECT_FALSE(NumberFrom<int>("1.5"));
}

TEST(NumberFrom, KnowsWhatItsTypeHolds) {
  EXPECT_EQ(NumberFrom<std::int8_t>("127"), 127);
  EXPECT_FALSE(NumberFrom<std::int8_t>("128"));
  EXPECT_FALSE(NumberFrom<unsigned>("-1"));
  EXPECT_FALSE(NumberFrom<double>("1e999"));
}

}  // namespace
}  // namespace rangegrasp::base
