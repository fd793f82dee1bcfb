#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "experiment/result.h"

namespace rangegrasp::experiment {

/// The results of a run: one SQLite file (WAL), one transaction a trial, so that a run killed at
/// any moment loses nothing that it had finished. One process writes; others may read meanwhile.
/// Errors of the database (a full disk, a folder that cannot be written, no database) are
/// core::RunError or, where the file itself is not what it should be, core::InputError; both name
/// the file.
class Store {
 public:
  /// Opens for writing, creating folder and file where they are absent.
  static Store Create(const std::filesystem::path& folder);
  /// Opens for reading. @throws core::InputError if there are no results in the folder.
  static Store Open(const std::filesystem::path& folder);
  /// Whether the folder holds results.
  static bool Exists(const std::filesystem::path& folder);
  ~Store();
  Store(Store&&) noexcept;

  const std::filesystem::path& file() const;

  /// The stamp: name -> value (version, commit, hashes, seed, ...).
  void WriteStamp(const std::map<std::string, std::string>& stamp);
  std::map<std::string, std::string> ReadStamp() const;

  /// Writes one trial; a trial of the same id is replaced.
  void Write(const TrialResult& result);
  /// All trials, by id.
  std::vector<TrialResult> ReadAll() const;

 private:
  struct Impl;
  explicit Store(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::experiment
