#include "parts/stretched/limbs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "parts/figure.h"
#include "parts/stretched/pose_invariant.h"

namespace rangegrasp::parts {
namespace {

/// A tree of rods of elements: rod k starts at the end of another and has so many elements, each
/// 0.1 further out.
StandingOut Rods(const std::vector<std::pair<int, int>>& parent_and_length) {
  StandingOut out;
  std::vector<std::vector<std::uint32_t>> links(1);
  std::vector<std::uint32_t> end;
  out.growth.push_back(1.0);
  for (const auto& [parent, length] : parent_and_length) {
    std::uint32_t at = parent < 0 ? 0 : end[static_cast<std::size_t>(parent)];
    for (int k = 0; k < length; ++k) {
      const auto next = static_cast<std::uint32_t>(out.growth.size());
      out.growth.push_back(out.growth[at] + 0.1);
      links.emplace_back();
      links[at].push_back(next);
      links[next].push_back(at);
      at = next;
    }
    end.push_back(at);
  }
  out.remoteness = out.growth;
  out.weight.assign(out.growth.size(), 1.0);
  out.begin.push_back(0);
  for (const auto& around : links) {
    out.neighbor.insert(out.neighbor.end(), around.begin(), around.end());
    out.begin.push_back(static_cast<std::uint32_t>(out.neighbor.size()));
  }
  return out;
}

int Count(const StandingOut& out) {
  const auto label = LabelLimbs(out, {});
  return *std::max_element(label.begin(), label.end());
}

TEST(LabelLimbs, AChestFallsApartAndAnArmWithFingersStaysWhole) {
  EXPECT_EQ(Count(Rods({{-1, 10}})), 1);
  EXPECT_EQ(Count(Rods({{-1, 5}, {0, 10}, {0, 12}, {0, 8}})), 3);  // 10 on average, above 5
  EXPECT_EQ(Count(Rods({{-1, 10}, {0, 5}, {0, 4}, {0, 5}})), 1);
  // Both at once: a chest with two arms that have fingers.
  EXPECT_EQ(Count(Rods({{-1, 5}, {0, 12}, {0, 12}, {1, 4}, {1, 4}, {2, 4}, {2, 4}})), 2);
}

TEST(LabelLimbs, WhatDoesNotLeadAwayIsTheCores) {
  StandingOut out = Rods({{-1, 10}, {-1, 10}});
  for (std::size_t i = 11; i < out.growth.size(); ++i) out.remoteness[i] = 1.0;
  EXPECT_EQ(Count(out), 1);
  EXPECT_TRUE(LabelLimbs({}, {}).empty());
}

TEST(LabelLimbs, AHeadWhoseEarsDoNotLeadAwayStaysWhole) {
  StandingOut out = Rods({{-1, 5}, {0, 10}, {0, 10}});
  for (std::size_t i = 6; i < out.growth.size(); ++i) out.remoteness[i] = out.remoteness[5];
  const std::vector<std::int32_t> label = LabelLimbs(out, {});
  EXPECT_EQ(label.front(), 0);
  EXPECT_EQ(std::count(label.begin(), label.end(), 1), 25);
}

/// Head, arms and legs are a part each, and there is no other.
void ExpectFiveLimbs(const Shape& shape, const geometry::Points& tips) {
  const Segmentation result = SegmentPoseInvariant(shape, {});
  EXPECT_EQ(result.parts, 6);
  std::set<std::int32_t> found;
  for (const Eigen::Vector3d& tip : tips) {
    std::size_t nearest = 0;
    const auto distance = [&](std::size_t i) {
      return (shape.points[shape.IsMesh() ? shape.faces[i][0] : i] - tip).norm();
    };
    for (std::size_t i = 0; i < shape.Elements(); ++i) {
      if (distance(i) < distance(nearest)) nearest = i;
    }
    found.insert(result.label[nearest]);
  }
  EXPECT_EQ(found.size(), 5u);
  EXPECT_FALSE(found.contains(0));
}

class Postures : public ::testing::TestWithParam<std::tuple<std::size_t, std::size_t>> {};

TEST_P(Postures, HeadArmsAndLegsComeOffInEveryPosture) {
  const auto [build, posture] = GetParam();
  samples::Figure figure =
      samples::FigureMaker(samples::kBuilds[build], samples::kPostures[posture]).Make(0.035);
  ExpectFiveLimbs(figure.shape, figure.tips);
  figure.shape.faces.clear();
  figure.shape.element_of_input.resize(figure.shape.points.size());
  ExpectFiveLimbs(figure.shape, figure.tips);
}
INSTANTIATE_TEST_SUITE_P(People, Postures,
                         ::testing::Combine(::testing::Range<std::size_t>(0, 3),
                                            ::testing::Range<std::size_t>(0, 5)));

}  // namespace
}  // namespace rangegrasp::parts
