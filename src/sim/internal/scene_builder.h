#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "robot/mjcf/files.h"
#include "sim/internal/engine.h"
#include "sim/surfaces.h"
#include "sim/world.h"

namespace rangegrasp::sim::internal {

/// One object of a compiled scene.
struct ObjectEntry {
  std::string name;
  Surface surface;
  OpticalSurface optical;   ///< from its file if given there, else from its surface
  int body = -1;            ///< root body
  int qpos = -1, dof = -1;  ///< addresses of the free joint's 7 coordinates and 6 velocities
  double radius_m = 0.0;    ///< of a sphere about the body's origin with all collision geometry
  bool parked = true;
};

struct BuiltScene {
  ModelPtr model;
  std::vector<ObjectEntry> objects;
};

using mjcf::LineAt;

/// @throws base::InputError if a file does not exist or is a folder, or as mjcf::CheckFiles.
void NeedMjcf(const std::filesystem::path& file);

/// Parses the scene, attaches object i under the prefix "<name>_<i>/" and compiles.
/// @throws base::InputError naming the file and what is wrong with it.
BuiltScene BuildScene(const std::filesystem::path& scene_mjcf,
                      const std::vector<ObjectModel>& objects, const PhysicsOptions& options);

/// An object alone.
/// @throws base::InputError also if it is not an object.
BuiltScene BuildObject(const ObjectModel& object);

/// Whether a file holds one free body and nothing else.
/// @throws base::InputError if it is not MJCF.
bool IsObject(const std::filesystem::path& mjcf);

}  // namespace rangegrasp::sim::internal
