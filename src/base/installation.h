#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace rangegrasp::base {

/// The folder that holds models/, scenes/ and experiments/: that of the environment variable
/// RANGEGRASP_DATA; else DataFolderOf the running program, or of what SetProgram named.
/// @throws InputError naming where it was looked for if there is none.
std::filesystem::path DataFolder();

/// For a library that another program has loaded (the Python package): its own file.
void SetProgram(const std::filesystem::path& file);

/// `../share/rangegrasp` of an installed program's folder; else the nearest folder above it that
/// holds models/, scenes/ and experiments/ (the source tree around a build folder).
/// @throws InputError as DataFolder.
std::filesystem::path DataFolderOf(const std::filesystem::path& program);

/// The names of the experiments in a data folder, ascending, without `.yaml`.
std::vector<std::string> ExperimentNames(const std::filesystem::path& data);

/// That path if it exists; else, for a name or `experiments/<name>`, with or without `.yaml`, the
/// experiment of that name in the data folder.
/// @throws InputError with the nearest name if there is none.
std::filesystem::path FindExperiment(const std::filesystem::path& experiment);

/// A word of a system that this program was built without, e.g. a key's value
/// ("grasp.take=handle").
struct WordNotBuilt {
  std::string_view kind;  ///< "command", "task", "option", "key", "value"
  std::string_view word;
  std::string_view system;
};

/// Such a word was used. scripts/rangegrasp, which starts the program, may build the system and try
/// again.
class NotBuilt : public InputError {
 public:
  NotBuilt(const std::string& where, const WordNotBuilt& word);
  const std::string& system() const { return system_; }

 private:
  std::string system_;
};

/// A library is not there that is loaded when it is needed first. scripts/rangegrasp installs it.
class NotInstalled : public InputError {
 public:
  /// @param package Debian's, which holds it
  NotInstalled(const std::string& package, const std::string& what);
  const std::string& package() const { return package_; }

 private:
  std::string package_;
};

/// The texts must last as long as the program.
void AddWordNotBuilt(const WordNotBuilt& word);

/// @param where  "file:line: " or empty, begins the message
/// @throws NotBuilt for a word of a system that is not built.
void CheckBuilt(std::string_view kind, std::string_view word, const std::string& where = "");

/// The version of the source, e.g. "0.2.0".
std::string Version();
/// The commit it was built from, with "+" if files were changed; "unknown" outside a checkout.
std::string Commit();

}  // namespace rangegrasp::base
