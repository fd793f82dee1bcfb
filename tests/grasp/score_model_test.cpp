#include "grasp/score_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "error_of.h"
#include "grasp/features.h"
#include "temp_folder.h"

namespace rangegrasp::grasp {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::vector<double> With(std::string_view name, double value,
                         std::vector<double> features = std::vector(FeatureNames().size(), 0.0)) {
  const auto names = FeatureNames();
  const auto found = std::ranges::find(names, name);
  EXPECT_NE(found, names.end());
  features[static_cast<std::size_t>(found - names.begin())] = value;
  return features;
}

double Sigmoid(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

class Model : public ::testing::Test {
 protected:
  ScoreModel Read(const std::string& text) { return ScoreModel(files_.Write("model.json", text)); }
  std::string ErrorOf(const std::string& text) {
    return testing_support::ErrorOf([&] { Read(text); });
  }
  testing_support::TempFolder files_;
};

TEST_F(Model, TheLogitIsTheSumOfTheLeaves) {
  const ScoreModel model = Read(R"({"features": ["width", "shadow"], "base": 0.25, "trees": [
      [[0, 0.05, 1, 2], [1.0], [1, 0.5, 3, 4], [-0.5], [-2.0]],
      [[0.125]]], "card": {"grasps": 7}})");
  EXPECT_DOUBLE_EQ(model.Probability(With("width", 0.04)), Sigmoid(0.25 + 1.0 + 0.125));
  EXPECT_DOUBLE_EQ(model.Probability(With("width", 0.05)), Sigmoid(0.25 + 1.0 + 0.125))
      << "left where it is as large as the threshold";
  EXPECT_DOUBLE_EQ(model.Probability(With("width", 0.06)), Sigmoid(0.25 - 0.5 + 0.125));
  EXPECT_DOUBLE_EQ(model.Probability(With("shadow", 0.7, With("width", 0.06))),
                   Sigmoid(0.25 - 2.0 + 0.125));
}

TEST_F(Model, WhatIsWrongInAFileIsNamed) {
  EXPECT_THAT(ErrorOf("no json"), AllOf(HasSubstr("model.json"), HasSubstr("score model")));
  EXPECT_THAT(ErrorOf(R"({"features": [], "trees": []})"), HasSubstr("'base'"));
  EXPECT_THAT(ErrorOf(R"({"features": [], "base": 0})"), HasSubstr("'trees'"));
  EXPECT_THAT(ErrorOf(R"({"features": ["widht"], "base": 0, "trees": []})"),
              HasSubstr("did you mean 'width'"));
  const auto tree = [](const std::string& nodes) {
    return R"({"features": ["width"], "base": 0, "trees": [)" + nodes + "]}";
  };
  EXPECT_THAT(ErrorOf(tree("[]")), HasSubstr("trees[0] has no node"));
  for (const char* nodes :
       {"[[0, 0.1, 0, 1], [1]]", "[[0, 0.1, 1, 7], [1]]", "[[3, 0.1, 1, 1], [1]]",
        "[[0, 0.1, 1], [1]]", "[[\"a\"]]", "[7]", "[[0, 0.1, 1.5, 1], [1]]"}) {
    EXPECT_THAT(ErrorOf(tree(nodes)), HasSubstr("trees[0][0]")) << nodes;
  }
  constexpr std::size_t kDeep = 200000;  // written with recursion, it would end the program
  const std::string deep = ErrorOf(tree(std::string(kDeep, '[') + std::string(kDeep, ']')));
  EXPECT_THAT(deep, HasSubstr("trees[0][0] is [[["));
  EXPECT_LT(deep.size(), 300u);
}

}  // namespace
}  // namespace rangegrasp::grasp
