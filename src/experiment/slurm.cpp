#include "experiment/slurm.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <type_traits>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"

namespace rangegrasp::experiment {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSlurmFile = "submission.json";

std::string Quoted(const fs::path& path) { return ShellQuoted(path.string()); }

}  // namespace

fs::path Submission::LogFile(int task) const {
  return File(fmt::format("shard-{}.log", task).c_str());
}

std::string Submission::JobName() const {
  return "rangegrasp-" + base::Hex(base::Fnv1a(folder.string()));
}

std::string ArrayScriptText(const Submission& submission, const fs::path& program) {
  std::string run;
  for (const std::string& argument : submission.run) run += " " + ShellQuoted(argument);
  return fmt::format(
      R"(#!/bin/bash
# One shard of {experiment}; finished cases are kept.
#SBATCH --job-name={name}
#SBATCH --open-mode=append
set -u
echo "$(date -Is) shard $SLURM_ARRAY_TASK_ID on $(hostname), job ${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID"
exec {program} run {experiment}{run} --shard "$SLURM_ARRAY_TASK_ID/{tasks}" --resume \
  --jobs "${{SLURM_CPUS_PER_TASK:-1}}" --out {folder}/shards/"$SLURM_ARRAY_TASK_ID"
)",
      fmt::arg("experiment", Quoted(submission.experiment)), fmt::arg("name", submission.JobName()),
      fmt::arg("program", Quoted(program)), fmt::arg("run", run),
      fmt::arg("tasks", submission.tasks), fmt::arg("folder", Quoted(submission.folder)));
}

std::string MergeScriptText(const Submission& submission, const fs::path& program) {
  return fmt::format(
      R"(#!/bin/bash
# Joins the shards when all of them have ended; if cases are missing, nothing is written.
#SBATCH --job-name={name}
#SBATCH --open-mode=append
set -eu
cd {folder}
{program} merge --complete $(for i in $(seq {tasks}); do echo "shards/$i"; done) --out .
{program} table . --files >table.txt
)",
      fmt::arg("name", submission.MergeJobName()), fmt::arg("program", Quoted(program)),
      fmt::arg("tasks", submission.tasks), fmt::arg("folder", Quoted(submission.folder)));
}

void WriteSubmission(const Submission& submission) {
  const nlohmann::ordered_json json = {{"experiment", submission.experiment.string()},
                                       {"run", submission.run},
                                       {"tasks", submission.tasks}};
  base::WriteFile(submission.File(kSlurmFile), json.dump(2) + "\n");
}

bool HasSubmission(const fs::path& folder) { return fs::exists(folder / "slurm" / kSlurmFile); }

Submission ReadSubmission(const fs::path& folder) {
  const auto file = folder / "slurm" / kSlurmFile;
  if (!HasSubmission(folder)) {
    throw base::InputError(folder.string() + ": nothing was submitted here (no slurm/" +
                           kSlurmFile + "); give the results folder of `submit`");
  }
  Submission submission;
  std::string tasks;
  try {
    const auto json = nlohmann::json::parse(base::ReadFile(file));
    submission.experiment = json.at("experiment").get<std::string>();
    submission.run = json.at("run").get<std::vector<std::string>>();
    tasks = json.at("tasks").dump();
  } catch (const nlohmann::json::exception&) {
    throw base::InputError(file.string() +
                           ": is damaged: no JSON with experiment, run and tasks, as `submit` "
                           "writes it");
  }
  submission.tasks = base::NumberFrom<int>(tasks).value_or(0);
  if (submission.tasks < 1 || submission.tasks > kMaxTasks) {
    throw base::InputError(fmt::format("{}: tasks is {}, but must be from 1 to {}", file.string(),
                                       base::Excerpt(tasks), kMaxTasks));
  }
  submission.folder = std::filesystem::weakly_canonical(folder);
  ChangesOf(submission);  // refuses its errors here
  return submission;
}

Changes ChangesOf(const Submission& submission) {
  const auto number = [&](const std::string& option, const std::string& value, auto& to) {
    to = base::NumberFrom<typename std::remove_cvref_t<decltype(to)>::value_type>(value);
    if (to) return;
    throw base::InputError(fmt::format("{}: {} '{}' must be a whole number",
                                       submission.File(kSlurmFile).string(), option, value));
  };
  Changes changes;
  for (std::size_t i = 0; i + 1 < submission.run.size(); i += 2) {
    const std::string& option = submission.run[i];
    const std::string& value = submission.run[i + 1];
    if (option == "--set") changes.set.push_back(value);
    if (option == "--trials") number(option, value, changes.trials);
    if (option == "--seed") number(option, value, changes.seed);
    if (option == "--objects") changes.groups = base::Split(value, ',');
  }
  return changes;
}

Queue ParseQueue(const std::string& printed) {
  Queue queue;
  std::istringstream lines(printed);
  std::string job, task, state;
  while (lines >> job >> task >> state) {
    if (const auto number = base::NumberFrom<int>(task)) queue.state_of_task[*number] = state;
    if (std::ranges::find(queue.job_ids, job) == queue.job_ids.end()) queue.job_ids.push_back(job);
  }
  return queue;
}

std::string ArrayText(const std::vector<int>& tasks) {
  std::string text;
  for (std::size_t i = 0; i < tasks.size();) {
    std::size_t last = i;
    while (last + 1 < tasks.size() && tasks[last + 1] == tasks[last] + 1) ++last;
    text += (text.empty() ? "" : ",") + std::to_string(tasks[i]);
    if (last > i) text += "-" + std::to_string(tasks[last]);
    i = last + 1;
  }
  return text;
}

std::string ShellQuoted(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace rangegrasp::experiment
