#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "experiment/task.h"
#include "recognition/library.h"
#include "trial/options.h"

namespace rangegrasp::recognition {

/// What is seen of an experiment's objects, as a library.
/// @param objects  their names
/// @throws base::InputError naming the file of what is no object.
Library LibraryOf(const trial::Options& options, std::span<const std::string> objects);

/// The library of a folder, or of several: each NAME/NAME.xml in it is a known object; of two with
/// the same name that of the first folder counts.
/// @throws base::InputError naming the folder without one.
Library LoadLibrary(std::span<const std::filesystem::path> folders);

/// `task: recognition`: known objects are found with their poses. A case is one scene with a
/// target, arranged as a grasping trial's.
const experiment::TaskKind& RecognitionTask();

}  // namespace rangegrasp::recognition
