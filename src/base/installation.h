#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace rangegrasp::base {

/// The folder that contains models/, scenes/ and experiments/: the one in the environment variable
/// RANGEGRASP_DATA, or else DataFolderOf the running program or of the file given to SetProgram.
/// @throws InputError listing the searched places if it is not found.
std::filesystem::path DataFolder();

/// For a library that another program has loaded (the Python package): sets the library's own file.
void SetProgram(const std::filesystem::path& file);

/// `../share/rangegrasp` next to an installed program's folder; else the nearest folder above it
/// that contains models/, scenes/ and experiments/ (the source tree around a build folder).
/// @throws InputError as DataFolder.
std::filesystem::path DataFolderOf(const std::filesystem::path& program);

/// The names of the experiments in a data folder, sorted, without `.yaml`.
std::vector<std::string> ExperimentNames(const std::filesystem::path& data);

/// The given path if it exists. Otherwise, for a name or `experiments/<name>`, with or without
/// `.yaml`, the experiment of that name in the data folder.
/// @throws InputError with the nearest name if there is none.
std::filesystem::path FindExperiment(const std::filesystem::path& experiment);

/// A word of a system that is not built, e.g. a key's value ("grasp.take=handle").
struct WordNotBuilt {
  std::string_view kind;  ///< "command", "task", "option", "key", "value"
  std::string_view word;
  std::string_view system;
};

/// Thrown if such a word was used. scripts/rangegrasp may build the system and try again.
class NotBuilt : public InputError {
 public:
  NotBuilt(const std::string& where, const WordNotBuilt& word);
  const std::string& system() const { return system_; }

 private:
  std::string system_;
};

/// A library that is loaded on first use is missing. scripts/rangegrasp installs it.
class NotInstalled : public InputError {
 public:
  /// @param package  Debian's package that contains the library
  NotInstalled(const std::string& package, const std::string& what);
  const std::string& package() const { return package_; }

 private:
  std::string package_;
};

/// The texts must live as long as the program.
void AddWordNotBuilt(const WordNotBuilt& word);

/// The words of a kind that belong to systems that are not built, sorted.
std::vector<std::string> WordsNotBuilt(std::string_view kind);

/// @param where  start of the message: "file:line: " or empty
/// @throws NotBuilt for a word of a system that is not built.
void CheckBuilt(std::string_view kind, std::string_view word, const std::string& where = "");

/// The version of the source, e.g. "0.2.0".
std::string Version();
/// The commit of the build, with "+" if files were changed; "unknown" outside a checkout.
std::string Commit();

}  // namespace rangegrasp::base
