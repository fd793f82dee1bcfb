#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace rangegrasp::experiment {

/// A run as a Slurm array job: task i runs shard i, a job after them joins the shards. Below the
/// results folder `slurm/` has scripts, logs and this, `shards/` the shards' results.
struct Submission {
  std::filesystem::path experiment;  ///< absolute
  std::vector<std::string> run;      ///< further arguments of `rangegrasp run`
  int tasks = 1;
  std::filesystem::path folder;  ///< of the results; absolute, shared by all nodes

  std::filesystem::path ShardFolder(int task) const {
    return folder / "shards" / std::to_string(task);
  }
  std::filesystem::path LogFile(int task) const;  ///< from 1
  std::filesystem::path File(const char* name) const { return folder / "slurm" / name; }
  /// The jobs' name in the queue, unique to the folder.
  std::string JobName() const;
  std::string MergeJobName() const { return JobName() + "-merge"; }
};
/// Names of Submission::File.
inline constexpr const char* kArrayScript = "shard.sh";
inline constexpr const char* kMergeScript = "merge.sh";
inline constexpr const char* kMergeLog = "merge.log";

/// The text of the two scripts. @param program  the `rangegrasp` that nodes call, absolute
std::string ArrayScriptText(const Submission& submission, const std::filesystem::path& program);
std::string MergeScriptText(const Submission& submission, const std::filesystem::path& program);

/// Keeps a submission in its folder, and finds it there again.
/// @throws base::InputError naming the folder if there is none, or what is wrong with its file.
void WriteSubmission(const Submission& submission);
bool HasSubmission(const std::filesystem::path& folder);
Submission ReadSubmission(const std::filesystem::path& folder);

/// What `squeue --noheader --array --format "%F %K %T"` printed of an array: the state of each of
/// its tasks that is in the queue, and the ids of the jobs that they belong to.
struct Queue {
  std::map<int, std::string> state_of_task;
  std::vector<std::string> job_ids;  ///< each once
};
Queue ParseQueue(const std::string& printed);

/// "1-3,7": what `sbatch --array` takes. @param tasks  ascending
std::string ArrayText(const std::vector<int>& tasks);

/// A word of a shell command that stays one word, whatever it holds.
std::string ShellQuoted(const std::string& word);

}  // namespace rangegrasp::experiment
