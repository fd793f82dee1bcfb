#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "cli/run.h"
#include "experiment/experiment.h"
#include "experiment/store.h"

namespace rangegrasp::cli {
namespace {

namespace fs = std::filesystem;
using experiment::Record;
using experiment::Stamp;
using experiment::Store;

void AddTable(CLI::App& app) {
  struct Arguments {
    std::string folder, format = "text";
    bool files = false;
  };
  auto* command = app.add_subcommand(
      "table", "Print the tables of a results folder, or of a folder with several seeds, again.");
  auto a = std::make_shared<Arguments>();
  command->add_option("folder", a->folder, "results folder")->required();
  AddFormatOption(*command, a->format);
  command->add_flag("--files", a->files,
                    "also write the table files and figures into the results folder");
  command->footer("Example: rangegrasp table results/laser_single --format markdown");
  command->callback([a] {
    const auto results = experiment::ReadResults(a->folder);
    const auto report = experiment::ReportOf(results);
    WriteTables(report, results.stamp, TableFormatFrom(a->format));
    if (!a->files) return;
    if (report.files.empty()) {
      spdlog::info("task {} has no table files or figures; --format csv prints the table as CSV",
                   experiment::KindOf(results.stamp).name);
    }
    for (const auto& [name, text] : report.files) {
      WriteResult(text, fs::path(a->folder) / name);
    }
  });
}

// ---- trial ----

struct TrialArguments {
  std::string folder;
  std::vector<std::string> ids;
  experiment::ReplayOptions replay;
  bool json = false, run_detector = false;
};

std::string Short(const nlohmann::ordered_json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.is_number_float() ? fmt::format("{:.4g}", value.get<double>()) : value.dump();
}

// "spread-0000: delivered", or "spread-0000: no_path in stage plan"; the detail, the kind's
// summary, figures without those of the log, times.
std::string SummaryOf(const Record& record, const std::string& success,
                      const experiment::TaskKind& kind) {
  const auto& [which, result] = record;
  std::string text = which.id + ": " + result.outcome;
  const bool failed = result.outcome != success;
  if (failed) text += " in stage " + result.stage;
  text += "\n";
  if (failed && !result.detail.empty()) text += "  " + result.detail + "\n";
  std::vector<std::string> figures, times;
  const auto data = nlohmann::ordered_json::parse(result.data);
  const auto by_text = data.find("text");  // the second verdict of a grasping trial
  if (failed && by_text != data.end() && by_text->is_object() &&
      by_text->value("outcome", result.outcome) != result.outcome) {
    text += "  by the text's definition: " + by_text->value("outcome", "") +
            " (the trial went on after the stricter verdict)\n";
  }
  for (const auto& [name, value] : data.items()) {
    if (value.is_primitive() && !value.is_null() && value != "") {
      figures.push_back(name + " " + Short(value));
    }
  }
  for (const auto& [stage, seconds] : result.seconds) {
    if (stage.find(':') == std::string::npos) {
      times.push_back(fmt::format("{} {:.3f}", stage, seconds));
    }
  }
  if (const std::string more = kind.summary ? kind.summary(result) : ""; !more.empty()) {
    text += "  " + more + "\n";
  }
  if (!figures.empty()) text += "  " + base::Join(figures) + "\n";
  return text + "  seconds: " + base::Join(times) + "\n";
}

// Cases that are listed: a screenful.
constexpr std::size_t kListed = 20;

// The cases of a run, failed ones first, from which one is chosen to be run again.
std::string ListOf(std::vector<Record> records, const Stamp& stamp) {
  const std::string success = SuccessOf(experiment::KindOf(stamp), stamp);
  std::ranges::stable_partition(
      records, [&](const Record& record) { return record.result.outcome != success; });
  const std::size_t listed = std::min(records.size(), kListed);
  experiment::Grid grid{{"id", "group", "outcome", "stage"}, {true, true, true, true}, {}, false};
  for (const auto& [which, result] : std::span(records).first(listed)) {
    grid.rows.push_back({which.id, which.group, result.outcome, result.stage});
  }
  std::string text = TextOf(grid);
  if (listed < records.size()) {
    text += fmt::format("and {} more (--json lists all)\n", records.size() - listed);
  }
  return text;
}

void List(const TrialArguments& arguments) {
  if (arguments.replay.snapshots || !arguments.replay.video.empty()) {
    throw base::InputError("--snapshots and --video need an id; `rangegrasp trial " +
                           arguments.folder + "` lists the ids");
  }
  const Store store = Store::Open(arguments.folder);
  const auto records = store.ReadAll();
  if (!arguments.json) {
    return WriteResult(
        experiment::InFolder(arguments.folder, [&] { return ListOf(records, store.ReadStamp()); }));
  }
  for (const Record& record : records) WriteResult(experiment::ToJson(record) + "\n");
}

void Replay(const experiment::Experiment& e, const Store& store, const experiment::Case& which,
            const experiment::ReplayOptions& options, bool json) {
  const Record replayed{which, e.task->Replay(which, options)};
  WriteResult(json ? experiment::ToJson(replayed) + "\n"
                   : SummaryOf(replayed, SuccessOf(*e.kind, e.stamp), *e.kind));
  for (const Record& stored : store.ReadAll()) {
    if (stored.which.id != which.id || SameButTimes(stored, replayed)) continue;
    spdlog::warn(
        "the replay of {} differs from the stored result: has the program or a model changed "
        "since?",
        which.id);
  }
}

// Fails before a trial runs again: it would count a picture that cannot be written as its crash.
void CheckWritable(const fs::path& folder) {
  const bool fresh = !fs::exists(folder);
  base::MakeFolderOf(folder / "picture.png");
  if (access(folder.c_str(), W_OK) != 0) {
    throw base::InputError(folder.string() + ": cannot be written to: " + std::strerror(errno));
  }
  if (fresh) fs::remove(folder);  // some tasks have no pictures
}

void ReplayAll(TrialArguments arguments) {
  experiment::ReplayOptions& options = arguments.replay;
  const bool has_video = !options.video.empty();
  if (has_video) CheckEnding(options.video, {".mp4"});
  if (!options.camera.empty() && !options.snapshots && !has_video) {
    throw base::InputError("--camera needs --snapshots or --video");
  }
  if (arguments.ids.empty()) return List(arguments);
  if (has_video && arguments.ids.size() > 1) {
    throw base::InputError("--video shows one trial: give one id");
  }
  const Store store = Store::Open(arguments.folder);
  const auto e = ReopenExperiment(store.ReadStamp(), arguments.folder, arguments.run_detector);
  std::vector<const experiment::Case*> cases;
  for (const std::string& id : arguments.ids) cases.push_back(&CaseOf(e, id));
  options.folder = fs::path(arguments.folder) / "snapshots";
  if (options.snapshots) CheckWritable(options.folder);
  if (has_video) base::MakeFolderOf(options.video);
  e.task->Hide(arguments.folder);
  if (has_video) spdlog::info("drawing the video: two minutes without a graphics card");
  for (const experiment::Case* which : cases) Replay(e, store, *which, options, arguments.json);
  if (has_video) spdlog::info("video in {}", options.video.string());
  if (options.snapshots && fs::exists(options.folder)) {
    spdlog::info("pictures in {}", options.folder.string());
  } else if (options.snapshots) {
    spdlog::warn("task {} has no pictures of {}", e.kind->name, base::Join(arguments.ids));
  }
}

void AddTrial(CLI::App& app) {
  auto* command = app.add_subcommand(
      "trial",
      "Run individual cases of a run again and print their outcomes; without ids, list the cases.");
  auto a = std::make_shared<TrialArguments>();
  command->add_option("folder", a->folder, "results folder")->required();
  command->add_option("id", a->ids,
                      "ids of cases, e.g. coffee_cup-0003 (default: list the run's cases, failed "
                      "ones first)");
  command->add_flag(
      "--snapshots", a->replay.snapshots,
      "write pictures and files of every stage into <folder>/snapshots, with an overview sheet");
  command->add_option(
      "--video", a->replay.video,
      "write an MP4 of one case: the scene, the perceived objects, the state (needs ffmpeg)");
  command->add_option(
      "--camera", a->replay.camera,
      "camera of the scene for --snapshots and --video (default: one that keeps hand and "
      "object in view)");
  command->add_flag("--json", a->json, "print the whole records as JSON, a line each");
  AddRunDetectorOption(*command, a->run_detector);
  command->footer("Example: rangegrasp trial results/laser_single coffee_cup-0003 --snapshots");
  command->callback([a] { ReplayAll(*a); });
}

// ---- compare ----

constexpr std::size_t kShownKeys = 10;

// The differing keys. No line ends with a number: scripts/figures reads such lines as figures.
std::string KeysText(const std::vector<experiment::KeyDifference>& keys) {
  if (keys.empty()) return "the experiments have the same keys\n";
  const auto value = [](const std::string& text) { return text.empty() ? "not given" : text; };
  std::string text = "keys that differ:\n";
  const std::size_t shown = std::min(keys.size(), kShownKeys);
  for (const auto& [key, first, second] : std::span(keys).first(shown)) {
    text +=
        fmt::format("  {}: {} in the first, {} in the second\n", key, value(first), value(second));
  }
  if (shown < keys.size()) text += fmt::format("  and {} more\n", keys.size() - shown);
  return text;
}

void AddCompare(CLI::App& app) {
  auto* command = app.add_subcommand(
      "compare",
      "Compare two runs on the same seeds: the keys in which they differ, and their cases, one by "
      "one (McNemar's exact test).");
  auto first = std::make_shared<std::string>();
  auto second = std::make_shared<std::string>();
  command->add_option("first", *first, "results folder")->required();
  command->add_option("second", *second, "results folder")->required();
  command->footer(
      "Example: rangegrasp compare results/laser_single results/laser_single_as_published");
  command->callback([first, second] {
    const auto c = experiment::CompareRuns(*first, *second);
    if (!c.warning.empty()) spdlog::warn(c.warning);
    const auto percent = [&](int only) { return 100.0 * (c.both + only) / c.pairs; };
    WriteResult(fmt::format(
        "first: {}\nsecond: {}\n{}pairs {}\n{} by the first, % {:.1f}\n"
        "{} by the second, % {:.1f}\n{} by both {}\n"
        "only by the first {}\nonly by the second {}\nsame outcome {}\nMcNemar exact p {:g}\n",
        *first, *second, KeysText(c.keys), c.pairs, c.success, percent(c.only_first), c.success,
        percent(c.only_second), c.success, c.both, c.only_first, c.only_second, c.same_outcome,
        c.p_value));
  });
}

// ---- merge ----

void Merge(const std::vector<std::string>& folders, const std::string& out, bool complete) {
  const auto merged = experiment::Merge({folders.begin(), folders.end()}, out, complete);
  const bool all = merged.cases == merged.expected;
  if (all || !complete) {
    const Stamp stamp = Store::Open(out).ReadStamp();
    if (stamp.data.contains("experiment_text") && stamp.data.contains("set")) {  // not damaged
      WriteResult(experiment::FileAsRun(stamp), fs::path(out) / "experiment.yaml");
    }
    spdlog::info("{} joined in {}", base::Counted(folders.size(), "folder"), out);
  }
  if (all) return;
  // A shard was forgotten, or its run was killed.
  const std::string missing =
      fmt::format("only {} of the experiment's {} cases are in these folders; is a shard missing?",
                  merged.cases, merged.expected);
  if (complete) throw base::RunError(out + ": not written: " + missing);
  spdlog::warn(missing);
}

void AddMerge(CLI::App& app) {
  auto* command = app.add_subcommand("merge", "Join the results of shards into one folder.");
  auto folders = std::make_shared<std::vector<std::string>>();
  auto out = std::make_shared<std::string>();
  auto complete = std::make_shared<bool>(false);
  command->add_option("folders", *folders, "results folders")->required();
  command->add_option("-o,--out", *out, "new results folder")->required();
  command->add_flag("--complete", *complete, "write nothing unless all cases are present");
  command->footer("Example: rangegrasp merge results/shard1 results/shard2 -o results/all");
  command->callback([folders, out, complete] { Merge(*folders, *out, *complete); });
}

}  // namespace

void AddResultsCommands(CLI::App& app) {
  AddTable(app);
  AddTrial(app);
  AddCompare(app);
  AddMerge(app);
}

}  // namespace rangegrasp::cli
