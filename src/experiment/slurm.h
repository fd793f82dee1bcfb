#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "experiment/experiment.h"

namespace rangegrasp::experiment {

/// A run as a Slurm array job: task i runs shard i, and a final job joins the shards. In the
/// results folder, `slurm/` has scripts, logs and this, and `shards/` has the shards' results.
struct Submission {
  std::filesystem::path experiment;  ///< absolute
  std::vector<std::string> run;      ///< further arguments of `rangegrasp run`
  int tasks = 1;
  std::filesystem::path folder;  ///< results folder; absolute, shared by all nodes

  std::filesystem::path ShardFolder(int task) const {
    return folder / "shards" / std::to_string(task);
  }
  std::filesystem::path LogFile(int task) const;  ///< tasks count from 1
  std::filesystem::path File(const char* name) const { return folder / "slurm" / name; }
  /// The jobs' name in the queue, unique for the folder.
  std::string JobName() const;
  std::string MergeJobName() const { return JobName() + "-merge"; }
};
/// Names for Submission::File.
inline constexpr const char* kArrayScript = "shard.sh";
inline constexpr const char* kMergeScript = "merge.sh";
inline constexpr const char* kMergeLog = "merge.log";

/// The text of the two scripts. @param program  absolute path of `rangegrasp` on the nodes
std::string ArrayScriptText(const Submission& submission, const std::filesystem::path& program);
std::string MergeScriptText(const Submission& submission, const std::filesystem::path& program);

/// Writes a submission into its folder, and reads it from there.
/// @throws base::InputError naming the folder if there is none, or the error in its file.
void WriteSubmission(const Submission& submission);
bool HasSubmission(const std::filesystem::path& folder);
Submission ReadSubmission(const std::filesystem::path& folder);
/// What its options change in the experiment.
/// @throws base::InputError naming its file and an option whose value is no number.
Changes ChangesOf(const Submission& submission);

inline constexpr int kMaxTasks = 1'000'000;

/// The output of `squeue --noheader --array --format "%F %K %T"` for an array: the state of each of
/// its tasks that is in the queue, and the ids of the jobs that they belong to.
struct Queue {
  std::map<int, std::string> state_of_task;
  std::vector<std::string> job_ids;  ///< each once
};
Queue ParseQueue(const std::string& printed);

/// Argument of `sbatch --array`: "1-3,7". @param tasks  ascending
std::string ArrayText(const std::vector<int>& tasks);

/// A word quoted for the shell, so that it stays one word whatever it contains.
std::string ShellQuoted(const std::string& word);

}  // namespace rangegrasp::experiment
