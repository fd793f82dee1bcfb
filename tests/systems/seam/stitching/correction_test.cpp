#include "seam/stitching/correction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "base/error.h"
#include "base/rng.h"
#include "error_of.h"

namespace rangegrasp::stitching {
namespace {

const char* const kGood =
    "<correction><time_s>1.5</time_s><valid>true</valid><edge_x_m>-0.003</edge_x_m>"
    "<deviation_m>0.02</deviation_m><stop>mat_end</stop></correction>";

Correction RandomCorrection(base::Rng& rng) {
  Correction c;
  c.time_s = rng.Uniform(0.0, 1e3);
  c.valid = rng.Uniform() < 0.5;
  c.edge_x_m = rng.Normal() * std::pow(10.0, rng.Uniform(-9.0, 3.0));
  c.deviation_m = rng.Normal();
  const std::size_t sure = rng.Index(3);
  if (sure > 0) c.sure = sure == 1;
  const std::size_t stop = rng.Index(3);
  if (stop == 1) c.stop = seam::StopReason::kMatEnd;
  if (stop == 2) c.stop = seam::StopReason::kObstacle;
  return c;
}

void ExpectSame(const Correction& a, const Correction& b) {
  EXPECT_EQ(a.time_s, b.time_s);
  EXPECT_EQ(a.valid, b.valid);
  EXPECT_EQ(a.edge_x_m, b.edge_x_m);
  EXPECT_EQ(a.deviation_m, b.deviation_m);
  EXPECT_EQ(a.sure, b.sure);
  EXPECT_EQ(a.stop, b.stop);
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::string ErrorOf(const std::string& xml) {
  return testing_support::ErrorOf([&] { FromXml(xml); });
}

TEST(Correction, ComesBackFromXmlToTheLastBit) {
  base::Rng rng(7);
  for (int i = 0; i < 1000; ++i) {
    const Correction sent = RandomCorrection(rng);
    ExpectSame(sent, FromXml(ToXml(sent)));
  }
}

TEST(Correction, IsOneLineSoThatAStreamCanBeCutAtLineEnds) {
  base::Rng rng(8);
  for (int i = 0; i < 20; ++i) {
    const std::string xml = ToXml(RandomCorrection(rng));
    EXPECT_EQ(xml.find('\n'), xml.size() - 1);
  }
}

TEST(Correction, IsReadWhateverTheLayout) {
  const Correction c = FromXml(
      "<?xml version=\"1.0\"?>\n<!-- sensor 1 -->\n<correction>\n  <deviation_m> 0.02 "
      "</deviation_m>\n"
      "  <edge_x_m>-3e-3</edge_x_m>\n  <valid>false</valid>\n  "
      "<time_s>\n1.5</time_s>\n</correction>\n");
  EXPECT_EQ(c.time_s, 1.5);
  EXPECT_FALSE(c.valid);
  EXPECT_EQ(c.edge_x_m, -3e-3);
  EXPECT_EQ(c.deviation_m, 0.02);
  EXPECT_FALSE(c.stop);
}

TEST(Correction, NumbersThatXmlCannotCarryAreTheCallersMistake) {
  Correction c;
  c.edge_x_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ToXml(c), std::invalid_argument);
  c.edge_x_m = std::numeric_limits<double>::infinity();
  EXPECT_THROW(ToXml(c), std::invalid_argument);
}

TEST(Correction, AMissingElementIsNamed) {
  ASSERT_NO_THROW(FromXml(kGood));
  EXPECT_NE(ErrorOf(Replaced(kGood, "<time_s>1.5</time_s>", "")).find("<time_s> is missing"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(kGood, "<valid>true</valid>", "")).find("<valid> is missing"),
            std::string::npos);
  EXPECT_NE(
      ErrorOf(Replaced(kGood, "<edge_x_m>-0.003</edge_x_m>", "")).find("<edge_x_m> is missing"),
      std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(kGood, "<deviation_m>0.02</deviation_m>", ""))
                .find("<deviation_m> is missing"),
            std::string::npos);
}

TEST(Correction, ABadValueIsNamedWithItsElement) {
  for (const char* bad : {"", "abc", "1.5x", "1,5", "nan", "inf", "1e999", "0x10", "1 2", "<b/>"}) {
    const std::string error = ErrorOf(Replaced(kGood, "1.5", bad));
    EXPECT_NE(error.find("<time_s>"), std::string::npos) << bad << ": " << error;
  }
  for (const char* bad : {"", "1", "TRUE", "yes"}) {
    const std::string error = ErrorOf(Replaced(kGood, "true", bad));
    EXPECT_NE(error.find("<valid>"), std::string::npos) << bad << ": " << error;
  }
  EXPECT_NE(ErrorOf(Replaced(kGood, "mat_end", "never")).find("<stop>: 'never'"),
            std::string::npos);
}

TEST(Correction, WhatIsNotOneCorrectionIsRefused) {
  for (const std::string& bad :
       {std::string(), std::string("\n"), std::string("hello"), std::string("<other/>"),
        std::string("<correction/>"), std::string(kGood) + kGood, std::string(kGood) + "x",
        std::string(kGood, 0), Replaced(kGood, "<valid>", "<speed>1</speed><valid>"),
        Replaced(kGood, "<valid>", "<time_s>2</time_s><valid>"),
        Replaced(kGood, "<valid>", "text<valid>"), std::string("\0\0\0\0", 4)}) {
    EXPECT_THROW(FromXml(bad), base::InputError) << bad;
  }
}

TEST(Correction, EveryTruncationIsRefused) {
  const std::string good = kGood;
  for (std::size_t n = 0; n < good.size(); ++n) {
    EXPECT_THROW(FromXml(good.substr(0, n)), base::InputError) << n;
  }
}

TEST(Correction, DamagedBytesAreReadAsFiniteNumbersOrRefused) {
  base::Rng rng(9);
  for (int i = 0; i < 20'000; ++i) {
    std::string xml = kGood;
    const std::size_t changes = 1 + rng.Index(4);
    for (std::size_t k = 0; k < changes; ++k) {
      const std::size_t at = rng.Index(xml.size());
      const std::size_t kind = rng.Index(3);
      if (kind == 0) xml[at] = static_cast<char>(rng.Index(256));
      if (kind == 1) xml.erase(at, 1 + rng.Index(5));
      if (kind == 2) xml.insert(at, xml.substr(rng.Index(xml.size()), rng.Index(12)));
      if (xml.empty()) break;
    }
    try {
      const Correction c = FromXml(xml);
      EXPECT_TRUE(std::isfinite(c.time_s) && std::isfinite(c.edge_x_m) &&
                  std::isfinite(c.deviation_m));
    } catch (const base::InputError&) {
    }
  }
}

}  // namespace
}  // namespace rangegrasp::stitching
