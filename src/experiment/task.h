#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/yaml_map.h"
#include "experiment/record.h"
#include "experiment/report.h"

namespace rangegrasp::experiment {

struct View;

struct ReplayOptions {
  std::filesystem::path folder = {};  ///< receives all files for viewing; created if absent
  bool snapshots = false;
  std::filesystem::path video = {};  ///< empty: no video
  std::string camera = {};           ///< empty: chosen by the task
  View* view = nullptr;  ///< receives the view of the case if the kind has_views; may be null
};

/// A prepared experiment: everything that its cases share is loaded before processes are forked.
class Task {
 public:
  virtual ~Task() = default;

  /// All cases in a fixed order.
  virtual std::vector<Case> Cases() const = 0;
  /// Performs long computations once, before cases are run. A case that finds them missing performs
  /// them itself. @throws base::InputError
  virtual void Prepare() const {}
  /// Hides the folder of the results, which contain ground truth, from programs that a case starts.
  virtual void Hide(const std::filesystem::path& /*folder*/) {}
  /// Runs a case in its own process. Expected failures are outcomes; exceptions count as kCrashed.
  virtual Result Run(const Case& which) const = 0;
  /// Runs a case again and writes files for viewing into a folder, if there are any.
  /// @throws base::InputError for a video or camera if the task has none.
  virtual Result Replay(const Case& which, const ReplayOptions& options) const {
    if (!options.video.empty() || !options.camera.empty()) {
      throw base::InputError("--video, --camera: this task has no pictures of its cases");
    }
    return Run(which);
  }
  /// Adds what the task's results depend on (to identity: hashes of its models) and what its tables
  /// need (to data). The engine has added experiment, its hash and text, seed, version and commit.
  virtual void AddTo(Stamp& stamp) const = 0;
};

using OnFindings = std::function<bool(const std::vector<base::Finding>&)>;

/// Keys that every kind of experiment has.
struct Common {
  std::string name;            ///< letters, digits, '_' and '-': names the results folder
  std::filesystem::path file;  ///< as given
  std::uint64_t seed = 1;
  double case_limit_s = 60.0;  ///< RunOptions::case_limit_s
  int stop_after = 20;         ///< see SameFailure (experiment/runner.h)
  /// Receives the problems of the models that the keys name, before they are loaded, and perhaps
  /// again after that. If it returns false, the experiment is not prepared. May be empty.
  OnFindings on_findings = {};
};

/// A kind of experiment: the word after `task:` and its implementation.
struct TaskKind {
  std::string name;         ///< "grasping", "seam", "parts"
  std::string description;  ///< one sentence
  std::string trials_key;   ///< the key that --trials sets
  bool uses_seed = true;    ///< whether random numbers are drawn
  std::string success;  ///< the outcome that counts as success when runs are compared; may be empty
  /// Whether a run stops early if its first cases all fail in the same way (Common::stop_after):
  /// false for kinds whose cases are useful even if none succeeds.
  bool stops_when_hopeless = false;
  /// A run fails if all its cases end with this outcome for the same reason.
  std::string unusable = {};
  /// Reads the kind's keys up to map.Finish(), and prepares everything; null if common.on_findings
  /// returns false.
  /// @throws base::InputError
  std::unique_ptr<Task> (*read)(base::YamlMap& map, const Common& common) = nullptr;
  /// Only reads the same keys, for the documentation.
  void (*read_keys)(base::YamlMap& map) = nullptr;
  /// The tables for records of this kind, in the order of their cases; some may be missing.
  /// @throws base::InputError if a published table in the stamp is not a table.
  Report (*report)(const Stamp& stamp, const std::vector<Record>& records) = nullptr;
  /// Charts of this kind, in addition to the charts of all kinds; null: none.
  std::vector<Chart> (*charts)(const Stamp& stamp, const std::vector<Record>& records) = nullptr;
  /// What `trial` prints of a result besides its outcome and figures, e.g. the executed grasp, as a
  /// line without its end; empty: nothing. Null: nothing of any result.
  std::string (*summary)(const Result& result) = nullptr;
  bool has_views = false;  ///< whether Replay fills a View
};

}  // namespace rangegrasp::experiment
