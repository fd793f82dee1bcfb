#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

#include "experiment/record.h"

namespace rangegrasp::experiment {

/// A results folder that this process alone writes to, until the object or the process ends: a
/// POSIX lock on its file `run.lock`, which NFS 4 passes on, too. Forked workers do not hold it.
class FolderLock {
 public:
  /// Creates the folder where it is absent.
  /// @throws base::InputError naming process and host that write to it; base::RunError if the file
  /// system cannot lock. A folder that is not writable is left to Store::Create.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  int owner_;  ///< process: a fork's copy does not unlock
};

/// The results of a run: one SQLite file (WAL), one transaction a case, so that a run killed at any
/// moment loses nothing that it had finished. One process writes; others may read meanwhile, and
/// later also where nothing can be written.
/// @throws base::RunError for errors of the database (a full disk), base::InputError where the file
/// or folder is not what it should be; both name the file.
class Store {
 public:
  /// Opens for writing, creating folder and file where they are absent.
  static Store Create(const std::filesystem::path& folder);
  /// Opens for reading. @throws base::InputError if there are no results in the folder.
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
  /// How many there are, and the ids of their cases.
  /// @param but  not of those with this outcome
  int Count() const;
  std::unordered_set<std::string> Ids(const std::string& but = "") const;

  /// After the last record: what was written is on the disk, in one file, unless somebody reads it
  /// at this moment. The end of the object does the same, but cannot say what fails.
  void Finish();

  /// All records in the ascending order of their ids, one at a time: for more than memory holds.
  class Cursor {
   public:
    explicit Cursor(const Store& store);  ///< which must outlive it
    ~Cursor();
    Cursor(Cursor&&) noexcept;
    std::optional<Record> Next();

   private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };

  /// Writes whole results into a folder without results, in one step: a program that is killed
  /// meanwhile leaves none.
  /// @param next  gives a record at each call, in the ascending order of their ids; then nullopt.
  /// What it throws is passed on, and nothing is written.
  static void WriteWhole(const std::filesystem::path& folder, const Stamp& stamp,
                         const std::function<std::optional<Record>()>& next);

 private:
  struct Impl;
  static Store CreateFile(const std::filesystem::path& folder, const char* name,
                          const char* pragmas);
  explicit Store(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// What a run left, or several that differ in nothing but their seeds.
struct Results {
  Stamp stamp;  ///< of several: the first's, with all seeds and the sum of the cases
  std::vector<Record> records;
  std::filesystem::path folder = {};  ///< for messages
};

/// Where a run with several seeds keeps the one of a seed: "<folder>/seed-<seed>".
std::filesystem::path SeedFolder(const std::filesystem::path& folder, std::uint64_t seed);

/// The stores of a results folder: itself, or those of its seeds in ascending order.
/// @throws base::InputError if it holds neither.
std::vector<std::filesystem::path> StoresIn(const std::filesystem::path& folder);

/// All that a results folder holds. @throws base::InputError also if its seeds' runs are not of the
/// same experiment.
Results ReadResults(const std::filesystem::path& folder);

struct Merged {
  std::size_t cases = 0;     ///< that were joined
  std::size_t expected = 0;  ///< that the experiment has
};

/// Joins the results of shards into a folder without results, all of them or nothing. Memory does
/// not grow with the number of cases. What is joined may be joined with more.
/// @param complete  whether to write nothing where cases are missing
/// @throws base::InputError naming the folder: it holds results already, a shard is of another run,
/// or a case is in two of them.
Merged Merge(const std::vector<std::filesystem::path>& shards, const std::filesystem::path& out,
             bool complete = false);

}  // namespace rangegrasp::experiment
