#pragma once

#include <span>
#include <string>
#include <vector>

#include "geometry/mesh.h"
#include "grasp/grasp.h"
#include "grasp/grasp_options.h"
#include "perception/scene.h"
#include "robot/hand_model.h"

namespace rangegrasp::grasp {

/// `take: anywhere`: by the grasps of chapter 5, without a selector.
inline constexpr const char* kAnywhere = "anywhere";

/// Grasps at a chosen place of an object.
struct SelectedGrasps {
  std::vector<Grasp> grasps;  ///< free ones first, the best of these first
  std::string why_none;       ///< what is missing where there is none
};

/// Decides where an object is taken, e.g. by its handle. Sees what was perceived, and no truth.
struct GraspSelector {
  std::string word;   ///< of the key grasp.take, and the name of its grasps
  std::string about;  ///< for the key's documentation: "by the handle ..."
  /// Changes what was perceived before grasps are looked for; may be null.
  void (*prepare)(perception::Scene& scene) = nullptr;
  /// @param object  position in scene.objects
  /// @param obstacles_C  what the hand must not touch besides the other objects
  SelectedGrasps (*plan)(const perception::Scene& scene, std::size_t object,
                         const robot::HandModel& hand, const GraspOptions& options,
                         std::span<const geometry::TriangleMesh> obstacles_C) = nullptr;
  /// What is held there would creep about the pads: the strongest grip at once.
  bool firm = false;
};

void AddGraspSelector(const GraspSelector& selector);
/// Of a word of grasp.take; null: anywhere.
const GraspSelector* FindGraspSelector(const std::string& word);
/// kAnywhere and those of all selectors.
std::vector<std::string> GraspSelectorWords();

}  // namespace rangegrasp::grasp
