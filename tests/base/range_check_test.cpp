#include "base/range_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "base/units.h"
#include "error_of.h"

namespace rangegrasp::base {
namespace {

const RangeCheck kCheck("lamp");

std::string Fault(const auto& check) {
  return testing_support::MessageOf<std::invalid_argument>(check);
}

TEST(RangeCheck, NamesKeyValueAndRangeInTheFilesUnit) {
  EXPECT_EQ(Fault([] { kCheck.ReadScaled("width_mm", 0.07, kMm, 0.1, 50.0, "doc"); }),
            "lamp: width_mm: 70 is out of range, must be from 0.1 to 50");
  EXPECT_EQ(Fault([] { kCheck.Read("bulbs", 9, 1, 8, "doc"); }),
            "lamp: bulbs: 9 is out of range, must be from 1 to 8");
  EXPECT_EQ(Fault([] { kCheck.Read("share", -0.1, 0.0, 1.0); }),
            "lamp: share: -0.1 is out of range, must be from 0 to 1");
}

// A bound that was read from a file and turned into SI is still within it.
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
