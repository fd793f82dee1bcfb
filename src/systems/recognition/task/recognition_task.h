#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "base/yaml_map.h"
#include "experiment/task.h"
#include "recognition/library.h"
#include "recognition/views/wrist_scanner.h"
#include "trial/options.h"

namespace rangegrasp::recognition {

/// Reads the keys `library`.
void ReadLibraryOptions(base::YamlMap& map, LibraryOptions& options);
/// Puts a hash of the folder's meshes into the stamp's identity.
void AddLibraryTo(experiment::Stamp& stamp, const LibraryOptions& library,
                  std::span<const std::string> objects);

/// What is known of an experiment's objects.
/// @param objects  their names
/// @throws base::InputError naming the file of what is no object, or no mesh.
Library LibraryOf(const trial::Options& options, std::span<const std::string> objects,
                  const LibraryOptions& library);

/// How the wrist looks on.
/// @throws base::InputError where `grasp` or `look` has a key that only `task: grasping` follows.
views::WristViewOptions WristViewsOf(const base::YamlMap& map, const trial::Options& options);

/// trial::ModelsPass, with a warning where nothing but a stereo camera looks for known objects.
/// @param wrist  whether a scanner on the wrist looks, too
bool ModelsPass(const base::YamlMap& map, const trial::Options& options, bool wrist,
                const experiment::Common& common);

/// The library of a folder, or of several: each NAME/NAME.xml in it is a known object; of two with
/// the same name that of the first folder counts.
/// @throws base::InputError naming the folder without one.
Library LoadLibrary(std::span<const std::filesystem::path> folders);

/// `task: recognition`: known objects are found with their poses. A case is one scene with a
/// target, arranged as a grasping trial's.
const experiment::TaskKind& RecognitionTask();

}  // namespace rangegrasp::recognition
