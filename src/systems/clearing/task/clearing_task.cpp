#include "clearing/task/clearing_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <ranges>
#include <utility>

#include "base/statistics.h"
#include "base/stopwatch.h"
#include "base/words.h"
#include "experiment/experiment.h"
#include "experiment/statistics.h"
#include "trial/options.h"
#include "trial/recorder.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::clearing {
namespace {

using Counts = std::map<std::string, int>;
using experiment::Case;
using experiment::Column;
using experiment::Fixed;
using experiment::Grid;
using experiment::Record;
using experiment::ReplayOptions;
using experiment::Result;
using experiment::Stamp;
using nlohmann::ordered_json;

ordered_json JsonOf(const Clearing& clearing, const Step& step) {
  const auto name = [&](int object) {
    return clearing.objects[static_cast<std::size_t>(object)].object;
  };
  ordered_json taken = ordered_json::array();
  for (const int object : step.taken_away) taken.push_back(name(object));
  ordered_json json = {
      {"scan", step.scan},
      {"object", step.attempt.target ? ordered_json(name(*step.attempt.target)) : nullptr},
      {"held", step.attempt.log ? ordered_json(name(step.attempt.log->target)) : nullptr},
      {"try", step.try_number},
      {"outcome", base::Word(step.attempt.outcome)},
      {"stage", step.attempt.stage},
      {"detail", step.attempt.detail},
      {"felt", step.felt},
      {"taken_away", taken}};
  json.update(trial::JsonOf(step.attempt));
  return json;
}

struct OfObject {
  std::string name;
  int runs = 0, delivered = 0, grasps = 0;
  Counts why;
};

// All runs of one arrangement.
struct Category {
  std::string name;
  int runs = 0, failed = 0;  // failed: crashed or timed out, without a record
  int objects = 0, delivered = 0, brought = 0, grasps = 0, scans = 0;
  int felt_wrong = 0;  // grasps for which the hand's aperture and the target's delivery disagree
  std::vector<experiment::Count> clusters;
  std::vector<double> robot_s;  // of each run: simulated time and motions home
  std::map<std::string, OfObject> by_object;
  Counts outcomes, grasp_outcomes;
};

void AddEnd(const nlohmann::json& end, Category& category) {
  const std::string name = end.at("object");
  const std::string fate = end.at("fate");
  OfObject& object = category.by_object[name];
  object.name = name;
  ++object.runs;
  object.grasps += end.at("grasps").get<int>();
  if (fate == base::Word(Fate::kDelivered)) {
    ++object.delivered;
    return;
  }
  ++object.why[fate + ": " + end.at("why").get<std::string>()];
}

// Adds a record. A run without data (crashed, timed out) counts as one that delivered no object.
void Add(const Record& record, Category& category) {
  ++category.runs;
  ++category.outcomes[record.result.outcome];
  const auto data = nlohmann::json::parse(record.result.data, nullptr, false);
  const auto number = [&](const char* name) { return data.at(name).get<int>(); };
  if (!data.is_object() || !data.contains("per_object")) {
    ++category.failed;
    if (!record.which.params.Has("objects")) return;
    const int objects = record.which.params.Int("objects");
    category.objects += objects;
    if (objects > 0) category.clusters.push_back({0, objects});
    return;
  }
  category.objects += number("objects");
  category.delivered += number("delivered");
  category.brought += number("brought");
  category.grasps += number("grasps");
  category.scans += number("scans");
  category.clusters.push_back({number("delivered"), number("objects")});
  category.robot_s.push_back(data.at("simulated_s").get<double>() +
                             data.at("homing_s").get<double>());
  for (const auto& end : data.at("per_object")) AddEnd(end, category);
  for (const auto& attempt : data.at("attempts")) {
    if (attempt.at("log").empty()) continue;
    const std::string outcome = attempt.at("outcome");
    ++category.grasp_outcomes[outcome];
    category.felt_wrong += attempt.at("felt").get<bool>() != (outcome == "delivered") ? 1 : 0;
  }
}

// The categories in the order of first occurrence.
std::vector<Category> CategoriesOf(const std::vector<Record>& records) {
  std::vector<Category> categories;
  for (const std::string& group : GroupsOf(records)) {
    categories.emplace_back().name = group;
    for (const Record& record : records) {
      if (record.which.group == group) Add(record, categories.back());
    }
  }
  return categories;
}

std::string Percent(int k, int n) { return experiment::PercentText(k, n, 2); }
std::string Ratio(int k, int n) { return n == 0 ? "-" : Fixed(static_cast<double>(k) / n, 2); }

std::string IntervalOf(const Category& category) {
  if (category.objects == 0) return "-";
  const auto [low, high] = experiment::ClusteredInterval(category.clusters);
  return fmt::format("{}-{}", Fixed(100.0 * low, 1), Fixed(100.0 * high, 1));
}

Grid MainGrid(const std::vector<Category>& categories) {
  const std::vector<Column<Category>> columns = {
      {"arrangement", "", &Category::name, experiment::kLeft},
      {"runs", "", &Category::runs},
      {"objects", "", &Category::objects},
      {"delivered", "", &Category::delivered},
      {"delivered %", "", [](const Category& c) { return Percent(c.delivered, c.objects); }},
      {"95 %", "", IntervalOf},
      {"grasps", "", &Category::grasps},
      {"grasps / delivered", "", [](const Category& c) { return Ratio(c.grasps, c.delivered); }},
      {"scans / run", "", [](const Category& c) { return Ratio(c.scans, c.runs - c.failed); }},
      {"ends", "", [](const Category& c) { return experiment::CountsText(c.outcomes); },
       experiment::kLeft}};
  return experiment::GridOf(columns, categories);
}

Grid ObjectGrid(const Stamp& stamp, const Category& category) {
  const std::vector<Column<OfObject>> columns = {
      {"object", "", [&](const OfObject& o) { return experiment::TitleOf(stamp, o.name); },
       experiment::kLeft},
      {"runs", "", &OfObject::runs},
      {"delivered", "", &OfObject::delivered},
      {"delivered %", "", [](const OfObject& o) { return Percent(o.delivered, o.runs); }},
      {"95 %", "", [](const OfObject& o) { return experiment::IntervalText(o.delivered, o.runs); }},
      {"grasps / run", "", [](const OfObject& o) { return Ratio(o.grasps, o.runs); }},
      {"otherwise", "", [](const OfObject& o) { return experiment::CountsText(o.why); },
       experiment::kLeft}};
  return experiment::GridOf(columns, std::views::values(category.by_object));
}

std::string RobotLine(const Category& c) {
  if (c.robot_s.empty()) return c.name + ": no run has a record";
  return fmt::format(
      "{}: the arm moves for {:.0f} s per run (median), {:.1f} s per grasp; the hand's sensors "
      "were wrong in {} of {} grasps; objects delivered in another way: {}",
      c.name, base::MedianOf(c.robot_s),
      std::accumulate(c.robot_s.begin(), c.robot_s.end(), 0.0) / std::max(1, c.grasps),
      c.felt_wrong, c.grasps, c.brought);
}

Grid GraspGrid(const std::vector<Category>& categories) {
  Grid grid;
  grid.header = {"arrangement", "outcome", "count"};
  grid.left = {true, true, false};
  for (const Category& c : categories) {
    for (const auto& [word, count] : c.grasp_outcomes) {
      grid.rows.push_back({c.name, word, fmt::format("{}", count)});
    }
  }
  return grid;
}

// Reads the keys that it does not share with grasping.
ClearingOptions ReadClearingKeys(base::YamlMap& map) {
  ClearingOptions o;
  map.Read("runs", o.runs, 1, 100000, "number of arrangements to clear");
  auto keys = map.Child("clearing", "rules from one grasp to the next");
  keys.Read("tries_per_object", o.tries_per_object, 1, 20,
            "number of failed grasps of an object before it is skipped");
  keys.Read("max_grasps", o.max_grasps, 0, 10000,
            "maximum number of grasps of a run; 0: tries_per_object for each object");
  keys.Finish();
  return o;
}

// Each case is an arrangement. Its group is the arrangement's word.
class ClearingExperiment : public trial::SceneTask {
 public:
  ClearingExperiment(trial::Options grasping, const ClearingOptions& options, std::uint64_t seed)
      : cell_(std::move(grasping)), options_(options), seed_(seed) {}

  // The objects take turns at being the target, which is dropped last and is the highest. If a run
  // leaves no record, all "objects" count as not delivered: an upper bound if their number is
  // drawn.
  std::vector<Case> Cases() const override {
    const auto& objects = cell_.options.objects;
    const std::string group = cell_.options.arranger;
    std::vector<Case> cases;
    for (int i = 0; i < options_.runs; ++i) {
      const std::string& target = objects[static_cast<std::size_t>(i) % objects.size()];
      cases.push_back(
          {fmt::format("{}-{:04}", group, i),
           group,
           base::DeriveSeed(base::DeriveSeed(base::DeriveSeed(seed_, "clearing"), group),
                            static_cast<std::uint64_t>(i)),
           {{"object", target}, {"index", i}, {"objects", cell_.arranger->MaxObjects()}}});
    }
    return cases;
  }

  void Hide(const std::filesystem::path& folder) override { cell_.Hide(folder); }

  Result Run(const Case& which) const override {
    trial::Recorder none(cell_);
    return RunCase(which, none);
  }

  // With snapshots, attempt 3 of case pile-0001 gives `pile-0001_03_perceived.png`,
  // `_03_start.png` and `_03_lifted.png`. The run gives `pile-0001_end.png` and
  // `pile-0001_sheet.png`, which shows all pictures.
  Result Replay(const Case& which, const ReplayOptions& options) const override {
    const auto recorder = trial::MakeRecorder(cell_, which.id, options);
    // Skips the end of a grasp: it looks like the start of the next one, except that the objects
    // at the delivery place are removed by then.
    recorder->KeepMoments({"start", "lifted"});
    const Result result = RunCase(which, *recorder);
    recorder->Finish();
    return result;
  }

  void AddTo(Stamp& stamp) const override {
    trial::AddModelsTo(cell_.options, stamp);
    trial::FindDetector(cell_.options.detector)->add_to(cell_.options, stamp);
    trial::AddTitles(cell_.options, stamp);
  }

  const trial::Cell& cell() const override { return cell_; }

 private:
  Result RunCase(const Case& which, trial::Recorder& recorder) const {
    const trial::TrialSpec spec = trial::SpecOf(which);
    base::Stopwatch watch;
    trial::Redraws redraws;
    auto arranged = Arrange(which, redraws);
    if (!arranged) return trial::NoArrangement(redraws);
    const double arrange_s = watch.Restart();
    const Clearing clearing = ClearTable(cell_, options_, arranged->world, which.seed, recorder);
    Result result = ResultOf(clearing, spec.object);
    result.seconds.insert(result.seconds.begin(), {"arrange", arrange_s});
    result.seconds.emplace_back("clearing", watch.Seconds());
    return result;
  }

  trial::Cell cell_;
  ClearingOptions options_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  if (map.Has("trials_per_object")) {
    map.Fail("trials_per_object", "use `runs` in a clearing experiment");
  }
  if (map.Has("views")) {
    map.Fail(
        "views",
        "cannot be used here: clearing takes one scan per grasp, with the experiment's sensor");
  }
  const ClearingOptions options = ReadClearingKeys(map);
  trial::Options grasping = trial::ReadOptions(map, common.seed);
  if (!trial::ModelsPass(map, grasping, common)) return nullptr;
  trial::FindDetector(grasping.detector)->check(map, grasping, common.case_limit_s);
  return std::make_unique<ClearingExperiment>(std::move(grasping), options, common.seed);
}

}  // namespace

experiment::Result ResultOf(const Clearing& clearing, const std::string& target) {
  double simulated_s = 0.0;
  ordered_json attempts = ordered_json::array();
  std::vector<std::pair<std::string, double>> seconds = {{"scan", clearing.scan_s}};
  for (const Step& step : clearing.steps) {
    if (step.attempt.log) simulated_s += step.attempt.log->simulated_s;
    attempts.push_back(JsonOf(clearing, step));
    for (const auto& [stage, s] : step.attempt.seconds) experiment::AddSeconds(stage, s, seconds);
  }
  ordered_json per_object = ordered_json::array();
  for (const ObjectEnd& end : clearing.objects) {
    per_object.push_back({{"object", end.object},
                          {"fate", base::Word(end.fate)},
                          {"grasps", end.grasps},
                          {"why", end.why}});
  }
  const ordered_json data = {{"target", target},
                             {"objects", clearing.objects.size()},
                             {"delivered", clearing.Count(Fate::kDelivered)},
                             {"brought", clearing.Count(Fate::kBrought)},
                             {"left", clearing.Count(Fate::kLeft)},
                             {"grasps", clearing.Grasps()},
                             {"scans", clearing.scans},
                             {"perceived", clearing.perceived},
                             {"stop", base::Word(clearing.stop)},
                             {"simulated_s", simulated_s},
                             {"homing_s", clearing.homing_s},
                             {"per_object", per_object},
                             {"attempts", attempts}};
  const bool cleared =
      clearing.Count(Fate::kDelivered) == static_cast<int>(clearing.objects.size());
  return {cleared ? kCleared : std::string(base::Word(clearing.stop)), "clear", clearing.detail,
          data.dump(), seconds};
}

experiment::Report ReportOf(const Stamp& stamp, const std::vector<Record>& records) {
  const auto categories = CategoriesOf(records);
  experiment::Report report;
  report.sections.push_back({"", MainGrid(categories)});
  for (const Category& c : categories) {
    report.sections.push_back({c.name + ", by object", ObjectGrid(stamp, c)});
  }
  report.sections.push_back({"Grasps", GraspGrid(categories)});
  for (const Category& c : categories) report.notes.push_back(RobotLine(c));
  report.csv = MainGrid(categories);
  return report;
}

}  // namespace rangegrasp::clearing

namespace rangegrasp {

void RegisterClearing() {
  experiment::AddKind(
      {.name = "clearing",
       .description = "Tables are cleared object by object: one case per arrangement. Besides the "
                      "keys below it has all keys of `task: grasping` except `trials_per_object`.",
       .trials_key = "runs",
       .uses_seed = true,
       .success = clearing::kCleared,
       .read = clearing::Read,
       .read_keys = [](base::YamlMap& map) { clearing::ReadClearingKeys(map); },
       .report = clearing::ReportOf});
}

}  // namespace rangegrasp
