#pragma once

#include "grasp/proposals.h"

namespace rangegrasp::grasp {

/// A grasp that is known of an object, in the frame O of its model.
struct NamedGrasp {
  std::string name;               ///< "handle"
  std::vector<std::string> uses;  ///< what it is for: "drink", "pour", "hand_over"
  bool upright = false;           ///< only for an object that is upright, and is kept so
  /// One for each of the ways in which it can be taken: turned about an axis, from either side.
  std::vector<Proposal> ways_O;
};

/// What is known of how to take an object: `grasps.yaml` in its folder.
struct NamedGrasps {
  std::vector<NamedGrasp> grasps;  ///< in the file's order: the first one suits best
  /// What the hand leaves free for a person, along the axes of O.
  std::vector<Eigen::AlignedBox3d> keep_free_O;
  Eigen::Vector3d up_O = Eigen::Vector3d::UnitZ();  ///< unit: up of the object as it is used
};

/// Reads an object's grasps (docs/known-objects.md has the keys); none where there is no file.
/// @throws base::InputError naming file, line and key.
NamedGrasps ReadNamedGrasps(const std::filesystem::path& file);

/// Whether the object is upright, as far as one that is carried level is.
bool IsUpright(const NamedGrasps& known, const base::Pose& X_CO, const Eigen::Vector3d& up_C);

/// Whether a grasp is for a use; all are where the use is empty.
bool IsFor(const NamedGrasp& grasp, const std::string& use);

/// A named grasp of an object in a scene.
struct PlacedGrasp {
  Grasp grasp;
  std::size_t named = 0;  ///< position in NamedGrasps::grasps
};

/// The named grasps that are for a use, and for the object as it lies, placed at the object's pose,
/// each way checked against everything else that is perceived: those that collide come last, else
/// in the order of the file.
/// @param X_CO  the object's pose
/// @param object  position in scene.objects: the object itself
/// @param obstacles_C  what the hand must not touch besides the other objects (ObstaclesOf)
/// @throws std::invalid_argument if there is no such object.
std::vector<PlacedGrasp> PlaceNamedGrasps(const NamedGrasps& known, const std::string& use,
                                          const base::Pose& X_CO, const perception::Scene& scene,
                                          std::size_t object, const robot::HandModel& hand,
                                          const GraspOptions& options,
                                          std::span<const geometry::TriangleMesh> obstacles_C);

/// Whether a hand that holds the object so reaches into what is to be kept free: a shape of its
/// fingers or its palm meets a box.
bool TouchesKeptFree(const Grasp& grasp, const NamedGrasps& known, const base::Pose& X_CO,
                     const robot::HandModel& hand);

}  // namespace rangegrasp::grasp
