#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "geometry/observation.h"
#include "grasp/grasp.h"

namespace rangegrasp::grasp {

/// A learned score: the probability that a grasp is delivered, from its features (features.h). Its
/// logit is a sum of gradient-boosted trees (Friedman 2001). scripts/train-grasp-score writes its
/// file.
class ScoreModel {
 public:
  /// Reads JSON: {"features": [NAME, ...], "base": LOGIT, "trees": [[NODE, ...], ...]}. A NODE is a
  /// leaf, [LOGIT], or [FEATURE, THRESHOLD, LEFT, RIGHT]: the position of a feature above and
  /// positions of later nodes; LEFT applies if the feature is <= the threshold. Other keys are
  /// ignored.
  /// @throws base::InputError naming the file and what is wrong in it, e.g. an unknown feature.
  explicit ScoreModel(const std::filesystem::path& file);

  /// @param features  one value per name of FeatureNames()
  double Probability(std::span<const double> features) const;

  /// Sets the probabilities of an object's grasps and sorts them: free ones first, the most
  /// probable of them first.
  /// @param object  position in scene.objects
  void Rank(const geometry::Observation& observation, const perception::Scene& scene,
            std::size_t object, const robot::HandModel& hand, std::vector<Grasp>& grasps) const;

  /// Plans an object's grasps, more of them than the rules choose among, and ranks them.
  /// @param options  for the rules; their bounds are widened here
  /// @param obstacles_C  as PlanGrasps takes them
  std::vector<Grasp> Plan(const geometry::Observation& observation, const perception::Scene& scene,
                          std::size_t object, const robot::HandModel& hand, const Arm& arm,
                          GraspOptions options,
                          std::span<const geometry::TriangleMesh> obstacles_C) const;

 private:
  struct Node {
    std::size_t feature = 0;            ///< position in FeatureNames()
    double value = 0.0;                 ///< threshold, or a leaf's logit
    std::array<std::size_t, 2> next{};  ///< 0: a leaf
  };
  double base_ = 0.0;
  std::vector<std::vector<Node>> trees_;
};

}  // namespace rangegrasp::grasp
