// `submit` and `status`: a run distributed over a Slurm cluster.

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/wait.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "base/error.h"
#include "base/file.h"
#include "base/installation.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "experiment/runner.h"
#include "experiment/slurm.h"
#include "experiment/store.h"

namespace rangegrasp::cli {
namespace {

namespace fs = std::filesystem;
using experiment::Queue;
using experiment::Store;
using experiment::Submission;

struct SubmitArguments {
  std::string experiment, out, groups;
  experiment::Changes changes;
  int tasks = 0;
};

// The output of a program on the PATH; its stderr goes to ours.
// @param hint  end of the exception's message if the program fails; empty: it may fail
std::string Call(const std::vector<std::string>& words, const char* hint = "") {
  std::string command;
  for (const std::string& word : words) command += experiment::ShellQuoted(word) + " ";
  FILE* const pipe = popen(command.c_str(), "r");
  if (!pipe) throw base::RunError(words.front() + ": could not be started");
  std::string printed;
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof(buffer), pipe)) > 0;) {
    printed.append(buffer, n);
  }
  const int status = pclose(pipe);
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code == 0 || !*hint) return printed;
  throw base::RunError(fmt::format("{} ended with code {}{}", words.front(), code, hint));
}

bool HasSlurm() { return std::system("command -v sbatch >/dev/null 2>&1") == 0; }

// The pending and running jobs with this name.
Queue QueueOf(const std::string& job_name) {
  return experiment::ParseQueue(
      Call({"squeue", "--noheader", "--array", "--name", job_name, "--format", "%F %K %T"},
           ": is Slurm running on this machine?"));
}

// @return the job's id
std::string Sbatch(std::vector<std::string> words) {
  words.insert(words.begin(), {"sbatch", "--parsable"});
  const std::string printed = Call(words, "; nothing more was submitted");
  return printed.substr(0, printed.find_first_of(";\n"));
}

// The progress of a shard.
struct Shard {
  int task = 0;
  std::size_t done = 0, cases = 0;
  std::string queued;  // its state in the queue; empty if it is not queued

  bool Complete() const { return done == cases; }
};

std::vector<Shard> ShardsOf(const Submission& submission, const Queue& queue) {
  const auto e = experiment::OpenExperiment(submission.experiment, ChangesOf(submission));
  std::vector<Shard> shards;
  for (int task = 1; task <= submission.tasks; ++task) {
    Shard shard{task, 0, ShardOf(e.cases, task, submission.tasks).size(), ""};
    const auto folder = submission.ShardFolder(task);
    try {
      if (Store::Exists(folder)) shard.done = static_cast<std::size_t>(Store::Open(folder).Count());
    } catch (const base::InputError&) {
      // A store left unfinished by a full disk has no cases: `run` starts it again.
    }
    if (queue.state_of_task.contains(task)) shard.queued = queue.state_of_task.at(task);
    shards.push_back(shard);
  }
  return shards;
}

// Whether a shard of a submission is in the queue or has left anything in the folder.
bool HasBegun(const Submission& submission) {
  const fs::path& folder = submission.folder;
  if (Store::Exists(folder) || fs::exists(submission.ShardFolder(1).parent_path())) return true;
  for (int task = 1; task <= submission.tasks; ++task) {
    if (fs::exists(submission.LogFile(task))) return true;
  }
  return !QueueOf(submission.JobName()).job_ids.empty();
}

// Checks that the folder has the same submission, or neither a submission that may have begun nor
// results. Where the queue is unknown, scripts may have been submitted by hand on another machine.
void CheckSame(const Submission& submission) {
  if (!experiment::HasSubmission(submission.folder)) {
    if (!Store::Exists(submission.folder)) return;
    throw base::InputError(submission.folder.string() +
                           ": already contains results; choose another folder with --out DIR");
  }
  const Submission before = experiment::ReadSubmission(submission.folder);
  if (before.experiment == submission.experiment && before.run == submission.run &&
      before.tasks == submission.tasks) {
    return;
  }
  if (HasSlurm() && !HasBegun(before)) return;
  throw base::InputError(
      fmt::format("{}: has the scripts of {} {} --tasks {}; the same command submits the missing "
                  "shards, --out DIR chooses another folder",
                  submission.folder.string(), before.experiment.string(),
                  base::Join(before.run, " "), before.tasks));
}

Submission SubmissionFrom(const SubmitArguments& arguments) {
  const auto& changes = arguments.changes;
  Submission submission;
  submission.experiment =
      std::filesystem::weakly_canonical(fs::absolute(base::FindExperiment(arguments.experiment)));
  submission.tasks = arguments.tasks;
  const auto add = [&](const char* option, const std::string& value) {
    submission.run.insert(submission.run.end(), {option, value});
  };
  if (changes.trials) add("--trials", std::to_string(*changes.trials));
  if (changes.seed) add("--seed", std::to_string(*changes.seed));
  if (!arguments.groups.empty()) add("--objects", arguments.groups);
  for (const std::string& set : changes.set) add("--set", set);
  const auto e = experiment::OpenExperiment(submission.experiment, ChangesOf(submission));
  const fs::path folder = arguments.out.empty() ? "results/" + e.common.name : arguments.out;
  submission.folder = std::filesystem::weakly_canonical(fs::absolute(folder));
  return submission;
}

void WriteScripts(const Submission& submission) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe");
  experiment::WriteSubmission(submission);
  base::WriteFile(submission.File(experiment::kArrayScript), ArrayScriptText(submission, program));
  base::WriteFile(submission.File(experiment::kMergeScript), MergeScriptText(submission, program));
}

void Submit(const SubmitArguments& arguments, const std::vector<std::string>& sbatch) {
  const Submission submission = SubmissionFrom(arguments);
  CheckSame(submission);
  if (!HasSlurm()) {
    WriteScripts(submission);
    throw base::InputError(
        fmt::format("no sbatch on the PATH: this machine is not in a Slurm cluster. The scripts "
                    "are in {}: submit `sbatch --array=1-{} {}`, then {}",
                    (submission.folder / "slurm").string(), submission.tasks,
                    submission.File(experiment::kArrayScript).string(),
                    submission.File(experiment::kMergeScript).string()));
  }
  if (Store::Exists(submission.folder)) {
    return spdlog::info("all shards are done and joined in {}", submission.folder.string());
  }
  const Queue queue = QueueOf(submission.JobName());
  WriteScripts(submission);
  std::vector<int> missing;
  for (const Shard& shard : ShardsOf(submission, queue)) {
    if (!shard.Complete() && shard.queued.empty()) missing.push_back(shard.task);
  }
  std::vector<std::string> after = queue.job_ids;
  if (!missing.empty()) {
    std::vector<std::string> words = sbatch;
    words.insert(words.end(),
                 {"--array=" + experiment::ArrayText(missing),
                  "--output=" + (submission.folder / "slurm" / "shard-%a.log").string(),
                  submission.File(experiment::kArrayScript).string()});
    after.push_back(Sbatch(words));
    spdlog::info("job {}: {} of {} shards", after.back(), missing.size(), submission.tasks);
  }
  // A merge job that waits for an earlier array would start before the new one has ended.
  for (const std::string& id : QueueOf(submission.MergeJobName()).job_ids) Call({"scancel", id});
  std::vector<std::string> words = sbatch;
  if (!after.empty()) words.push_back("--dependency=afterany:" + base::Join(after, ":"));
  words.insert(words.end(), {"--output=" + submission.File(experiment::kMergeLog).string(),
                             submission.File(experiment::kMergeScript).string()});
  spdlog::info("job {}: joins the shards in {}; `rangegrasp status {}` shows the progress",
               Sbatch(words), submission.folder.string(), submission.folder.string());
}

// The last non-blank line of a log.
std::string LastLine(const fs::path& log) {
  if (!fs::exists(log)) return "";
  std::string last;
  for (const std::string& line : base::Split(base::ReadFile(log), '\n')) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return last;
}

void Status(const std::string& folder) {
  const Submission submission = experiment::ReadSubmission(folder);
  const bool slurm = HasSlurm();
  if (!slurm) spdlog::warn("no squeue on the PATH: pending and running jobs are unknown");
  const Queue queue = slurm ? QueueOf(submission.JobName()) : Queue();
  std::string text;
  std::size_t done = 0;
  std::size_t cases = 0;
  int failed = 0;
  for (const Shard& shard : ShardsOf(submission, queue)) {
    done += shard.done;
    cases += shard.cases;
    const auto log = submission.LogFile(shard.task);
    const bool began = std::filesystem::exists(log);
    std::string state = "done";
    if (!shard.Complete()) {
      state = !shard.queued.empty() ? shard.queued : began ? "failed" : "not submitted";
    }
    text +=
        fmt::format("shard {:>4}  {:>6} of {:>6}  {}", shard.task, shard.done, shard.cases, state);
    if (state == "failed") {
      ++failed;
      text += fmt::format(": {} ({})", LastLine(log), log.string());
    }
    text += "\n";
  }
  text += fmt::format("{} of {} cases done", done, cases);
  if (failed > 0) {
    text += fmt::format("; {} failed: repeat the same `submit` to run what is missing",
                        base::Counted(failed, "shard"));
  }
  if (Store::Exists(submission.folder)) {
    text += "; joined in " + submission.folder.string();
  } else if (slurm && !QueueOf(submission.MergeJobName()).job_ids.empty()) {
    text += "; the job that joins them is pending or running";
  } else if (const std::string last = LastLine(submission.File(experiment::kMergeLog));
             !last.empty()) {
    text += "\nnot joined: " + last;
  }
  WriteResult(text + "\n");
}

void AddSubmit(CLI::App& app) {
  auto* command =
      app.add_subcommand("submit",
                         "Run an experiment on a Slurm cluster: an array job of shards, and a job "
                         "that joins them. Repeating the command submits failed shards again.");
  auto a = std::make_shared<SubmitArguments>();
  command->add_option("experiment", a->experiment, "experiment file (YAML)")->required();
  command->add_option("--tasks", a->tasks, "number of shards; each is a task of the array job")
      ->required()
      ->transform(WholeNumber(1, experiment::kMaxTasks));
  command->add_option(
      "-o,--out", a->out,
      "results folder on a file system shared by all nodes (results/<experiment name>)");
  command->add_option("--trials", a->changes.trials, "same as for run")
      ->transform(WholeNumber(1, 1'000'000));
  command->add_option("--seed", a->changes.seed, "same as for run")->transform(WholeNumber());
  command->add_option("--objects", a->groups, "same as for run");
  command->add_option("--set", a->changes.set, "same as for run")->allow_extra_args(false);
  command->allow_extras();
  command->footer(
      "All other options are passed to sbatch; write them as --option=value.\nExample: rangegrasp "
      "submit experiments/laser_single.yaml --trials 1000 --tasks 100 --cpus-per-task=2 "
      "--time=01:00:00");
  command->callback([a, command] { Submit(*a, command->remaining()); });
}

void AddStatus(CLI::App& app) {
  auto* command = app.add_subcommand("status", "Show the progress of shards submitted to Slurm.");
  auto folder = std::make_shared<std::string>();
  command->add_option("folder", *folder, "results folder")->required();
  command->footer("Example: rangegrasp status results/laser_single");
  command->callback([folder] { Status(*folder); });
}

}  // namespace

void AddSlurmCommands(CLI::App& app) {
  AddSubmit(app);
  AddStatus(app);
}

}  // namespace rangegrasp::cli
