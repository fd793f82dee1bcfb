#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace rangegrasp::base {

/// The folder that holds models/, scenes/ and experiments/: the one that the environment variable
/// RANGEGRASP_DATA names; else DataFolderOf the running program.
/// @throws InputError naming where it was looked for if there is none.
std::filesystem::path DataFolder();

/// The data folder of a program: `../share/rangegrasp` of the program's folder (an installed
/// program, wherever its prefix stands now); else the nearest folder above it that holds models/,
/// scenes/ and experiments/ (the source tree around a build folder).
/// @throws InputError as DataFolder.
std::filesystem::path DataFolderOf(const std::filesystem::path& program);

/// The names of the experiments in a data folder, ascending, without `.yaml`.
std::vector<std::string> ExperimentNames(const std::filesystem::path& data);

/// The file that a person means by `experiment`: that path if it exists; else, if it is a name
/// alone or `experiments/<name>`, the experiment of that name in the data folder, with or without
/// `.yaml`.
/// @throws InputError with the nearest name if there is none.
std::filesystem::path FindExperiment(const std::filesystem::path& experiment);

}  // namespace rangegrasp::base
