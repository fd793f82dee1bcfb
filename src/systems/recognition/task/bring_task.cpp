#include "recognition/task/bring_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "base/units.h"
#include "base/words.h"
#include "recognition/task/recognition_task.h"
#include "sim/bodies.h"
#include "trial/recorder.h"
#include "trial/registry.h"
#include "trial/table.h"

namespace rangegrasp::bring {
namespace {

using experiment::Case;
using nlohmann::ordered_json;

/// "stays within 30 deg of upright".
constexpr double kUpright_rad = base::Deg(30.0);

template <typename T>
ordered_json OrNull(const std::optional<T>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json JsonOf(const Step& step) {
  // What a person takes is never at the delivery place: `misplaced` would say nothing.
  const std::string outcome = trial::HandOverOutcome(step.attempt);
  const bool as_delivery = outcome == base::Word(step.attempt.outcome);
  ordered_json json = {{"at_wanted", step.at_wanted},
                       {"taken_for", step.taken_for},
                       {"grasp", step.grasp},
                       {"asked_upright", OrNull(step.asked_upright)},
                       {"touched_kept_free", step.touched_kept_free},
                       {"outcome", outcome},
                       {"stage", step.attempt.stage},
                       {"detail", as_delivery ? step.attempt.detail : ""}};
  json.update(trial::JsonOf(step.attempt));
  return json;
}

/// Counts and times of runs.
struct Row {
  std::string title = {};
  int runs = 0, good = 0, handed = 0, looks = 0, attempts = 0, cleared = 0;
  int kept_free = 0;  ///< the hand did not touch keep-free parts
  int upright = 0;    ///< it had to stay upright
  int stayed = 0;     ///< and stayed upright
  std::map<std::string, int> otherwise = {}, grasps = {};
  std::vector<double> robot_s = {}, compute_s = {};
};

void Add(const experiment::Record& record, const ordered_json& data, Row& row) {
  const std::string& outcome = record.result.outcome;
  const bool handed = outcome == trial::kHandedOver;
  const bool good = handed || outcome == kSaidAbsent;
  ++row.runs;
  row.good += good;
  row.handed += handed;
  if (!good) ++row.otherwise[outcome];
  if (!data.is_object() || !data.contains("attempts")) return;
  row.looks += data.at("looks").get<int>();
  row.cleared += data.at("cleared").get<int>();
  row.attempts += static_cast<int>(data.at("attempts").size());
  row.robot_s.push_back(data.at("simulated_s").get<double>() + data.at("homing_s").get<double>());
  row.compute_s.push_back(0.0);
  for (const auto& [stage, seconds] : record.result.seconds) {
    if (stage == "bring") row.compute_s.back() = seconds;
  }
  if (!handed) return;
  const ordered_json& last = data.at("attempts").back();
  const std::string grasp = last.at("grasp");
  ++row.grasps[grasp.empty() ? last.at("grasp_type").get<std::string>() : grasp];
  row.kept_free += !last.at("touched_kept_free").get<bool>();
  const bool upright = last.at("asked_upright") == true;
  row.upright += upright;
  row.stayed += upright && last.at("log").at("lean_rad").get<double>() <= kUpright_rad;
}

experiment::Grid TableOf(const std::vector<Row>& rows) {
  using experiment::kLeft;
  const auto per_run = [](int Row::*count) {
    return [count](const Row& row) {
      return row.runs == 0 ? std::nullopt
                           : std::optional(static_cast<double>(row.*count) / row.runs);
    };
  };
  const auto of = [](int Row::*count, int Row::*all) {
    return [=](const Row& row) {
      return row.*all == 0 ? "-" : fmt::format("{}/{}", row.*count, row.*all);
    };
  };
  const std::vector<experiment::Column<Row>> columns = {
      {"wanted", "", &Row::title, kLeft},
      {"runs", "", &Row::runs},
      {"as wanted", "", &Row::good},
      {"%", "", [](const Row& row) { return experiment::PercentText(row.good, row.runs, 1); }},
      {"95 %", "", [](const Row& row) { return experiment::IntervalText(row.good, row.runs); }},
      {"attempts / run", ".2f", per_run(&Row::attempts)},
      {"cleared / run", ".2f", per_run(&Row::cleared)},
      {"looks / run", ".2f", per_run(&Row::looks)},
      {"upright", "", of(&Row::stayed, &Row::upright)},
      {"kept free", "", of(&Row::kept_free, &Row::handed)},
      {"handed over by", "", [](const Row& row) { return experiment::CountsText(row.grasps); },
       kLeft},
      {"otherwise", "", [](const Row& row) { return experiment::CountsText(row.otherwise); },
       kLeft}};
  auto grid = GridOf(columns, rows);
  grid.total = true;
  return grid;
}

/// Reads the keys that `task: grasping` does not have.
BringOptions ReadBringKeys(base::YamlMap& map) {
  BringOptions o;
  map.Read("runs_per_object", o.runs_per_object, 1, 100000,
           "number of runs for each of `objects` as target");
  auto keys = map.Child("bring", "from the request to the hand of a person");
  keys.Read("absent", o.absent,
            "remove the wanted object before the program looks: it has to report that the object "
            "is absent");
  keys.Read(
      "use", o.use,
      "use of the wanted object: of the grasps in its grasps.yaml only those for this use are "
      "tried, before planned ones; default: all");
  keys.Read("max_tries", o.max_tries, 1, 20, "maximum number of grasps of the wanted object");
  keys.Read("max_looks", o.max_looks, 1, 20,
            "maximum number of views of one table before other objects are cleared away: the first "
            "by the fixed sensor, more by the wrist scanner if look.sensor is given");
  trial::ReadUser(keys.Child("user", "the person who takes the object"), o.hand_over);
  keys.Finish();
  recognition::RecognitionKeys(map, o.recognition).Finish();
  recognition::ReadLibraryOptions(map, o.library);
  return o;
}

/// Reads `grasps.yaml` next to each object's model.
GraspsOf ReadGrasps(const trial::Options& grasping) {
  GraspsOf grasps;
  for (const std::string& object : grasping.objects) {
    const auto mjcf = trial::ObjectModelOf(grasping, object).mjcf;
    grasps[object] = grasp::ReadNamedGrasps(grasp::NamedGraspsFile(mjcf));
  }
  return grasps;
}

/// A use that no object has is a misspelt one.
void CheckUse(const base::YamlMap& map, const std::string& use, const GraspsOf& grasps) {
  if (use.empty()) return;
  std::set<std::string> known;
  for (const auto& [object, named] : grasps) known.merge(grasp::UsesOf(named));
  if (known.contains(use)) return;
  map.Inner("bring").Fail(
      "use", known.empty() ? "no grasps.yaml of the known objects has a grasp for a use (`for`)"
                           : base::MustBeOneOf(use, {known.begin(), known.end()}) +
                                 " (the uses in the known objects' grasps.yaml)");
}

/// The index of an object in the world; nullopt: it is absent.
std::optional<int> NumberOf(const std::string& object, const sim::World& world) {
  for (int i = 0; i < world.objects(); ++i) {
    if (world.object_name(i) == object && !world.parked(i)) return i;
  }
  return std::nullopt;
}

/// The last executed grasp of the wanted object; empty if there is none.
std::string GraspOf(const experiment::Result& result) {
  const auto data = ordered_json::parse(result.data);
  if (!data.contains("attempts")) return "";
  const auto& attempts = data.at("attempts");
  for (auto attempt = attempts.rbegin(); attempt != attempts.rend(); ++attempt) {
    if (!attempt->at("at_wanted").get<bool>()) continue;
    const auto text = trial::GraspText(*attempt, attempt->at("grasp").get<std::string>());
    if (!text.empty()) return text;
  }
  return "";
}

class BringExperiment : public trial::SceneTask {
 public:
  BringExperiment(const BringOptions& options, const trial::Options& grasping, GraspsOf grasps,
                  const experiment::Common& common)
      : options_(options),
        cell_(grasping),
        library_(recognition::LibraryOf(grasping, options.library)),
        grasps_(std::move(grasps)),
        seed_(common.seed) {}

  /// Warnings of the known objects' grasps.
  std::vector<base::Finding> FindingsOfGrasps() const {
    std::vector<base::Finding> findings;
    for (const auto& [object, known] : grasps_) {
      if (known.grasps.empty()) continue;
      const auto model = trial::ObjectModelOf(cell_.options, object);
      std::ranges::move(grasp::CheckNamedGrasps(known, grasp::NamedGraspsFile(model.mjcf),
                                                sim::ObjectSurface(model).mesh.vertices,
                                                cell_.robot.hand().MaxGap()),
                        std::back_inserter(findings));
    }
    return findings;
  }

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (const std::string& object : cell_.options.objects) {
      const std::uint64_t of_object = base::DeriveSeed(base::DeriveSeed(seed_, "bring"), object);
      for (int i = 0; i < options_.runs_per_object; ++i) {
        const std::uint64_t seed = base::DeriveSeed(of_object, static_cast<std::uint64_t>(i));
        cases.push_back(trial::CaseOf({object, i, seed}));
      }
    }
    return cases;
  }

  experiment::Result Run(const Case& which) const override {
    trial::Recorder none(cell_);
    return RunCase(which, none);
  }

  experiment::Result Replay(const Case& which,
                            const experiment::ReplayOptions& options) const override {
    const auto recorder = trial::MakeRecorder(cell_, which.id, options);
    recorder->KeepMoments({"start", "closed", "lifted", "taken"});
    const auto result = RunCase(which, *recorder);
    recorder->Finish();
    return result;
  }

  void AddTo(experiment::Stamp& stamp) const override {
    trial::AddModelsTo(cell_.options, stamp);
    trial::AddTitles(cell_.options, stamp);
    recognition::AddLibraryTo(stamp, options_.library, cell_.options.objects);
    if (options_.absent) stamp.data[experiment::kSuccess] = kSaidAbsent;
  }

  const trial::Cell& cell() const override { return cell_; }

  // If the wanted object is absent, the target is the object that the scene is arranged around.
  std::optional<trial::Arrangement> Arrange(const Case& which,
                                            trial::Redraws& redraws) const override {
    const auto [wanted, index, seed] = trial::SpecOf(which);
    auto arranged = trial::ArrangeTrial(cell_, {OnTop(wanted, index), index, seed}, redraws);
    if (!arranged) return arranged;
    const auto target = NumberOf(wanted, arranged->world);
    if (target && options_.absent) {
      arranged->world.ParkObject(*target);
      arranged->world.Settle();
    } else if (target) {
      arranged->target = *target;
    }
    return arranged;
  }

 private:
  experiment::Result RunCase(const Case& which, trial::Recorder& recorder) const {
    const std::string wanted = trial::SpecOf(which).object;
    base::Stopwatch watch;
    trial::Redraws redraws;
    auto arranged = Arrange(which, redraws);
    if (!arranged) return trial::NoArrangement(redraws);
    sim::World& world = arranged->world;
    const auto target = NumberOf(wanted, world);
    const double arrange_s = watch.Restart();
    const Bring run = BringObject({options_, cell_, library_, grasps_}, wanted, target, which.seed,
                                  world, recorder);
    experiment::Result result = ResultOf(run, wanted, target.has_value());
    result.seconds.insert(result.seconds.begin(), {"arrange", arrange_s});
    result.seconds.emplace_back("bring", watch.Seconds());
    return result;
  }

  /// The object that an arrangement is drawn around. In a heap it lies on top: others take turns.
  std::string OnTop(const std::string& wanted, int index) const {
    const auto& objects = cell_.options.objects;
    const auto kind = cell_.options.arranger;
    const bool heap = kind == trial::kPile || kind == trial::kBox;
    if (!heap && !options_.absent) return wanted;
    if (objects.size() < 2) return wanted;
    const auto own = static_cast<std::size_t>(std::ranges::find(objects, wanted) - objects.begin());
    const std::size_t step = 1 + static_cast<std::size_t>(index) % (objects.size() - 1);
    return objects[(own + step) % objects.size()];
  }

  BringOptions options_;
  trial::Cell cell_;
  recognition::Library library_;
  GraspsOf grasps_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  if (map.Has("trials_per_object")) {
    map.Fail("trials_per_object", "use `runs_per_object` in `task: bring`");
  }
  if (map.Has("views")) map.Fail("views", "use bring.max_looks in `task: bring`");
  BringOptions options = ReadBringKeys(map);
  const trial::Options grasping = trial::ReadOptions(map, common.seed);
  const auto wrist = recognition::WristViewsOf(map, grasping);
  const bool wrist_looks = !wrist.sensor.empty() && options.max_looks > 1;
  if (!recognition::ModelsPass(map, grasping, wrist_looks, common)) return nullptr;
  options.library.seed = common.seed;
  trial::RequireOwnDetector(map, grasping);
  auto grasps = ReadGrasps(grasping);
  CheckUse(map, options.use, grasps);
  auto task = std::make_unique<BringExperiment>(options, grasping, std::move(grasps), common);
  if (common.on_findings && !common.on_findings(task->FindingsOfGrasps())) return nullptr;
  return task;
}

}  // namespace

const experiment::TaskKind& BringTask() {
  static const experiment::TaskKind kind{
      .name = "bring",
      .description =
          "A known object among others is found, grasped as its use requires and handed over to a "
          "person. Besides the keys below it has all keys of `task: grasping` except "
          "`trials_per_object`.",
      .trials_key = "runs_per_object",
      .uses_seed = true,
      .success = trial::kHandedOver,
      .read = Read,
      .read_keys = [](base::YamlMap& map) { ReadBringKeys(map); },
      .report = ReportOf,
      .summary = GraspOf};
  return kind;
}

experiment::Result ResultOf(const Bring& run, const std::string& wanted, bool present) {
  double simulated_s = run.moved_s;
  ordered_json attempts = ordered_json::array();
  std::vector<std::pair<std::string, double>> seconds = {{"look", run.look_s}};
  for (const Step& step : run.steps) {
    if (step.attempt.log) simulated_s += step.attempt.log->simulated_s;
    attempts.push_back(JsonOf(step));
    for (const auto& [stage, s] : step.attempt.seconds) {
      experiment::AddSeconds(stage, s, seconds);
    }
  }
  const ordered_json data = {{"wanted", wanted},
                             {"present", present},
                             {"said", base::Word(run.said)},
                             {"friction", OrNull(run.friction)},
                             {"words", run.words},
                             {"looks", run.looks},
                             {"cleared", run.cleared},
                             {"simulated_s", simulated_s},
                             {"homing_s", run.homing_s},
                             {"attempts", attempts}};
  if (run.steps.empty()) return {run.outcome, "look", run.detail, data.dump(), seconds};
  const trial::Attempt& last = run.steps.back().attempt;
  const bool as_last = run.detail.empty() && run.outcome == base::Word(last.outcome);
  return {run.outcome, last.stage, as_last ? last.detail : run.detail, data.dump(), seconds};
}

experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records) {
  std::vector<Row> rows;
  Row all{.title = "all"};
  for (const std::string& wanted : experiment::GroupsOf(records)) {
    rows.push_back({.title = experiment::TitleOf(stamp, wanted)});
    for (const auto& record : records) {
      if (record.which.group != wanted) continue;
      const auto data = ordered_json::parse(record.result.data, nullptr, false);
      Add(record, data, rows.back());
      Add(record, data, all);
    }
  }
  rows.push_back(all);
  experiment::Report report;
  report.csv = TableOf(rows);
  report.sections.push_back({"", report.csv});
  report.notes.push_back(
      "as wanted: handed over or, if the object is absent, reported absent. Upright: share of the "
      "upright objects that stayed within 30 deg. Kept free: share of the handed-over objects "
      "whose part for the person the hand left free");
  if (!all.robot_s.empty()) {
    report.notes.push_back(
        fmt::format("the arm moves for {:.0f} s per run (median); computing takes {:.1f} s per run "
                    "(median), in 95 % of the runs less than {:.1f} s",
                    base::MedianOf(all.robot_s), base::MedianOf(all.compute_s),
                    base::InterpolatedQuantileOf(all.compute_s, 0.95)));
  }
  return report;
}

}  // namespace rangegrasp::bring
