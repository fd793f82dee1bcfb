#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "experiment/record.h"
#include "experiment/stamp.h"

namespace rangegrasp::experiment {

/// The results of a run: one SQLite file (WAL), one transaction a case, so that a run killed at any
/// moment loses nothing that it had finished. One process writes; others may read meanwhile.
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
  /// Removes the results from a folder, and nothing else.
  static void Remove(const std::filesystem::path& folder);
  ~Store();
  Store(Store&&) noexcept;

  const std::filesystem::path& file() const;

  void WriteStamp(const Stamp& stamp);
  /// An empty one if the run was killed before it was written.
  Stamp ReadStamp() const;

  /// Writes one record; one of the same id is replaced.
  void Write(const Record& record);
  /// All records, in the order of their cases' positions.
  std::vector<Record> ReadAll() const;
  /// How many there are.
  int Count() const;

 private:
  struct Impl;
  explicit Store(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::experiment
