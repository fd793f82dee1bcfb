#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/data_folder.h"
#include "base/error.h"
#include "base/finding.h"
#include "base/words.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "experiment/kinds.h"
#include "sim/check/check.h"
#include "sim/check_object.h"
#include "trial/cell.h"
#include "trial/command/grasping_commands.h"
#include "trial/grasping_task.h"
#include "trial/registry.h"

namespace rangegrasp::cli {
namespace {

using Findings = std::vector<base::Finding>;

struct CheckArguments {
  std::string file;
  std::string as;
  std::string detector;
  std::vector<std::string> set;
  bool json = false;
};

// What its answers on a few scans were understood as. @throws base::InputError if one is wrong
void CheckDetectorOf(const experiment::Experiment& e, bool quiet = false) {
  const auto& cell = trial::CellOf(*e.task);
  const auto* detector = trial::FindDetector(cell.options.detector);
  if (!detector->check_answers) return;
  std::string text;
  const bool usable = detector->check_answers(cell, text);
  if (!quiet) WriteResult(text);
  if (!usable) throw base::InputError("the detector cannot be used as it is");
}

// The detector of a command line in place of the shipped experiment's.
void CheckDetectorAlone(const CheckArguments& arguments) {
  std::vector<std::string> words = base::Split(arguments.detector, ' ');
  std::erase(words, "");
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (std::filesystem::exists(words[i])) words[i] = std::filesystem::absolute(words[i]).string();
  }
  if (!words.empty() && words.front().find('/') != std::string::npos) {
    words.front() = std::filesystem::absolute(words.front()).string();
  }
  experiment::Changes changes;
  changes.set = arguments.set;
  changes.set.insert(changes.set.begin(),
                     "detector={command: " + nlohmann::json(words).dump() + "}");
  CheckDetectorOf(experiment::OpenExperiment(base::FindExperiment("laser_single"),
                                             experiment::AllKinds(), changes));
}

Findings CheckFile(const CheckArguments& arguments, std::string& kind) {
  const std::filesystem::path file = arguments.file;
  if (file.extension() == ".yaml" || file.extension() == ".yml") {
    kind = "experiment";
    experiment::Changes changes;
    changes.set = arguments.set;
    Findings findings = experiment::CheckExperiment(file, experiment::AllKinds(), changes);
    // What the checks do not look at: objects, sensor, published table.
    if (base::HasError(findings)) return findings;
    const auto e = experiment::OpenExperiment(file, experiment::AllKinds(), changes);
    if (e.kind->name == trial::GraspingTask().name) {
      CheckDetectorOf(e, arguments.json);
    }
    return findings;
  }
  const check::Kind what = arguments.as.empty() ? check::KindOf(file)
                                                : base::FromWord<check::Kind>(arguments.as, "--as");
  kind = base::Word(what);
  return what == check::Kind::kObject ? sim::CheckObject({file.stem().string(), file})
                                      : check::CheckModel(file, what);
}

std::string JsonOf(const std::string& file, const std::string& kind, const Findings& findings) {
  nlohmann::ordered_json json = {
      {"file", file}, {"kind", kind}, {"findings", nlohmann::ordered_json::array()}};
  for (const base::Finding& f : findings) {
    json["findings"].push_back({{"severity", f.error ? "error" : "warning"},
                                {"where", f.where},
                                {"element", f.element},
                                {"what", f.what},
                                {"cure", f.cure}});
  }
  return json.dump(2) + "\n";
}

void Check(const CheckArguments& arguments) {
  if (arguments.file.empty() == arguments.detector.empty()) {
    throw base::InputError("check needs either a file or --detector");
  }
  if (!arguments.detector.empty()) return CheckDetectorAlone(arguments);
  std::string kind;
  const Findings findings = CheckFile(arguments, kind);
  const auto errors =
      std::count_if(findings.begin(), findings.end(), [](const auto& f) { return f.error; });
  const auto warnings = static_cast<std::ptrdiff_t>(findings.size()) - errors;
  if (arguments.json) {
    WriteResult(JsonOf(arguments.file, kind, findings));
  } else {
    std::string text;
    for (const base::Finding& finding : findings) text += base::TextOf(finding) + "\n";
    text += fmt::format("{}, checked as {} {}: {}\n", arguments.file,
                        kind.find_first_of("aeo") == 0 ? "an" : "a", kind,
                        findings.empty() ? std::string("nothing is wrong")
                                         : fmt::format("{} errors, {} warnings", errors, warnings));
    WriteResult(text);
  }
  if (errors > 0) throw base::InputError(fmt::format("{}: cannot work as it is", arguments.file));
}

}  // namespace

void AddCheckCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "check",
      "Look for what is wrong with a scene, an arm, a hand, an object (MJCF), an experiment "
      "(YAML) or a detector of your own, and say how one edit cures it.");
  auto a = std::make_shared<CheckArguments>();
  command->add_option("file", a->file, "MJCF or experiment file");
  command->add_option("--as", a->as, "what an MJCF file is (default: by what it holds)")
      ->check(CLI::IsMember(base::WordList<check::Kind>()));
  command->add_option("--detector", a->detector,
                      "in place of a file: a grasp detector of your own, e.g. \"python3 "
                      "my_detector.py\"; it is asked about a few scans");
  command->add_option("--set", a->set, "KEY=VALUE of an experiment, as for run");
  command->add_flag("--json", a->json, "findings as JSON");
  command->footer(
      "Example: rangegrasp check scenes/tabletop.xml\nExit codes: 0 nothing that keeps it from "
      "working, 2 errors. `run` does the same before its first trial.");
  command->callback([a] { Check(*a); });
}

}  // namespace rangegrasp::cli
