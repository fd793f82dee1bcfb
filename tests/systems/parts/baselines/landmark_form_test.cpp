#include "parts/baselines/internal/landmark_form.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "parts/graphs.h"

namespace rangegrasp::parts {
namespace {

/// Three arms of `length` links of one from node 0; arm a holds nodes 1 + a * length and on.
VertexGraph Star(std::uint32_t length) {
  std::vector<std::vector<std::uint32_t>> links(1 + 3 * length);
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    links[a].push_back(b);
    links[b].push_back(a);
  };
  for (std::uint32_t arm = 0; arm < 3; ++arm) {
    const std::uint32_t first = 1 + arm * length;
    join(0, first);
    for (std::uint32_t k = 1; k < length; ++k) join(first + k - 1, first + k);
  }
  return samples::GraphOf(links);
}

bool IsTip(std::uint32_t node, std::uint32_t length) { return node > 0 && node % length == 0; }

// With every node a landmark, its distances and neighbors are the graph's own.
TEST(LandmarkForm, OfAStarHasTheArmsTipsAsFeaturePoints) {
  constexpr std::uint32_t kLength = 6;
  const VertexGraph star = Star(kLength);
  std::vector<bool> cut(star.Size(), false);
  const LandmarkForm form = MakeLandmarkForm(star, cut, static_cast<int>(star.Size()));
  ASSERT_EQ(form.size(), star.Size());
  const std::vector<bool> all(form.size(), true);
  const std::vector<bool> feature = FeaturePoints(form, all);
  for (std::uint32_t i = 0; i < form.size(); ++i) {
    const std::uint32_t node = form.spread.landmark[i];
    EXPECT_EQ(feature[i], IsTip(node, kLength)) << node;
    EXPECT_EQ(form.neighbors[i].size(), star.begin[node + 1] - star.begin[node]) << node;
  }
  // Neither what is not on the hull nor what lies at a cut.
  EXPECT_EQ(std::count(feature.begin(), feature.end(), true), 3);
  const auto none = FeaturePoints(form, std::vector<bool>(form.size(), false));
  EXPECT_EQ(std::count(none.begin(), none.end(), true), 0);
  cut[kLength] = true;  // the first arm's tip
  const LandmarkForm cut_form = MakeLandmarkForm(star, cut, static_cast<int>(star.Size()));
  const auto two = FeaturePoints(cut_form, all);
  EXPECT_EQ(std::count(two.begin(), two.end(), true), 2);
}

}  // namespace
}  // namespace rangegrasp::parts
