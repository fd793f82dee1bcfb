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
  std::filesystem::path folder = {};  ///< receives whatever there is to see; made where absent
  bool snapshots = false;
  std::filesystem::path video = {};  ///< empty: none
  std::string camera = {};           ///< empty: the task's own choice
  View* view = nullptr;  ///< receives what there is to look at, of a kind that has_views; or null
};

/// One experiment, made ready: everything that its cases share is loaded before processes are
/// forked.
class Task {
 public:
  virtual ~Task() = default;

  /// All cases in a fixed order.
  virtual std::vector<Case> Cases() const = 0;
  /// What takes long and is done once before cases are run; a case that finds it undone does it for
  /// itself. @throws base::InputError
  virtual void Prepare() const {}
  /// Results, which hold the truth, lie in this folder: programs that a case starts must not see
  /// it.
  virtual void Hide(const std::filesystem::path& /*folder*/) {}
  /// Runs a case, in a process of its own. What a case may run into is an outcome; an exception
  /// counts as kCrashed.
  virtual Result Run(const Case& which) const = 0;
  /// Runs it again and leaves what a person wants to see of it in a folder, if there is anything.
  virtual Result Replay(const Case& which, const ReplayOptions& /*options*/) const {
    return Run(which);
  }
  /// Adds what the task's results depend on (to identity: hashes of its models) and what its tables
  /// need (to data). The engine has put in experiment, its hash and text, seed, version and commit.
  virtual void AddTo(Stamp& stamp) const = 0;
};

using OnFindings = std::function<bool(const std::vector<base::Finding>&)>;

/// Keys that every kind of experiment has.
struct Common {
  std::string name;            ///< letters, digits, '_' and '-': names the results folder
  std::filesystem::path file;  ///< as given
  std::uint64_t seed = 1;
  double case_limit_s = 60.0;  ///< wall time after which a case is killed
  int stop_after = 20;         ///< SameFailure (experiment/runner.h)
  /// Is shown what is wrong with the models that the keys name, before they are loaded; false: the
  /// experiment is not made ready. May be empty.
  OnFindings on_findings = {};
};

/// A kind of experiment: the word after `task:` and what stands behind it.
struct TaskKind {
  std::string name;         ///< "grasping", "seam", "parts"
  std::string description;  ///< one sentence
  std::string trials_key;   ///< the key that --trials sets
  bool uses_seed = true;    ///< whether anything is drawn
  std::string success;  ///< the outcome that counts as one where runs are compared; may be empty
  /// Whether a run in which all first cases fail in the same way ends early (Common::stop_after):
  /// false for kinds whose cases are of use even where none of them is a success.
  bool stops_when_hopeless = false;
  /// The outcome with which a run fails if all its cases end in it, for the same reason.
  std::string unusable = {};
  /// Reads the kind's keys, to their end (map.Finish()), and makes everything ready; null where
  /// common.on_findings says so.
  /// @throws base::InputError
  std::unique_ptr<Task> (*read)(base::YamlMap& map, const Common& common) = nullptr;
  /// Reads the same keys and nothing else, for the documentation.
  void (*read_keys)(base::YamlMap& map) = nullptr;
  /// The tables of records of this kind, in the order of their cases; some may be missing.
  /// @throws base::InputError if a published table in the stamp is none.
  Report (*report)(const Stamp& stamp, const std::vector<Record>& records) = nullptr;
  /// Charts of this kind, in addition to those of any kind; null: nothing.
  std::vector<Chart> (*charts)(const Stamp& stamp, const std::vector<Record>& records) = nullptr;
  bool has_views = false;  ///< whether Replay fills a View
};

}  // namespace rangegrasp::experiment
