#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "base/yaml_map.h"
#include "experiment/task.h"
#include "recognition/library.h"
#include "recognition/recognize.h"
#include "recognition/views/wrist_scanner.h"
#include "trial/options.h"

namespace rangegrasp::recognition {

/// The keys under `recognition`; reads those that every task with known objects has.
base::YamlMap RecognitionKeys(base::YamlMap& map, RecognitionOptions& options);
/// Reads the keys under `library`.
void ReadLibraryOptions(base::YamlMap& map, LibraryOptions& options);
/// Adds a hash of the folder's meshes to the stamp's identity.
void AddLibraryTo(experiment::Stamp& stamp, const LibraryOptions& library,
                  std::span<const std::string> objects);

/// The library of an experiment's objects.
/// @throws base::InputError naming the file that is not an object or not a mesh.
Library LibraryOf(const trial::Options& options, const LibraryOptions& library);

/// Options of the wrist scanner's views.
/// @throws base::InputError if `grasp` or `look` has a key that only `task: grasping` supports.
views::WristViewOptions WristViewsOf(const base::YamlMap& map, const trial::Options& options);

/// trial::ModelsPass, with a warning if only a stereo camera searches for known objects.
/// @param wrist  whether a wrist scanner is used as well
bool ModelsPass(const base::YamlMap& map, const trial::Options& options, bool wrist,
                const experiment::Common& common);

/// The library of a folder: each NAME/NAME.xml in it, or NAME.stl in metres, is a known object.
/// @throws base::InputError naming the folder if there is no known object or no such folder, or the
/// file if its size is not that of an object (check::kMinSize_m).
Library LoadLibrary(const std::filesystem::path& folder);

/// `task: recognition`: recognition of known objects and their poses. A case is one scene with a
/// target, arranged as in a grasping trial.
const experiment::TaskKind& RecognitionTask();

}  // namespace rangegrasp::recognition
