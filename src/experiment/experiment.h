#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "experiment/statistics.h"
#include "experiment/store.h"
#include "experiment/task.h"

namespace rangegrasp::experiment {

/// Registers a kind of experiment at program start.
void AddKind(const TaskKind& kind);

/// All kinds in the order in which they were added.
std::span<const TaskKind> AllKinds();

/// Changes that the command line makes to an experiment file.
struct Changes {
  std::vector<std::string> set = {};  ///< "key.inner=value", overrides the file
  std::optional<int> trials = {};     ///< value of the kind's trials_key
  std::optional<std::uint64_t> seed = {};
  std::vector<std::string> groups = {};  ///< only cases of these groups; empty: all
};

/// Reads the keys common to all kinds of experiments, except `task`. @throws base::InputError
void ReadCommon(base::YamlMap& map, Common& common);

/// An experiment that is ready to run.
struct Experiment {
  const TaskKind* kind = nullptr;
  Common common;
  std::unique_ptr<Task> task;
  std::vector<Case> cases;  ///< cases of the chosen groups, in the task's order
  Stamp stamp;
};

/// Reads an experiment file with the changes of the command line, and prepares everything.
/// @throws base::InputError naming file, line, key, value and the nearest valid word.
/// @param on_findings  Common::on_findings; if it returns false, the experiment has no task.
Experiment OpenExperiment(const std::filesystem::path& file, const Changes& changes = {},
                          const OnFindings& on_findings = {});

/// The experiment of a store, from the text in its stamp. Relative paths are relative to the
/// experiment file's folder.
/// @param run_detector  whether its cases may start the program that the stamp names as detector
/// @throws base::InputError also if the stamp is incomplete, or names such a program that may not
/// be started.
Experiment OpenAgain(const Stamp& stamp, bool run_detector);

/// The changes of the command line in a stamp, as for --set: "key.inner=value".
/// @throws base::InputError if the stamp is incomplete.
std::vector<std::string> SetOf(const Stamp& stamp);

/// The experiment file in a stamp; comments before it list the changes of the command line.
/// @throws base::InputError if the stamp is incomplete.
std::string FileAsRun(const Stamp& stamp);

/// The kind of the experiment of a store. @throws base::InputError if its name is unknown.
const TaskKind& KindOf(const Stamp& stamp);

/// The outcome that counts as success in a run of this kind; empty if there is none.
std::string SuccessOf(const TaskKind& kind, const Stamp& stamp);

/// The tables of a results folder, with a note of how many cases are missing.
Report ReportOf(const Results& results);

/// A key of an experiment to which two runs give different values.
struct KeyDifference {
  std::string key;            ///< "physics.timestep_ms"
  std::string first, second;  ///< as written; empty: not given
};
/// The keys in which two runs differ, in alphabetical order, without the seed and the number of
/// trials. @throws base::InputError if a stamp is incomplete.
std::vector<KeyDifference> DifferingKeys(const Stamp& first, const Stamp& second);

/// Case-by-case comparison of two results folders.
struct RunComparison : Comparison {
  std::string success;  ///< the outcome that counts as success
  std::string warning;  ///< empty unless the two are runs of different experiments
  std::vector<KeyDifference> keys;
};
/// @throws base::InputError naming the folders if they have no success or no case in common.
RunComparison CompareRuns(const std::filesystem::path& first, const std::filesystem::path& second);

/// The case with an id. @throws base::InputError naming the nearest id.
const Case& CaseOf(const Experiment& experiment, const std::string& id);

/// A Markdown table of keys.
std::string KeyTable(const std::vector<base::KeyDoc>& keys);

/// The keys common to all experiment files (task "") and those of each kind, from the reading code.
std::vector<std::pair<std::string, std::vector<base::KeyDoc>>> KeysByTask();
/// The same as a Markdown page.
std::string KeysAsMarkdown();

}  // namespace rangegrasp::experiment
