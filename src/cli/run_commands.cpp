#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <set>
#include <sstream>
#include <thread>

#include "cli/commands.h"
#include "cli/output.h"
#include "core/error.h"
#include "core/stopwatch.h"
#include "core/yaml_map.h"
#include "experiment/runner.h"
#include "report/table.h"

namespace rangegrasp::cli {
namespace {

using experiment::Experiment;
using experiment::Store;

constexpr double kBarWidth = 30.0;

// A progress line on a terminal; nothing elsewhere.
class ProgressBar {
 public:
  void operator()(int done, int total, const experiment::TrialResult& last) {
    if (last.outcome == experiment::Outcome::kDelivered) ++delivered_;
    if (!isatty(STDERR_FILENO)) return;
    const double left = watch_.Seconds() / done * (total - done);
    const auto filled = static_cast<std::size_t>(kBarWidth * done / total);
    const std::string bar =
        std::string(filled, '#') + std::string(static_cast<std::size_t>(kBarWidth) - filled, '.');
    std::fprintf(stderr, "\r[%s] %d/%d, %d delivered, %.0f s left \033[K", bar.c_str(), done, total,
                 delivered_, left);
    if (done == total) std::fputc('\n', stderr);
    std::fflush(stderr);
  }

 private:
  core::Stopwatch watch_;
  int delivered_ = 0;
};

struct RunArguments {
  std::string experiment;
  std::string out;
  std::string objects;
  std::string shard = "1/1";
  std::string format = "text";
  std::optional<int> trials;
  std::optional<std::uint64_t> seed;
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  bool resume = false;
  bool overwrite = false;
  bool json = false;
};

void ApplyArguments(const RunArguments& arguments, Experiment& e) {
  if (arguments.trials) e.trials_per_object = *arguments.trials;
  if (arguments.seed) e.seed = *arguments.seed;
  if (arguments.objects.empty()) return;
  std::vector<std::string> chosen;
  std::istringstream in(arguments.objects);
  for (std::string object; std::getline(in, object, ',');) {
    if (std::find(e.objects.begin(), e.objects.end(), object) == e.objects.end()) {
      throw core::InputError("--objects: '" + object + "' is not in " + e.file.string() +
                             "; nearest: '" + core::NearestWord(object, e.objects) + "'");
    }
    chosen.push_back(object);
  }
  // In the experiment's order, so that the table does not depend on how they were typed.
  std::erase_if(e.objects, [&](const std::string& object) {
    return std::find(chosen.begin(), chosen.end(), object) == chosen.end();
  });
}

std::pair<int, int> ParseShard(const std::string& text) {
  int shard = 0;
  int shards = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%d/%d%c", &shard, &shards, &rest) != 2 || shard < 1 ||
      shard > shards) {
    throw core::InputError("--shard '" + text + "' must be I/N with 1 <= I <= N, e.g. 2/8");
  }
  return {shard, shards};
}

// What two runs must share for their trials to stand in one table.
constexpr std::array kIdentity = {"experiment", "experiment_hash", "scene_hash",       "seed",
                                  "mujoco",     "objects",         "trials_per_object"};

void CheckSameRun(const std::map<std::string, std::string>& stored,
                  const std::map<std::string, std::string>& wanted, const std::string& where) {
  for (const char* key : kIdentity) {
    const auto a = stored.find(key);
    const auto b = wanted.find(key);
    const std::string was = a == stored.end() ? "" : a->second;
    const std::string is = b == wanted.end() ? "" : b->second;
    if (was != is) {
      throw core::InputError(where + ": was made with another " + key + " ('" + was + "', not '" +
                             is + "'); use another --out, or --overwrite");
    }
  }
}

Store OpenForRun(const std::filesystem::path& folder, const RunArguments& arguments,
                 const std::map<std::string, std::string>& stamp) {
  if (Store::Exists(folder)) {
    if (arguments.overwrite) {
      for (const char* name : {"results.sqlite", "results.sqlite-wal", "results.sqlite-shm"}) {
        std::filesystem::remove(folder / name);
      }
    } else if (!arguments.resume) {
      throw core::InputError(folder.string() +
                             ": holds results already; --resume goes on with them, "
                             "--overwrite starts anew, --out DIR writes elsewhere");
    } else {
      // A run killed before its stamp was written has no trials either.
      const auto stored = Store::Open(folder).ReadStamp();
      if (!stored.empty()) CheckSameRun(stored, stamp, folder.string());
    }
  }
  Store store = Store::Create(folder);
  store.WriteStamp(stamp);
  return store;
}

void Run(const RunArguments& arguments) {
  Experiment e = experiment::ReadExperiment(arguments.experiment);
  ApplyArguments(arguments, e);
  experiment::RunOptions options;
  options.jobs = arguments.jobs;
  options.resume = arguments.resume;
  std::tie(options.shard, options.shards) = ParseShard(arguments.shard);
  const std::filesystem::path folder = arguments.out.empty()
                                           ? std::filesystem::path("results") / e.name
                                           : std::filesystem::path(arguments.out);
  const auto stamp = experiment::MakeStamp(e);
  report::BuildTable(stamp, {});  // a broken reference table shows before hours of trials
  const auto context =
      experiment::Prepare(e);  // before the store: a broken model leaves none behind
  Store store = OpenForRun(folder, arguments, stamp);
  core::Stopwatch watch;
  experiment::RunExperiment(context, store, options, ProgressBar());
  const auto table = report::BuildTable(store);
  WriteResult(report::Format(
      table, arguments.json ? report::TableFormat::kJson : ParseTableFormat(arguments.format)));
  spdlog::info("{} trials in {:.1f} s with {} jobs; results in {}", table.overall.trials,
               watch.Seconds(), options.jobs, store.file().string());
}

void AddRun(CLI::App& app) {
  auto* command = app.add_subcommand(
      "run", "Run an experiment's trials and print its table beside the published one.");
  auto arguments = std::make_shared<RunArguments>();
  command->add_option("experiment", arguments->experiment, "experiment file (YAML)")->required();
  command->add_option("--out", arguments->out,
                      "results folder (default: results/<experiment name>)");
  command->add_option("--trials", arguments->trials, "trials of each object, instead of the file's")
      ->check(CLI::Range(1, 100000));
  command->add_option("--objects", arguments->objects, "only these, e.g. coffee_cup,cleaner");
  command
      ->add_option("--jobs", arguments->jobs,
                   "trials at the same time (default: the number of cores)")
      ->check(CLI::Range(1, 1024));
  command->add_option("--seed", arguments->seed, "instead of the file's")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--resume", arguments->resume, "go on with a run that was stopped");
  command->add_flag("--overwrite", arguments->overwrite,
                    "throw away results that are in the folder");
  command->add_option("--shard", arguments->shard,
                      "I/N: every N-th trial, from the I-th (join with merge)");
  command->add_option("--format", arguments->format, "of the table")
      ->check(CLI::IsMember({"text", "markdown", "csv", "json"}));
  command->add_flag("--json", arguments->json, "same as --format json");
  command->footer(
      "Example: rangegrasp run experiments/laser_single.yaml --objects coffee_cup --trials 3 "
      "--jobs 2");
  command->callback([arguments] { Run(*arguments); });
}

void AddTable(CLI::App& app) {
  struct Arguments {
    std::string folder, format = "text", out;
  };
  auto* command = app.add_subcommand("table", "Print the table of a results folder again.");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("folder", arguments->folder, "results folder")->required();
  command->add_option("--format", arguments->format)
      ->check(CLI::IsMember({"text", "markdown", "csv", "json"}));
  command->add_flag_callback(
      "--json", [arguments] { arguments->format = "json"; }, "same as --format json");
  command->add_option("--out", arguments->out, "file instead of stdout");
  command->footer("Example: rangegrasp table results/laser_single --format markdown");
  command->callback([arguments] {
    const Store store = Store::Open(arguments->folder);
    WriteResult(report::Format(report::BuildTable(store), ParseTableFormat(arguments->format)),
                arguments->out);
  });
}

void AddCompare(CLI::App& app) {
  auto* command = app.add_subcommand(
      "compare", "Compare two runs on the same seeds, trial by trial (McNemar's exact test).");
  auto first = std::make_shared<std::string>();
  auto second = std::make_shared<std::string>();
  command->add_option("first", *first, "results folder")->required();
  command->add_option("second", *second, "results folder")->required();
  command->footer(
      "Example: rangegrasp compare results/laser_single results/laser_single_published");
  command->callback([first, second] {
    const auto c = report::Compare(Store::Open(*first).ReadAll(), Store::Open(*second).ReadAll());
    if (c.pairs == 0) {
      throw core::InputError(*first + ", " + *second +
                             ": no trial of the same id and seed in both");
    }
    std::ostringstream out;
    out << "pairs " << c.pairs << "\ndelivered by both " << c.both << "\nonly by the first "
        << c.only_first << "\nonly by the second " << c.only_second << "\nsame outcome "
        << c.same_outcome << "\nMcNemar exact p " << c.p_value << "\n";
    WriteResult(out.str());
  });
}

// A shard that was forgotten, or whose run was killed.
void WarnOfMissing(const std::map<std::string, std::string>& stamp, std::size_t trials) {
  const auto objects = stamp.find("objects");
  const auto each = stamp.find("trials_per_object");
  if (objects == stamp.end() || each == stamp.end()) return;
  const auto commas = std::count(objects->second.begin(), objects->second.end(), ',');
  const auto expected = static_cast<std::size_t>(commas + 1) * std::stoull(each->second);
  if (trials < expected) {
    spdlog::warn("{} of the experiment's {} trials are in these folders; is a shard missing?",
                 trials, expected);
  }
}

void Merge(const std::vector<std::string>& folders, const std::string& out) {
  if (Store::Exists(out))
    throw core::InputError(out + ": holds results already; name a new folder");
  const auto stamp = Store::Open(folders.front()).ReadStamp();
  std::set<std::string> ids;
  std::vector<experiment::TrialResult> all;
  for (const std::string& folder : folders) {
    const Store shard = Store::Open(folder);
    CheckSameRun(shard.ReadStamp(), stamp, folder);
    for (auto& result : shard.ReadAll()) {
      if (!ids.insert(result.id).second) {
        throw core::InputError(folder + ": trial " + result.id +
                               " is in another of the folders too");
      }
      all.push_back(std::move(result));
    }
  }
  WarnOfMissing(stamp, all.size());
  Store merged = Store::Create(out);
  merged.WriteStamp(stamp);
  for (const auto& result : all) merged.Write(result);
}

void AddMerge(CLI::App& app) {
  auto* command = app.add_subcommand("merge", "Join the results of shards into one folder.");
  auto folders = std::make_shared<std::vector<std::string>>();
  auto out = std::make_shared<std::string>();
  command->add_option("folders", *folders, "results folders")->required();
  command->add_option("-o,--out", *out, "new results folder")->required();
  command->footer("Example: rangegrasp merge results/shard1 results/shard2 -o results/all");
  command->callback([folders, out] {
    Merge(*folders, *out);
    spdlog::info("{} folders joined in {}", folders->size(), *out);
  });
}

}  // namespace

void AddTrialCommand(CLI::App& app);

void AddRunCommands(CLI::App& app) {
  AddRun(app);
  AddTable(app);
  AddTrialCommand(app);
  AddCompare(app);
  AddMerge(app);
}

}  // namespace rangegrasp::cli
