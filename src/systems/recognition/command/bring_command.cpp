#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "base/data_folder.h"
#include "base/error.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "experiment/kinds.h"
#include "recognition/bring/bring_task.h"
#include "recognition/command/recognition_commands.h"
#include "trial/hand_over.h"

namespace rangegrasp::cli {
namespace {

struct BringArguments {
  std::string object;
  std::string experiment = "bring";
  std::string scene, arrangement, pictures;
  experiment::Changes changes;
  int run = 0;
};

void BringIt(const BringArguments& a) {
  experiment::Changes changes = a.changes;
  if (!a.scene.empty()) {
    changes.set.push_back("scene=" + std::filesystem::absolute(a.scene).string());
  }
  if (!a.arrangement.empty()) changes.set.push_back("arrangement=" + a.arrangement);
  changes.groups = {a.object};
  changes.trials = a.run + 1;
  const auto opened = experiment::OpenExperiment(base::FindExperiment(a.experiment),
                                                 experiment::AllKinds(), changes);
  const experiment::Case& which = opened.cases.back();
  const auto say = [](const std::string& words) { WriteResult(words + "\n"); };
  experiment::ReplayOptions pictures;
  pictures.folder = a.pictures;
  pictures.snapshots = !a.pictures.empty();
  const auto result = bring::BringAloud(*opened.task, which, say, pictures);
  WriteResult(fmt::format("{}: {}\n", which.id, result.outcome));
  const bool good = result.outcome == trial::kHandedOver || result.outcome == bring::kSaidAbsent;
  if (!good) {
    throw base::RunError(
        fmt::format("the {} was not handed over: {} {}", a.object, result.outcome, result.detail));
  }
}

}  // namespace

void AddBringCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "bring", "Bring an object: it is looked for among others, taken and handed over, in words.");
  auto a = std::make_shared<BringArguments>();
  command->add_option("object", a->object, "what is wanted, e.g. coffee_cup")->required();
  command->add_option("--experiment", a->experiment,
                      "experiment of `task: bring`: what lies there, and what is known");
  command->add_option("--scene", a->scene, "MJCF, instead of the experiment's");
  command->add_option("--arrangement", a->arrangement,
                      "single, scattered, touching, box or pile, instead of the experiment's");
  command->add_option("--run", a->run, "number of the run, from 0")->check(CLI::Range(0, 99'999));
  command->add_option("--seed", a->changes.seed, "instead of the experiment's")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--set", a->changes.set, "KEY=VALUE, instead of what the experiment says");
  command->add_option("--pictures", a->pictures, "folder for pictures of the run");
  command->footer("Example: rangegrasp bring coffee_cup --arrangement pile --pictures results/cup");
  command->callback([a] { BringIt(*a); });
}

}  // namespace rangegrasp::cli
