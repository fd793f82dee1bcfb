#include "base/draw/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace rangegrasp::draw {
namespace {

using testing::HasSubstr;
using testing::Not;

int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(Ticks, AreRoundCoverTheRangeAndAreFew) {
  for (double scale = 1e-6; scale < 1e7; scale *= 3.7) {
    for (double low = -2.0; low < 2.0; low += 0.37) {
      const auto ticks = Ticks(low * scale, (low + 1.3) * scale);
      ASSERT_GE(ticks.size(), 4U);
      ASSERT_LE(ticks.size(), 11U);
      const double step = ticks[1] - ticks[0];
      EXPECT_LT(ticks.front() - step, low * scale);
      EXPECT_GT(ticks.back() + step, (low + 1.3) * scale);
      const double mantissa = step / std::pow(10.0, std::floor(std::log10(step * 1.000001)));
      EXPECT_TRUE(std::abs(mantissa - 1) < 1e-6 || std::abs(mantissa - 2) < 1e-6 ||
                  std::abs(mantissa - 5) < 1e-6)
          << mantissa;
    }
  }
}

TEST(Ticks, RoundEndsAreTicks) {
  for (int k = 4; k <= 7; ++k) EXPECT_NEAR(Ticks(0.0, k / 10.0).back(), k / 10.0, 1e-12) << k;
}

TEST(PlotSvg, ALineGoesThroughItsPointsAndBreaksAtWhatIsMissing) {
  Panel panel;
  const double none = std::numeric_limits<double>::quiet_NaN();
  panel.series.push_back({"a", {10, 11, 12, 13, 14}, {0, 1, none, 1, 0}});
  panel.y_range = {{0.0, 1.0}};
  const std::string svg = PlotSvg({panel}, 190, 175);  // 100 x 100 pixels from (70, 30)
  EXPECT_EQ(Count(svg, "<polyline"), 2);
  EXPECT_THAT(svg, HasSubstr("points=\"70.00,130.00 95.00,30.00 \""));
  EXPECT_THAT(svg, HasSubstr("points=\"145.00,30.00 170.00,130.00 \""));
}

TEST(PlotSvg, EqualAxesHaveOneUnit) {
  Panel panel;
  panel.series.push_back({"", {0, 1, 4}, {0, 1, 0}});
  panel.equal_axes = true;
  panel.y_range = {{0.0, 1.0}};
  // Both axes have 25 pixels per unit and keep their center.
  EXPECT_THAT(PlotSvg({panel}, 190, 175),
              HasSubstr("points=\"70.00,92.50 95.00,67.50 170.00,92.50 \""));
}

TEST(PlotSvg, DotsMarkersAndLegendStandWhereTheyShould) {
  Panel panel;
  panel.series.push_back({"first", {0, 1, 4}, {0, 1, 0}});
  panel.series.push_back({"second", {0, 1, 4}, {0, 1, 0}});
  panel.series.back().dots = true;
  panel.markers.push_back({1.0, "here"});
  panel.y_range = {{0.0, 1.0}};
  const std::string svg = PlotSvg({panel}, 190, 175);
  EXPECT_EQ(Count(svg, "<polyline"), 1);
  EXPECT_EQ(Count(svg, "<circle"), 3);
  EXPECT_THAT(svg, HasSubstr("<circle cx=\"95.00\" cy=\"30.00\""));
  EXPECT_THAT(svg, HasSubstr("<line x1=\"95.00\" y1=\"30.00\" x2=\"95.00\" y2=\"130.00\" "
                             "stroke=\"#d62728\""));
  const auto line_of = [&](const std::string& text) {
    const auto end = svg.find(">" + text + "</text>");
    const auto begin = svg.rfind(" y=\"", end);
    return std::stod(svg.substr(begin + 4));
  };
  EXPECT_GT(line_of("second"), line_of("first") + 10.0);  // lines of text do not overlap
}

TEST(PlotSvg, PanelsStandBelowEachOtherAndAreClipped) {
  Panel panel;
  panel.series.push_back({"", {0, 1, 4}, {0, 1, 0}});
  panel.y_range = {{0.0, 1.0}};
  const std::string svg = PlotSvg({panel, panel}, 190, 175);
  EXPECT_THAT(svg, HasSubstr("points=\"70.00,130.00 95.00,30.00 170.00,130.00 \""));
  EXPECT_THAT(svg, HasSubstr("points=\"70.00,305.00 95.00,205.00 170.00,305.00 \""));
  for (const char* id : {"panel0", "panel1"}) {
    EXPECT_EQ(Count(svg, std::string("<clipPath id=\"") + id + "\">"), 1);
    EXPECT_EQ(Count(svg, std::string("clip-path=\"url(#") + id + ")\""), 1);
  }
}

TEST(PlotSvg, InfinityDoesNotWidenTheAxes) {
  Panel with, without;
  with.series.push_back({"", {0, 1, 2, INFINITY}, {0, 1, INFINITY, 0}});
  without.series.push_back({"", {0, 1}, {0, 1}});
  without.series[0].x.push_back(2.0);
  without.series[0].y.push_back(NAN);
  EXPECT_EQ(PlotSvg({with}), PlotSvg({without}));
}

TEST(PlotSvg, TextIsEscapedAndNothingIsNan) {
  Panel panel;
  panel.title = "a < b & c";
  const std::string svg = PlotSvg({panel});
  EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; c"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(PlotSvg, BarsAreAsHighAsTheirValues) {
  const BarChart chart{"", "", {"g", "h"}, {"s", "t"}, {{1.0, 2.0}, {0.5, NAN}}};
  const std::string svg = PlotSvg(chart);
  EXPECT_EQ(Count(svg, "<rect"), 1 + 3);  // the background and three bars
  // 360 - 30 - 45 - 20 pixels are 1.05 * 2, so a bar of value 2 has 252.38 pixels, of value 1 half.
  EXPECT_THAT(svg, HasSubstr("height=\"252.38\""));
  EXPECT_THAT(svg, HasSubstr("height=\"126.19\""));
  // Two groups share 810 pixels from 70 on; the first tenth of each group's width is left free.
  EXPECT_THAT(svg, HasSubstr("<rect x=\"110.50\""));
  EXPECT_THAT(svg, HasSubstr("<rect x=\"272.50\""));
}

}  // namespace
}  // namespace rangegrasp::draw
