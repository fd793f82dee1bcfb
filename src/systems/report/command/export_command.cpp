#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"
#include "cli/output.h"
#include "cli/run.h"
#include "experiment/report.h"
#include "experiment/runner.h"
#include "geometry/cloud_file.h"
#include "geometry/view_images.h"
#include "report/command/report_commands.h"
#include "trial/grasping_task.h"
#include "trial/judge.h"
#include "trial/trial.h"

namespace rangegrasp::cli {
namespace {

namespace fs = std::filesystem;
using experiment::Record;
using experiment::Store;
using nlohmann::ordered_json;
using trial::Attempt;
using trial::Sensed;

constexpr const char* kRecords = "records.jsonl";
constexpr const char* kAnnotations = "annotations.json";

ordered_json JsonOf(const base::Pose& X) {
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = X.matrix();
  return std::vector<double>(rows.data(), rows.data() + rows.size());
}

/// Writes clouds. Pictures have the name of their cloud; null if the sensor takes none.
ordered_json WriteClouds(const Sensed& sensed, const std::string& id, const fs::path& folder) {
  ordered_json clouds = ordered_json::array();
  for (std::size_t i = 0; i < sensed.observation.views.size(); ++i) {
    const geometry::View& view = sensed.observation.views[i];
    const std::string stem = i == 0 ? "clouds/" + id : fmt::format("clouds/{}_view{}", id, i + 1);
    const std::string file = stem + ".pcd";
    geometry::WriteCloud(folder / file, view.image, trial::TruthFields(view, sensed.truth[i]));
    const auto& states = sensed.truth[i].state;
    ordered_json images;
    if (const auto written = geometry::WriteImages(view, folder, stem)) {
      images = written->Described<ordered_json>();
    }
    clouds.push_back({{"file_name", file},
                      {"rows", view.image.profiles},
                      {"columns", view.image.samples},
                      {"X_WV", JsonOf(view.X_CV)},
                      {"spacing_m", view.spacing_m},
                      {"measured", std::ranges::count(states, sensing::SampleState::kMeasured)},
                      {"images", images}});
  }
  return clouds;
}

ordered_json ObjectsOf(const trial::Arrangement& arranged) {
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

// All candidates; those that the hand did not try have no outcome.
ordered_json GraspsOf(const Attempt& attempt, const Sensed& sensed) {
  const grasp::Detection& detection = attempt.detected.detection;
  ordered_json grasps = ordered_json::array();
  for (std::size_t i = 0; i < detection.grasps.size(); ++i) {
    const grasp::DetectedGrasp& g = detection.grasps[i];
    const auto& samples = detection.objects.at(g.object).samples;
    const int label = trial::MainObject(samples, sensed).value_or(-1) + 1;  // 0 is the scene
    ordered_json outcome;
    if (attempt.executed == i) outcome = base::Word(attempt.outcome);
    grasps.push_back({{"label", label},
                      {"type", base::Word(g.type)},
                      {"X_WH", JsonOf(g.X_CH)},
                      {"opening_m", g.opening_m},
                      {"width_m", g.width_m},
                      {"pitch_rad", g.pitch_rad},
                      {"contact_angle_rad", g.contact_angle_rad},
                      {"score", g.score},
                      {"collides", g.collides},
                      {"outcome", outcome}});
  }
  return grasps;
}

// The annotations.json of a data set in the style of COCO: lists that refer to each other by "id",
// the position in the list over all clouds.
// @param records  results of ExportTrial; those without data are skipped
ordered_json AnnotationsOf(const experiment::Stamp& stamp, const std::vector<Record>& records) {
  ordered_json json = {
      {"info",
       {{"description", "trials of " + experiment::Need(stamp.identity, "experiment")},
        {"stamp", experiment::LineOf(stamp)},
        {"units", "metres, radians, kilograms"},
        {"frame", "W: origin on the table top at the middle of the workspace, z up"},
        {"poses", "4 x 4, row by row; X_WO transforms points from O to W"}}}};
  for (const char* list : {"categories", "clouds", "annotations", "grasps"}) {
    json[list] = ordered_json::array();
  }
  const auto append = [&](const char* list, const ordered_json& item) {
    const std::size_t id = json[list].size();
    ordered_json with_id = {{"id", id}};
    with_id.update(item);
    json[list].push_back(std::move(with_id));
    return id;
  };
  std::map<std::string, std::size_t> categories;
  for (const Record& record : records) {
    if (record.result.data == "{}") continue;
    auto data = ordered_json::parse(record.result.data);
    const std::size_t first_cloud = json["clouds"].size();
    for (auto& cloud : data["clouds"]) {
      cloud["case"] = record.which.id;
      cloud["outcome"] = record.result.outcome;
      append("clouds", cloud);
    }
    std::map<int, std::size_t> annotation_of;
    for (auto& object : data["objects"]) {
      const std::string name = object["name"];
      const auto [category, fresh] = categories.try_emplace(name, categories.size());
      if (fresh) append("categories", {{"name", name}, {"title", TitleOf(stamp, name)}});
      object["cloud_id"] = first_cloud;
      object["category_id"] = category->second;
      annotation_of[object["label"]] = append("annotations", object);
    }
    for (auto& grasp : data["grasps"]) {
      const auto found = annotation_of.find(grasp["label"]);
      grasp["cloud_id"] = first_cloud;
      grasp["annotation_id"] = nullptr;
      if (found != annotation_of.end()) grasp["annotation_id"] = found->second;
      grasp.erase("label");
      append("grasps", grasp);
    }
  }
  return json;
}

// Runs a trial again and writes its sensor's measurements to `clouds/<id>.pcd` in the folder
// (further views: `<id>_view2.pcd`), with the ground truth of each sample as fields "label" and
// "state".
// @return the trial's result; its data is a JSON object: "clouds" (file, rows, columns, X_WV,
// spacing_m, measured), "objects" (name, label, target, X_WO and mass before anything moved),
// "grasps" (all candidates). Poses are 16 numbers, row by row.
// @throws base::RunError naming a file that cannot be written.
experiment::Result ExportTrial(const trial::Cell& cell, const trial::TrialSpec& spec,
                               const fs::path& folder) {
  auto arranged = trial::ArrangeTrial(cell, spec);
  if (!arranged) {
    return {
        std::string(base::Word(trial::Outcome::kCrashed)), "arrange", "no arrangement", "{}", {}};
  }
  ordered_json data = {{"clouds", {}}, {"objects", ObjectsOf(*arranged)}};
  Sensed sensed;
  trial::AttemptOptions options;
  options.seed = spec.seed;
  options.target = arranged->target;
  options.on_sensed = [&](const Sensed& all) {
    sensed = all;
    data["clouds"] = WriteClouds(sensed, trial::CaseOf(spec).id, folder);
  };
  const Attempt attempt = trial::RunAttempt(cell, arranged->world, options);
  data["grasps"] = GraspsOf(attempt, sensed);
  return {std::string(base::Word(attempt.outcome)), attempt.stage, attempt.detail, data.dump(), {}};
}

struct ExportArguments {
  std::string folder, out;
  int jobs = 1;
  bool clouds = false, run_detector = false;
};

// Key of the data in an export's stamp, which a run's does not have.
constexpr const char* kExport = "export";

constexpr const char* kOtherFolder = "choose another folder with --out";

// Refuses a folder whose store holds anything but an export of the same run that was begun.
void CheckBegun(const fs::path& out, const experiment::Stamp& wanted) {
  if (!Store::Exists(out)) return;
  const auto begun = Store::Open(out).ReadStamp();
  if (begun.identity.empty()) return;
  if (!begun.data.contains(kExport)) {
    throw base::InputError(out.string() + ": holds the results of a run; " + kOtherFolder);
  }
  CheckSameRun(begun, wanted, out.string(), kOtherFolder);
}

// A stamp's line without the number of cases, which --resume may increase.
std::string WithoutCases(std::string line) {
  const std::size_t begin = line.find(", cases ");
  if (begin == std::string::npos) return line;
  return line.erase(begin, std::min(line.find(',', begin + 1), line.size()) - begin);
}

// Refuses a folder with the data set of another run: its clouds would stay among the new records.
// @param stamp  of the records
void CheckDataSet(const fs::path& out, const experiment::Stamp& stamp) {
  const fs::path file = out / kAnnotations;
  if (!fs::exists(file)) return;
  const auto json =
      ordered_json::parse(base::ReadFile(file), /*cb=*/nullptr, /*allow_exceptions=*/false);
  const ordered_json::json_pointer name("/info/stamp");
  const bool has = json.contains(name) && json[name].is_string();
  const std::string made = has ? json[name].get<std::string>() : "unknown";
  if (WithoutCases(made) == WithoutCases(experiment::LineOf(stamp))) return;
  throw base::InputError(fmt::format("{}: contains the export of another run ({}); {}",
                                     out.string(), made, kOtherFolder));
}

// Refuses to write the export of one run into the folder of several seeds, or the other way round.
void CheckSeeds(const fs::path& out, bool several) {
  if (several && fs::exists(out / kRecords)) {
    throw base::InputError(out.string() + ": contains the export of one seed; " + kOtherFolder);
  }
  if (several || !fs::is_directory(out)) return;
  for (const auto& entry : fs::directory_iterator(out)) {
    if (!entry.path().filename().string().starts_with(experiment::kSeedPrefix)) continue;
    throw base::InputError(out.string() + ": contains several seeds; " + kOtherFolder);
  }
}

// Runs the trials again, each in its own process. Finished trials are kept in a store until all are
// done, so that a stopped export can be continued.
// @param stamp  of the records
void ExportClouds(const experiment::Stamp& stamp, const std::vector<Record>& records,
                  const experiment::Experiment& e, int jobs, const fs::path& out) {
  const trial::Cell& cell = trial::CellOf(*e.task);
  std::map<std::string, std::string> outcomes;  // of the records, by their ids
  for (const Record& record : records) outcomes[record.which.id] = record.result.outcome;
  auto cases = e.cases;
  std::erase_if(cases, [&](const experiment::Case& c) { return !outcomes.contains(c.id); });
  Store exported = Store::Create(out);
  auto own = e.stamp;
  own.data[kExport] = "clouds";
  exported.WriteStamp(own);
  const auto missing = Missing(cases, exported, /*again_crashed=*/true);
  if (!missing.empty()) e.task->Prepare();
  RunCases(
      missing,
      [&](const experiment::Case& which) { return ExportTrial(cell, trial::SpecOf(which), out); },
      exported, {.jobs = jobs, .case_limit_s = e.common.case_limit_s},
      ProgressBar(static_cast<int>(cases.size() - missing.size()), static_cast<int>(cases.size())));
  const auto made = exported.ReadAll();
  WriteResult(AnnotationsOf(stamp, made).dump(1) + "\n", out / kAnnotations);
  const auto differing = std::ranges::count_if(made, [&](const Record& record) {
    return outcomes[record.which.id] != record.result.outcome;
  });
  if (differing > 0) {
    spdlog::warn(
        "{} of {} trials ended differently from their records: has the program or a model changed "
        "since?",
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
  CheckSeeds(arguments.out, stores.size() > 1);
  for (const auto& folder : stores) {
    const fs::path out =
        stores.size() == 1 ? fs::path(arguments.out) : arguments.out / folder.filename();
    const Store store = Store::Open(folder);
    const auto stamp = store.ReadStamp();
    const auto records = store.ReadAll();
    std::optional<experiment::Experiment> e;
    const bool own = fs::weakly_canonical(out) == fs::weakly_canonical(folder);
    if (arguments.clouds) {
      const std::string task = experiment::InFolder(folder, [&] {
        experiment::Need(stamp.identity, "experiment");  // for annotations.json
        return experiment::KindOf(stamp).name;
      });
      if (task != trial::GraspingTask().name) {
        throw base::InputError(
            fmt::format("{}: `task: {}` has no clouds, only `task: grasping` has; without --clouds "
                        "the records are written",
                        folder.string(), task));
      }
      if (own) {
        throw base::InputError(out.string() + ": is the folder of the run; " + kOtherFolder);
      }
      // Before anything is written, because it may be refused.
      e = ReopenExperiment(stamp, folder.string(), arguments.run_detector);
      for (const fs::path& hidden : {folder, out}) e->task->Hide(hidden);
    }
    if (!own) CheckBegun(out, e ? e->stamp : stamp);
    CheckDataSet(out, stamp);
    const experiment::FolderLock lock(out);
    std::string lines;
    for (const Record& record : records) lines += experiment::ToJson(record) + "\n";
    WriteResult(lines, out / kRecords);
    WriteResult(CsvOf(experiment::FlatGridOf(records)), out / "records.csv");
    if (e) {
      ExportClouds(stamp, records, *e, arguments.jobs, out);
      Store::Remove(out);
    }
    spdlog::info("{} in {}", base::Counted(records.size(), "trial"), out.string());
  }
}

}  // namespace

void AddExportCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "export",
      "Write the records of a run as CSV and JSON lines; with --clouds also a data set: labelled "
      "clouds, object poses, all candidate grasps and the outcomes of those that were tried.");
  auto a = std::make_shared<ExportArguments>();
  command->add_option("folder", a->folder, "results folder, of one or of several seeds")
      ->required();
  command->add_option("-o,--out", a->out, "output folder for records.csv, records.jsonl, ...")
      ->required();
  command->add_flag(
      "--clouds", a->clouds,
      "also run the trials again and write clouds/<id>.pcd and annotations.json (task: grasping)");
  AddRunDetectorOption(*command, a->run_detector);
  AddJobsOption(*command, "trials", a->jobs);
  command->footer(
      "Example: rangegrasp export results/laser_single -o data/laser_single --clouds\nRepeat the "
      "command to continue a stopped export.");
  command->callback([a] { Export(*a); });
}

}  // namespace rangegrasp::cli
