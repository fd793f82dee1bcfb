#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "base/words.h"
#include "cylinders/detect.h"
#include "cylinders/fit.h"
#include "cylinders/task/cylinders_task.h"
#include "cylinders/task/demo_detector.h"
#include "cylinders/task/tabletop_scan.h"
#include "experiment/statistics.h"
#include "sim/world.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::cylinders {
namespace {

using experiment::Case;
using experiment::Column;
using experiment::Result;
using nlohmann::ordered_json;

struct RecallOptions : TableOptions {
  Source source = Source::kScanned;
  int scenes = 200;
  int samples = 220;
};

/// Outcome of a scene.
constexpr const char* kScored = "scored";
/// Key of Stamp::data.
constexpr const char* kSource = "source";

// ---- synthetic scenes ----

struct Truth {
  std::size_t given = 0;
  Cylinder cylinder;
  bool seen = false;
};

/// A table: the objects on it, and its scan. Its cylinders include the given ones.
struct Table : samples::Tabletop {
  std::vector<Truth> given;
  geometry::Observation observation;
  std::optional<perception::Workspace> workspace;
};

/// Places objects on the table by the circumscribed circles of their outlines.
class Placing {
 public:
  explicit Placing(base::Rng& rng) : rng_(rng) {}

  /// In half of the draws the circle touches another one; nullopt if there is no room left.
  std::optional<Eigen::Vector2d> Place(double radius_m) {
    for (int draw = 0; draw < kDraws; ++draw) {
      const Eigen::Vector2d middle = Draw(radius_m);
      if (middle.cwiseAbs().maxCoeff() > kHalfTable_m) continue;
      const bool overlaps = std::ranges::any_of(circles_, [&](const Circle& other) {
        return (other.middle - middle).norm() < other.radius_m + radius_m;
      });
      if (overlaps) continue;
      circles_.push_back({middle, radius_m});
      return middle;
    }
    return std::nullopt;
  }

 private:
  struct Circle {
    Eigen::Vector2d middle;
    double radius_m;
  };
  static constexpr int kDraws = 200;
  static constexpr double kHalfTable_m = 0.14;  ///< visible part of the table
  static constexpr double kGap_m = 0.0005;      ///< between touching objects

  Eigen::Vector2d Draw(double radius_m) {
    if (!circles_.empty() && rng_.Uniform() < 0.5) {
      const Circle& other = circles_[rng_.Index(circles_.size())];
      const double angle = rng_.Uniform(0.0, 2.0 * base::kPi);
      const double apart_m = other.radius_m + radius_m + kGap_m;
      return other.middle + apart_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    const double x = rng_.Uniform(-kHalfTable_m, kHalfTable_m);
    const double y = rng_.Uniform(-kHalfTable_m, kHalfTable_m);
    return {x, y};
  }

  base::Rng& rng_;
  std::vector<Circle> circles_;
};

/// Adds a cylinder if there is room; returns whether there is.
bool AddCylinder(const GivenCylinder& shape, bool lies, double turn_rad, Placing& placing,
                 Table& table) {
  const auto [r, h] = shape;
  // Circle for a lying cylinder's outline: half its length plus some of its width.
  const auto at = placing.Place(lies ? 0.5 * h + 0.005 : r);
  if (!at) return false;
  table.cylinders.push_back(lies ? samples::Lying(at->x(), at->y(), turn_rad, r, h)
                                 : samples::Standing(at->x(), at->y(), r, h));
  return true;
}

void AddBox(base::Rng& rng, Placing& placing, Table& table) {
  const double a = rng.Uniform(0.03, 0.09);
  const double b = rng.Uniform(0.03, 0.09);
  const double height = rng.Uniform(0.03, 0.16);
  const double turn = rng.Uniform(0.0, base::kPi);
  const auto at = placing.Place(0.5 * std::hypot(a, b));
  if (!at) return;
  table.boxes.push_back(samples::StandingBox(at->x(), at->y(), turn, {a, b, height}));
}

void AddOther(bool lies, base::Rng& rng, Placing& placing, Table& table) {
  const double r = rng.Uniform(0.015, lies ? 0.035 : 0.045);
  const double h = lies ? rng.Uniform(0.06, 0.18) : rng.Uniform(0.04, 0.20);
  const double turn = lies ? rng.Uniform(0.0, base::kPi) : 0.0;
  AddCylinder({r, h}, lies, turn, placing, table);
}

Table DrawClutter(const std::vector<GivenCylinder>& given, base::Rng& rng) {
  Table table;
  Placing placing(rng);
  for (std::size_t g = 0; g < given.size(); ++g) {
    const bool lies = rng.Uniform() < 0.4;
    const double turn = rng.Uniform(0.0, base::kPi);
    if (!AddCylinder(given[g], lies, turn, placing, table)) continue;
    table.given.push_back({.given = g, .cylinder = table.cylinders.back()});
  }
  const std::size_t others = 3 + rng.Index(4);
  for (std::size_t i = 0; i < others; ++i) {
    const double kind = rng.Uniform();
    if (kind < 0.5) {
      AddBox(rng, placing, table);
    } else {
      AddOther(kind >= 0.8, rng, placing, table);
    }
  }
  return table;
}

/// True if at least a quarter of the rays to it, and more than 200, end on it.
bool IsSeen(std::size_t on, std::size_t all) {
  constexpr double kMinShare = 0.25;
  constexpr std::size_t kMinRays = 200;
  return static_cast<double>(on) >= kMinShare * static_cast<double>(all) && on > kMinRays;
}

ViewCounts RaysTo(const Cylinder& cylinder, const geometry::RangeImage& image) {
  constexpr double kTolerance_m = 0.003;
  const geometry::Points points = geometry::ToCloud(image).points;
  const geometry::Indices place_of(points.size(), 0);
  return CompareWithView({points, image.origins_C, place_of}, cylinder, kTolerance_m);
}

Table SyntheticTable(const RecallOptions& options, base::Rng& rng) {
  Table table = DrawClutter(options.given, rng);
  samples::Sensor sensor;
  if (options.source == Source::kPerfect) sensor.noise_m = 0.0;
  sensor.profiles = sensor.samples = options.samples;
  table.observation = samples::Scan(table, sensor, rng);
  for (Truth& truth : table.given) {
    const auto counts = RaysTo(truth.cylinder, table.observation.views.front().image);
    truth.seen = IsSeen(counts.on, counts.All());
  }
  return table;
}

// ---- scanned scenes ----

/// The cylinder of an object in the world; the object's origin is its center and z is its axis.
Cylinder CylinderOf(const sim::World& world, int object, const GivenCylinder& given) {
  const base::Pose X_WO = world.ObjectPose(object);
  return {X_WO.translation(), X_WO.linear().col(2), given.radius_m, given.height_m};
}

/// Labels tell which rays end on a given one, as the robot's calibration is off by millimetres.
Table ScannedTable(const RecallOptions& options, const trial::Cell& cell, const sim::World& world,
                   std::uint64_t seed) {
  const trial::Sensed sensed = trial::Look(cell, world, seed);
  Table table;
  table.observation = sensed.observation;
  table.workspace = trial::WorkspaceOf(cell.robot, options.grasping.workspace_margin_m);
  const sensing::ScanTruth& truth = sensed.truth.front();
  const geometry::RangeImage& image = table.observation.views.front().image;
  for (int object = 0; object < world.objects(); ++object) {
    const auto& names = options.grasping.objects;
    const auto name = std::ranges::find(names, world.object_name(object));
    if (name == names.end()) continue;
    const auto which = static_cast<std::size_t>(name - names.begin());
    const Cylinder cylinder = CylinderOf(world, object, options.given[which]);
    const auto label = static_cast<std::uint32_t>(object) + 1;  // sim::VisualMesh
    std::size_t on = 0;
    for (std::size_t i = 0; i < truth.label.size(); ++i) {
      on += truth.label[i] == label && image.points_C[i].allFinite();
    }
    table.given.push_back({which, cylinder, IsSeen(on, RaysTo(cylinder, image).All())});
    table.cylinders.push_back(cylinder);
  }
  return table;
}

// ---- verdicts ----

enum class Verdict {
  kFound,
  kMissed,
  kHidden,  ///< too little of it was seen; not counted, whether found or not
  kFalse,   ///< found where no such cylinder is
  kTwin,    ///< also false: found where another cylinder of the same size happens to be
};
constexpr std::array<std::string_view, 5> WordsOf(Verdict) {
  return {"found", "missed", "hidden", "false", "twin"};
}

/// Tolerances within which a found cylinder counts as the true one.
bool IsThere(const Cylinder& found, const Cylinder& truth) {
  constexpr double kMaxDistance_m = 0.02;
  const double max_angle_rad = base::Deg(10.0);
  return (found.center - truth.center).norm() < kMaxDistance_m &&
         AngleBetween(found.axis, truth.axis) < max_angle_rad;
}

/// True if its size cannot be distinguished from that of the given one (docs/cylinders.md).
bool IsTwin(const Cylinder& other, const GivenCylinder& given) {
  constexpr double kRadius_m = 0.0005;
  constexpr double kHeight_m = 0.002;
  return std::abs(other.radius_m - given.radius_m) < kRadius_m &&
         std::abs(other.height_m - given.height_m) < kHeight_m;
}

ordered_json Scored(Verdict verdict, std::size_t given, const Cylinder* truth,
                    const FoundCylinder* found) {
  ordered_json json = {{"verdict", base::Word(verdict)}, {"given", given + 1}};
  const auto add = [&](const char* name, const Cylinder& c) {
    json[name] = {{"center_m", {c.center.x(), c.center.y(), c.center.z()}},
                  {"axis", {c.axis.x(), c.axis.y(), c.axis.z()}},
                  {"radius_m", c.radius_m}};
  };
  if (truth) {
    add("truth", *truth);
    json["lies"] = std::abs(truth->axis.z()) < 0.5;
  }
  if (found) add("detected", found->cylinder_C);
  if (truth && found) {
    const Cylinder& c = found->cylinder_C;
    json["radius_error_m"] = std::abs(c.radius_m - truth->radius_m);
    json["axis_error_rad"] = AngleBetween(c.axis, truth->axis);
    json["position_error_m"] = (c.center - truth->center).norm();
  }
  return json;
}

ordered_json Score(const Table& table, const std::vector<GivenCylinder>& given,
                   const CylinderScene& scene) {
  ordered_json list = ordered_json::array();
  std::vector<bool> used(scene.cylinders.size(), false);
  for (const auto& [which, truth, seen] : table.given) {
    const FoundCylinder* match = nullptr;
    for (std::size_t i = 0; i < used.size() && !match; ++i) {
      const auto& found = scene.cylinders[i];
      if (used[i] || found.given != which || !IsThere(found.cylinder_C, truth)) continue;
      used[i] = true;
      match = &found;
    }
    const Verdict verdict = !seen ? Verdict::kHidden : match ? Verdict::kFound : Verdict::kMissed;
    list.push_back(Scored(verdict, which, &truth, match));
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i]) continue;
    const auto& found = scene.cylinders[i];
    const bool twin = std::ranges::any_of(table.cylinders, [&](const Cylinder& other) {
      return IsTwin(other, given[found.given]) && IsThere(found.cylinder_C, other);
    });
    list.push_back(Scored(twin ? Verdict::kTwin : Verdict::kFalse, found.given, nullptr, &found));
  }
  return list;
}

// ---- the task ----

/// A case is one random table.
class RecallExperiment : public experiment::Task {
 public:
  RecallExperiment(RecallOptions options, std::uint64_t seed)
      : options_(std::move(options)), seed_(seed) {
    if (options_.source == Source::kScanned) cell_.emplace(options_.grasping);
  }

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (int i = 0; i < options_.scenes; ++i) {
      cases.push_back({fmt::format("scene-{:04}", i),
                       "scene",
                       base::DeriveSeed(seed_, static_cast<std::uint64_t>(i)),
                       {{"scene", i}}});
    }
    return cases;
  }

  Result Run(const Case& which) const override {
    base::Rng rng(which.seed);
    if (!cell_) return Detected(SyntheticTable(options_, rng));
    const auto index = static_cast<std::size_t>(which.params.Int("scene"));
    const auto& objects = options_.grasping.objects;
    trial::Redraws redraws;
    const auto arranged = trial::ArrangeTrial(
        *cell_, {objects[index % objects.size()], static_cast<int>(index), which.seed}, redraws);
    if (!arranged) return trial::NoArrangement(redraws);
    return Detected(ScannedTable(options_, *cell_, arranged->world, which.seed));
  }

  void AddTo(experiment::Stamp& stamp) const override {
    if (cell_) trial::AddModelsTo(cell_->options, stamp);
    stamp.data[kSource] = base::Word(options_.source);
  }

 private:
  Result Detected(const Table& table) const {
    base::Rng draws(base::DeriveSeed(seed_, "d"));
    const auto scene = DetectCylinders(table.observation, options_.given, options_.detection, draws,
                                       table.workspace);
    const ordered_json data = {{"cylinders", Score(table, options_.given, scene)}};
    return {kScored, "detect", "", data.dump(), scene.seconds};
  }

  RecallOptions options_;
  std::uint64_t seed_;
  std::optional<trial::Cell> cell_;  ///< for scanned tables
};

RecallOptions ReadRecallKeys(base::YamlMap& map) {
  RecallOptions o;
  ReadGiven(map, o);
  map.Read(kSource, o.source,
           "scanned: simulated scans of tables as in `task: cylinder_demo`; noisy, perfect: "
           "synthetic rays to boxes and cylinders, with white noise or without noise");
  map.Read("scenes", o.scenes, 1, 1'000'000, "tables");
  map.Read("samples", o.samples, 20, 2000,
           "noisy, perfect: number of rays along each side of the image");
  return o;
}

std::unique_ptr<experiment::Task> ReadRecall(base::YamlMap& map, const experiment::Common& common) {
  RecallOptions options = ReadRecallKeys(map);
  ReadTable(map, "scenes", common.seed, options);
  if (!trial::ModelsPass(map, options.grasping, common)) return nullptr;
  if (options.source == Source::kScanned) CheckGiven(map, options);
  return std::make_unique<RecallExperiment>(std::move(options), common.seed);
}

// ---- tables ----

/// Detection counts of the given cylinders in one posture.
struct Posture {
  std::string name;
  int found = 0, missed = 0, hidden = 0;

  int Seen() const { return found + missed; }
};

struct Error {
  const char* name;
  const char* key;
  double unit;
  std::vector<double> values{};
};

struct Recall {
  std::array<Posture, 3> postures = {{{"standing"}, {"lying"}, {"all"}}};
  std::array<Error, 3> errors = {{{"radius [mm]", "radius_error_m", base::kMm},
                                  {"axis [deg]", "axis_error_rad", base::kDeg},
                                  {"position [mm]", "position_error_m", base::kMm}}};
  int wrong = 0, twins = 0, hits = 0, scenes = 0;

  /// Counts a scored cylinder.
  void Add(const ordered_json& one) {
    const auto verdict = base::FromWord<Verdict>(one.at("verdict").get<std::string>(), "verdict");
    hits += one.contains("radius_error_m");
    wrong += verdict == Verdict::kFalse || verdict == Verdict::kTwin;
    twins += verdict == Verdict::kTwin;
    for (Error& error : errors) {
      if (!one.contains(error.key)) continue;
      error.values.push_back(one.at(error.key).get<double>() / error.unit);
    }
    if (!one.contains("truth")) return;
    for (Posture* posture : {&postures[one.at("lies").get<bool>() ? 1 : 0], &postures[2]}) {
      posture->found += verdict == Verdict::kFound;
      posture->missed += verdict == Verdict::kMissed;
      posture->hidden += verdict == Verdict::kHidden;
    }
  }
};

experiment::Report RecallReport(const experiment::Stamp& stamp,
                                const std::vector<experiment::Record>& records) {
  Recall recall;
  for (const auto& record : records) {
    if (record.result.outcome != kScored) continue;
    ++recall.scenes;
    const auto data = ordered_json::parse(record.result.data);
    for (const auto& one : data.at("cylinders")) recall.Add(one);
  }
  const int detections = recall.hits + recall.wrong;
  const std::vector<Column<Posture>> columns = {
      {"given cylinders", "", &Posture::name, experiment::kLeft},
      {"seen", "", &Posture::Seen},
      {"detected", "", &Posture::found},
      {"recall %", "",
       [](const Posture& p) { return experiment::PercentText(p.found, p.Seen(), 2); }},
      {"95 %", "", [](const Posture& p) { return experiment::IntervalText(p.found, p.Seen()); }},
      {"hidden", "", &Posture::hidden}};
  const auto quantile = [](double share) {
    return [share](const Error& error) -> std::optional<double> {
      if (error.values.empty()) return std::nullopt;
      return base::QuantileOf(error.values, share);
    };
  };
  const std::vector<Column<Error>> error_columns = {{"error", "", &Error::name, experiment::kLeft},
                                                    {"median", ".3f", quantile(0.5)},
                                                    {"95 %", ".3f", quantile(0.95)},
                                                    {"largest", ".3f", quantile(1.0)}};
  experiment::Report report;
  const std::string source = experiment::ValueOr(stamp.data, kSource, "");
  const bool scanned = source == base::Word(Source::kScanned);
  report.sections = {{fmt::format("Recall on {}", scanned ? "scanned tables" : "synthetic rays"),
                      GridOf(columns, recall.postures)},
                     {"Errors of detected cylinders", GridOf(error_columns, recall.errors)}};
  report.csv = report.sections.front().grid;
  report.notes = {
      fmt::format("{}; precision {} % [{}]: {} of {} detections; of the {} false "
                  "ones {} are other cylinders of a given size",
                  base::Counted(recall.scenes, "table"),
                  experiment::PercentText(recall.hits, detections, 2),
                  experiment::IntervalText(recall.hits, detections), recall.hits, detections,
                  recall.wrong, recall.twins),
      "seen: at least a quarter of the rays towards the cylinder, and more than 200, hit it"};
  if (const auto lost = std::ssize(records) - recall.scenes; lost > 0) {
    report.notes.push_back(
        fmt::format("{} crashed or timed out and cannot be counted, so recall is too high",
                    base::Counted(lost, "more table")));
  }
  return report;
}

}  // namespace

const experiment::TaskKind& RecallTask() {
  static const experiment::TaskKind kind{
      .name = "cylinder_recall",
      .description =
          "Detection of given cylinders among other objects: recall, precision, errors. Besides "
          "the keys below it has all keys of `task: grasping` except `trials_per_object`; "
          "synthetic rays use few of them.",
      .trials_key = "scenes",
      .uses_seed = true,
      .success = {},
      .read = ReadRecall,
      .read_keys = [](base::YamlMap& map) { ReadRecallKeys(map); },
      .report = RecallReport};
  return kind;
}

}  // namespace rangegrasp::cylinders
