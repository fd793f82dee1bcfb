#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "grasp/proposals.h"

namespace rangegrasp::grasp {

/// A known grasp of an object, in the frame O of its model.
struct NamedGrasp {
  std::string name;               ///< "handle"
  std::vector<std::string> uses;  ///< what it is for: "drink", "pour", "hand_over"
  bool upright = false;           ///< only for an upright object, which is then kept upright
  /// One for each way to take the object with it: turned about an axis, or from either side.
  std::vector<Proposal> ways_O;
};

/// Known grasps of an object: `grasps.yaml` in its folder.
struct NamedGrasps {
  std::vector<NamedGrasp> grasps;  ///< in the file's order, best first
  /// Boxes that the hand leaves free for a person, along the axes of O.
  std::vector<Eigen::AlignedBox3d> keep_free_O;
  Eigen::Vector3d up_O = Eigen::Vector3d::UnitZ();  ///< unit: up of the object as it is used
};

/// The file of an object's grasps, next to its model.
std::filesystem::path NamedGraspsFile(const std::filesystem::path& mjcf);

/// Reads an object's grasps (docs/known-objects.md has the keys); there are none without a file.
/// @throws base::InputError naming file, line and key.
NamedGrasps ReadNamedGrasps(const std::filesystem::path& file);

/// Warnings of grasps that cannot be meant: their center between the pads is outside the object, or
/// the gap between the closed pads is wider than all of it in their direction, or than the hand
/// opens.
/// @param file  of the grasps
/// @param points_O  of the object's surface, at least one [m]
/// @param opens_m  maximum gap of the hand; nullopt: any hand
std::vector<base::Finding> CheckNamedGrasps(const NamedGrasps& known,
                                            const std::filesystem::path& file,
                                            std::span<const Eigen::Vector3d> points_O,
                                            std::optional<double> opens_m = {});

/// What the grasps are for.
std::set<std::string> UsesOf(const NamedGrasps& known);

/// Whether the object is as upright as one that is carried level (within 30 deg).
bool IsUpright(const NamedGrasps& known, const base::Pose& X_CO, const Eigen::Vector3d& up_C);

/// Whether a grasp is for a use; every grasp is for an empty use.
bool IsFor(const NamedGrasp& grasp, const std::string& use);

/// A named grasp of an object in a scene.
struct PlacedGrasp {
  Grasp grasp;
  std::size_t named = 0;  ///< position in NamedGrasps::grasps
};

/// The named grasps for a use and for the object's present orientation, placed at each of its
/// poses. Each way is checked against everything else that is perceived. Those that collide come
/// last; otherwise the order is that of the file, and for each grasp that of the poses.
/// @param poses_CO  the object's pose, and those in which a symmetric object looks the same
/// @param object  position of the object itself in scene.objects
/// @param obstacles_C  what the hand must not touch besides the other objects (ObstaclesOf)
std::vector<PlacedGrasp> PlaceNamedGrasps(const NamedGrasps& known, const std::string& use,
                                          std::span<const base::Pose> poses_CO,
                                          const perception::Scene& scene, std::size_t object,
                                          const robot::HandModel& hand, const GraspOptions& options,
                                          std::span<const geometry::TriangleMesh> obstacles_C);

/// Whether a hand with this grasp reaches into the space that must stay free: a shape of its
/// fingers or its palm intersects a box.
bool TouchesKeptFree(const Grasp& grasp, const NamedGrasps& known, const base::Pose& X_CO,
                     const robot::HandModel& hand);

}  // namespace rangegrasp::grasp
