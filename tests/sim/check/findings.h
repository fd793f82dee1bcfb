#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/error.h"

namespace rangegrasp::testing_support {

inline std::string TextOfAll(const std::vector<base::Finding>& findings) {
  std::string text;
  for (const auto& finding : findings) text += base::TextOf(finding) + "\n";
  return text;
}

/// Expects one finding, with a cure, whose text contains all these words.
inline void ExpectOneFinding(const std::vector<base::Finding>& findings,
                             const std::vector<std::string>& words, bool error) {
  ASSERT_EQ(findings.size(), 1u) << TextOfAll(findings);
  EXPECT_EQ(findings[0].error, error);
  EXPECT_NE(base::CureOf(findings[0]), "");
  for (const std::string& word : words) {
    EXPECT_THAT(base::TextOf(findings[0]), ::testing::HasSubstr(word));
  }
}

}  // namespace rangegrasp::testing_support
