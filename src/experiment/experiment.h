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

/// Adds a kind of experiment when the program starts.
void AddKind(const TaskKind& kind);

/// All kinds in the order in which they were added.
std::span<const TaskKind> AllKinds();

/// What the command line changes of an experiment file.
struct Changes {
  std::vector<std::string> set = {};  ///< "key.inner=value", in place of what the file says
  std::optional<int> trials = {};     ///< of the key that the kind names
  std::optional<std::uint64_t> seed = {};
  std::vector<std::string> groups = {};  ///< only their cases; empty: all
};

/// Reads the keys that every kind of experiment has, but for `task`. @throws base::InputError
void ReadCommon(base::YamlMap& map, Common& common);

/// An experiment that is ready to run.
struct Experiment {
  const TaskKind* kind = nullptr;
  Common common;
  std::unique_ptr<Task> task;
  std::vector<Case> cases;  ///< of the groups that were chosen, in the task's order
  Stamp stamp;
};

/// Reads an experiment file with what the command line changes of it, and makes everything ready.
/// @throws base::InputError naming file, line, key, value and the nearest valid word.
/// @param on_findings  Common::on_findings; where it returns false, the experiment has no task.
Experiment OpenExperiment(const std::filesystem::path& file, const Changes& changes = {},
                          const OnFindings& on_findings = {});

/// The experiment of a store, from the text that its stamp keeps; relative paths are those of the
/// experiment file's folder.
/// @param run_detector  whether its cases may start the program that the stamp names as detector
/// @throws base::InputError also if the stamp is not whole, or names such a program that may not be
/// started.
Experiment OpenAgain(const Stamp& stamp, bool run_detector);

/// The experiment file that a stamp keeps; comments before it say what the command line changed.
/// @throws base::InputError if the stamp is not whole.
std::string FileAsRun(const Stamp& stamp);

/// The kind that made a store. @throws base::InputError if there is none of its name.
const TaskKind& KindOf(const Stamp& stamp);

/// The tables of a results folder; they say how many cases are missing.
Report ReportOf(const Results& results);

/// Two results folders, case by case.
struct RunComparison : Comparison {
  std::string success;  ///< the outcome that counts as one
};
/// @throws base::InputError naming the folders if they are of two tasks, or have no case in common.
RunComparison CompareRuns(const std::filesystem::path& first, const std::filesystem::path& second);

/// The case of an id. @throws base::InputError naming the nearest one.
const Case& CaseOf(const Experiment& experiment, const std::string& id);

/// Keys as a table in Markdown.
std::string KeyTable(const std::vector<base::KeyDoc>& keys);

/// The keys of every experiment file (task "") and those of each kind, made from the code that
/// reads them.
std::vector<std::pair<std::string, std::vector<base::KeyDoc>>> KeysByTask();
/// The keys of every experiment file and those of each kind, as a Markdown page made from the code
/// that reads them.
std::string KeysAsMarkdown();

}  // namespace rangegrasp::experiment
