#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "base/error.h"
#include "base/words.h"
#include "cli/output.h"
#include "cli/run.h"
#include "experiment/report.h"
#include "experiment/runner.h"
#include "geometry/cloud_file.h"
#include "report/command/report_commands.h"
#include "trial/grasping_task.h"
#include "trial/judge.h"
#include "trial/table.h"
#include "trial/trial.h"

namespace rangegrasp::cli {
namespace {

using experiment::Record;
using experiment::Store;
using nlohmann::ordered_json;
using trial::Arrangement;
using trial::Attempt;
using trial::AttemptOptions;
using trial::Cell;
using trial::Outcome;
using trial::Sensed;
using trial::TrialSpec;

ordered_json JsonOf(const base::Pose& X) {
  ordered_json numbers = ordered_json::array();
  const Eigen::Matrix4d& m = X.matrix();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) numbers.push_back(m(row, column));
  }
  return numbers;
}

ordered_json WriteClouds(const Sensed& sensed, const std::string& id,
                         const std::filesystem::path& folder) {
  ordered_json clouds = ordered_json::array();
  for (std::size_t i = 0; i < sensed.observation.views.size(); ++i) {
    const geometry::View& view = sensed.observation.views[i];
    const std::string file =
        i == 0 ? fmt::format("clouds/{}.pcd", id) : fmt::format("clouds/{}_view{}.pcd", id, i + 1);
    geometry::WriteCloud(folder / file, view.image, trial::TruthFields(view, sensed.truth[i]));
    const auto& states = sensed.truth[i].state;
    clouds.push_back(
        {{"file_name", file},
         {"rows", view.image.profiles},
         {"columns", view.image.samples},
         {"X_WV", JsonOf(view.X_CV)},
         {"spacing_m", view.spacing_m},
         {"measured", std::count(states.begin(), states.end(), sensing::SampleState::kMeasured)}});
  }
  return clouds;
}

ordered_json ObjectsOf(const Arrangement& arranged) {
  ordered_json objects = ordered_json::array();
  const sim::World& world = arranged.world;
  for (int i = 0; i < world.objects(); ++i) {
    if (world.parked(i)) continue;
    objects.push_back({{"name", world.object_name(i)},
                       {"label", i + 1},
                       {"target", i == arranged.target},
                       {"surface", world.object_surface(i)},
                       {"mass_kg", world.ObjectMass(i)},
                       {"X_WO", JsonOf(world.ObjectPose(i))}});
  }
  return objects;
}

// The label that most samples of a perceived object bear; 0: the scene's.
int LabelOf(const grasp::DetectedObject& object, const Sensed& sensed) {
  const auto votes = trial::ObjectVotes(object.samples, sensed);
  const auto most = std::max_element(
      votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == votes.end() ? 0 : most->first + 1;
}

// Candidates that the hand did not try have no outcome.
ordered_json GraspsOf(const Attempt& attempt, const Sensed& sensed) {
  const grasp::Detection& detection = attempt.detected.detection;
  std::map<std::size_t, std::string> outcomes;
  for (const std::size_t tried : attempt.executed) outcomes[tried] = "withdrawn";
  if (!attempt.executed.empty()) {
    outcomes[attempt.executed.back()] = std::string(base::Word(attempt.outcome));
  }
  ordered_json grasps = ordered_json::array();
  for (std::size_t i = 0; i < detection.grasps.size(); ++i) {
    const grasp::DetectedGrasp& g = detection.grasps[i];
    const auto outcome = outcomes.find(i);
    grasps.push_back(
        {{"label", LabelOf(detection.objects.at(g.object), sensed)},
         {"type", base::Word(g.type)},
         {"X_WH", JsonOf(g.X_CH)},
         {"opening_m", g.opening_m},
         {"width_m", g.width_m},
         {"pitch_rad", g.pitch_rad},
         {"contact_angle_rad", g.contact_angle_rad},
         {"score", g.score},
         {"collides", g.collides},
         {"outcome", outcome == outcomes.end() ? ordered_json() : ordered_json(outcome->second)}});
  }
  return grasps;
}

// A data set's annotations.json, in the manner of COCO's: lists that refer to each other by "id",
// the position in the list, over all clouds.
class Annotations {
 public:
  explicit Annotations(const experiment::Stamp& stamp) : stamp_(stamp) {
    json_["info"] = {{"description", "trials of " + experiment::Need(stamp.identity, "experiment")},
                     {"stamp", experiment::LineOf(stamp)},
                     {"units", "metres, radians, kilograms"},
                     {"frame", "W: origin on the table top at the middle of the workspace, z up"},
                     {"poses", "4 x 4, row by row; X_WO takes points of O to W"}};
    for (const char* list : {"categories", "clouds", "annotations", "grasps"}) {
      json_[list] = ordered_json::array();
    }
  }

  // @param record  what ExportTrial gave; left out if it has no data
  void Add(const Record& record) {
    if (record.result.data == "{}") return;
    auto data = ordered_json::parse(record.result.data);
    const std::size_t first_cloud = json_["clouds"].size();
    for (auto& cloud : data["clouds"]) {
      cloud["case"] = record.which.id;
      cloud["outcome"] = record.result.outcome;
      Append("clouds", cloud);
    }
    std::map<int, std::size_t> annotation_of;
    for (auto& object : data["objects"]) {
      object["cloud_id"] = first_cloud;
      object["category_id"] = CategoryOf(object["name"]);
      annotation_of[object["label"]] = Append("annotations", object);
    }
    for (auto& grasp : data["grasps"]) {
      grasp["cloud_id"] = first_cloud;
      const auto found = annotation_of.find(grasp["label"]);
      grasp["annotation_id"] =
          found == annotation_of.end() ? ordered_json() : ordered_json(found->second);
      grasp.erase("label");
      Append("grasps", grasp);
    }
  }

  std::string Text() const { return json_.dump(1) + "\n"; }

 private:
  std::size_t Append(const char* list, const ordered_json& item) {
    const std::size_t id = json_[list].size();
    ordered_json with_id = {{"id", id}};
    with_id.update(item);
    json_[list].push_back(std::move(with_id));
    return id;
  }
  std::size_t CategoryOf(const std::string& name) {
    const auto [found, fresh] = categories_.try_emplace(name, categories_.size());
    if (fresh) Append("categories", {{"name", name}, {"title", TitleOf(stamp_, name)}});
    return found->second;
  }

  ordered_json json_;
  const experiment::Stamp& stamp_;
  std::map<std::string, std::size_t> categories_;
};

// Runs a trial again and leaves what its sensor measured as `clouds/<id>.pcd` in the folder
// (further views: `<id>_view2.pcd`), with the truth of each sample as fields "label" and "state".
// @return the trial's result; its data is a JSON object: "clouds" (file, rows, columns, X_WV,
// spacing_m, measured), "objects" (name, label, target, X_WO and mass before anything moved),
// "grasps" (all candidates). Poses are 16 numbers, row by row.
// @throws base::RunError naming a file that cannot be written.
experiment::Result ExportTrial(const Cell& cell, const TrialSpec& spec,
                               const std::filesystem::path& folder) {
  auto arranged = trial::ArrangeTrial(cell, spec);
  if (!arranged) {
    return {std::string(base::Word(Outcome::kCrashed)), "arrange", "no arrangement", "{}", {}};
  }
  ordered_json data = {{"clouds", {}}, {"objects", ObjectsOf(*arranged)}};
  Sensed sensed;
  AttemptOptions options;
  options.seed = spec.seed;
  options.target = arranged->target;
  options.on_sensed = [&](const Sensed& all) {
    sensed = all;
    data["clouds"] = WriteClouds(sensed, trial::TrialId(spec), folder);
  };
  const Attempt attempt = trial::RunAttempt(cell, arranged->world, options);
  data["grasps"] = GraspsOf(attempt, sensed);
  return {std::string(base::Word(attempt.outcome)), attempt.stage, attempt.detail, data.dump(), {}};
}

struct ExportArguments {
  std::string folder, out;
  int jobs = 1;
  bool clouds = false;
};

void ExportRecords(const std::vector<Record>& records, const std::filesystem::path& out) {
  std::string lines;
  for (const Record& record : records) lines += experiment::ToJson(record) + "\n";
  WriteResult(lines, out / "records.jsonl");
  WriteResult(CsvOf(experiment::FlatGridOf(records)), out / "records.csv");
}

// Those cases of an experiment that a store has records of.
std::vector<experiment::Case> CasesOf(const experiment::Experiment& e,
                                      const std::vector<Record>& records) {
  std::set<std::string> ids;
  for (const Record& record : records) ids.insert(record.which.id);
  std::vector<experiment::Case> cases = e.cases;
  std::erase_if(cases, [&](const experiment::Case& c) { return !ids.contains(c.id); });
  return cases;
}

// Where a trial ends differently from its record, the program or a model is another one.
int Differing(const std::vector<Record>& records, const std::vector<Record>& exported) {
  std::map<std::string, std::string> outcomes;
  for (const Record& record : records) outcomes[record.which.id] = record.result.outcome;
  return static_cast<int>(std::count_if(
      exported.begin(), exported.end(),
      [&](const Record& record) { return outcomes[record.which.id] != record.result.outcome; }));
}

// Runs the trials again, each in a process of its own. What is done is kept in a store, until all
// is: an export that was stopped goes on.
void ExportClouds(const Store& store, const std::string& folder, const ExportArguments& arguments,
                  const std::filesystem::path& out) {
  const auto stamp = store.ReadStamp();
  const auto e = ReopenExperiment(stamp, folder);
  e.task->Hide(folder);
  e.task->Hide(out);
  const trial::Cell& cell = trial::CellOf(*e.task);
  const auto records = store.ReadAll();
  const auto cases = CasesOf(e, records);
  if (Store::Exists(out)) {
    const auto begun = Store::Open(out).ReadStamp();
    if (!begun.identity.empty()) CheckSameRun(begun, e.stamp, out.string());
  }
  Store exported = Store::Create(out);
  exported.WriteStamp(e.stamp);
  const auto missing = Missing(cases, exported);
  if (!missing.empty()) e.task->Prepare();
  RunCases(
      missing,
      [&](const experiment::Case& which) { return ExportTrial(cell, trial::SpecOf(which), out); },
      exported, {.jobs = arguments.jobs, .case_limit_s = e.common.case_limit_s},
      ProgressBar(static_cast<int>(cases.size() - missing.size()), static_cast<int>(cases.size())));
  const auto made = exported.ReadAll();
  Annotations annotations(stamp);
  for (const Record& record : made) annotations.Add(record);
  WriteResult(annotations.Text(), out / "annotations.json");
  if (const int differing = Differing(records, made); differing > 0) {
    spdlog::warn(
        "{} of {} trials ended differently from their records: was the program or a model "
        "changed since?",
        differing, records.size());
  }
  const auto crashes = experiment::CrashReasons(made);
  if (!crashes.empty()) {
    throw base::RunError(
        fmt::format("{}: trials crashed:\n  {}", out.string(), base::Join(crashes, "\n  ")));
  }
}

void Export(const ExportArguments& arguments) {
  const auto stores = experiment::StoresIn(arguments.folder);
  for (const auto& folder : stores) {
    const std::filesystem::path out = stores.size() == 1 ? std::filesystem::path(arguments.out)
                                                         : arguments.out / folder.filename();
    const Store store = Store::Open(folder);
    ExportRecords(store.ReadAll(), out);
    if (arguments.clouds) {
      if (std::filesystem::weakly_canonical(out) == std::filesystem::weakly_canonical(folder)) {
        throw base::InputError(out.string() + ": holds the run itself; --out names another folder");
      }
      ExportClouds(store, folder.string(), arguments, out);
      Store::Remove(out);
    }
    spdlog::info("{} trials in {}", store.Count(), out.string());
  }
}

}  // namespace

void AddExportCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "export",
      "Records of a run as CSV and JSON lines; with --clouds a data set: clouds with labels, poses "
      "of the objects, all candidate grasps with the outcomes of those that were tried.");
  auto a = std::make_shared<ExportArguments>();
  command->add_option("folder", a->folder, "results folder, of several seeds, too")->required();
  command->add_option("-o,--out", a->out, "folder for records.csv, records.jsonl, ...")->required();
  command->add_flag("--clouds", a->clouds,
                    "run the trials again and write clouds/<id>.pcd and annotations.json (task: "
                    "grasping)");
  AddJobsOption(*command, "trials", a->jobs);
  command->footer(
      "Example: rangegrasp export results/laser_single -o data/laser_single --clouds\n"
      "An export that was stopped goes on when it is called again.");
  command->callback([a] { Export(*a); });
}

}  // namespace rangegrasp::cli
