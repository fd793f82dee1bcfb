#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "base/error.h"
#include "base/installation.h"
#include "experiment/record.h"

namespace rangegrasp::experiment {

/// Exclusive write access to a results folder until the object or this process ends: a POSIX lock
/// on its file `run.lock`, also on NFS 4. Forked workers do not hold it.
class FolderLock {
 public:
  static constexpr const char* kFile = "run.lock";  ///< in the folder while the lock is held
  /// Creates the folder if it is absent.
  /// @throws base::InputError naming process and host that write to it; base::RunError if the file
  /// system cannot lock. A folder that is not writable is reported by Store::Create.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  int owner_;  ///< process id: the copy in a fork does not unlock
};

/// The results of a run: one SQLite file (WAL), one transaction per case, so that a run killed at
/// any moment keeps all finished cases. One process writes; others may read at the same time, and
/// later also from a read-only place.
/// @throws base::RunError for errors of the database (a full disk), base::InputError if the file or
/// folder is not as expected; both name the file.
class Store {
 public:
  /// Opens for writing; creates folder and file if they are absent.
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
  /// Returns an empty stamp if the run was killed before it was written.
  Stamp ReadStamp() const;

  /// Writes one record; replaces a record with the same id.
  void Write(const Record& record);
  /// All records, in the order of their cases' positions.
  std::vector<Record> ReadAll() const;
  /// The number of records, and the ids of their cases.
  /// @param but  excludes records with this outcome
  int Count() const;
  std::unordered_set<std::string> Ids(const std::string& but = "") const;

  /// Call after the last record: everything written is then on the disk, in one file, unless
  /// another process is reading it. The destructor does the same, but cannot report errors.
  void Finish();

  /// All records in ascending order of their ids, one at a time: for results larger than memory.
  class Cursor {
   public:
    explicit Cursor(const Store& store);  ///< must outlive the cursor
    ~Cursor();
    Cursor(Cursor&&) noexcept;
    std::optional<Record> Next();

   private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };

  /// Writes complete results into a folder without results, in one step: a program that is killed
  /// meanwhile leaves none.
  /// @param next  returns one record per call, in ascending order of their ids; then nullopt. Its
  /// exceptions are passed on, and nothing is written.
  static void WriteWhole(const std::filesystem::path& folder, const Stamp& stamp,
                         const std::function<std::optional<Record>()>& next);

 private:
  struct Impl;
  static Store CreateFile(const std::filesystem::path& folder, const char* name,
                          const char* pragmas);
  explicit Store(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// The results of a run, or of several runs that differ only in their seeds.
struct Results {
  Stamp stamp;  ///< of several runs: the first one's, with all seeds and the sum of cases
  std::vector<Record> records;
  std::filesystem::path folder = {};  ///< for messages
};

/// The folder of one seed in a run with several seeds: "<folder>/seed-<seed>".
inline constexpr std::string_view kSeedPrefix = "seed-";
std::filesystem::path SeedFolder(const std::filesystem::path& folder, std::uint64_t seed);

/// The result of `read`; its errors, e.g. of Need, then also name the results folder.
template <typename Read>
decltype(auto) InFolder(const std::filesystem::path& folder, Read read) {
  try {
    return read();
  } catch (const base::NotBuilt&) {
    throw;  // the script that started the program may build it
  } catch (const base::InputError& error) {
    throw base::InputError(folder.string() + ": " + error.what());
  }
}

/// The stores of a results folder: those of its seeds in ascending order, or the folder itself.
std::vector<std::filesystem::path> StoresIn(const std::filesystem::path& folder);

/// All results of a folder. @throws base::InputError also if its seeds are of several experiments.
Results ReadResults(const std::filesystem::path& folder);

struct Merged {
  std::size_t cases = 0;     ///< joined cases
  std::size_t expected = 0;  ///< cases of the experiment
};

/// Joins the results of shards into a folder without results, all of them or nothing. Memory use
/// does not grow with the number of cases. Joined results may be joined with more.
/// @param complete  whether to write nothing if cases are missing
/// @throws base::InputError naming the folder: it already contains results, a shard belongs to
/// another run, or a case is in two shards.
Merged Merge(const std::vector<std::filesystem::path>& shards, const std::filesystem::path& out,
             bool complete = false);

}  // namespace rangegrasp::experiment
