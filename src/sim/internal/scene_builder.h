#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/internal/engine.h"
#include "sim/surfaces.h"
#include "sim/visual_mesh.h"
#include "sim/world.h"

namespace rangegrasp::sim::internal {

/// One object of a compiled scene.
struct ObjectEntry {
  std::string name;
  Surface surface;
  OpticalSurface optical;    ///< its own, where its file says so, else its surface's
  int body = -1, tree = -1;  ///< root body, kinematic tree
  int qpos = -1, dof = -1;   ///< addresses of the free joint's 7 coordinates and 6 velocities
  double radius_m = 0.0;  ///< of a ball round the body's origin that holds all collision geometry
  bool parked = true;
};

struct BuiltScene {
  ModelPtr model;
  std::vector<ObjectEntry> objects;
};

/// @throws base::InputError if a file is not there, or is a folder.
void NeedMjcf(const std::filesystem::path& file);

/// Parses the scene, attaches object i under the prefix "<name>_<i>/" and compiles.
/// @throws base::InputError naming the file and what is wrong with it.
BuiltScene BuildScene(const std::filesystem::path& scene_mjcf,
                      const std::vector<ObjectModel>& objects, const PhysicsOptions& options);

/// An object alone. @throws base::InputError also if it is none.
BuiltScene BuildObject(const ObjectModel& object);

/// Whether a file holds one free body and nothing else. @throws base::InputError if it is no MJCF.
bool IsObject(const std::filesystem::path& mjcf);

}  // namespace rangegrasp::sim::internal
