#include "parts/task/parts_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "parts/metrics/human_score.h"
#include "parts/task/parts_report.h"
#include "parts/task/parts_setup.h"
#include "parts/task/parts_view.h"
#include "parts/task/write_parts.h"

namespace rangegrasp::parts_task {
namespace {

using experiment::Case;
using experiment::Result;
using nlohmann::json;
using parts::Method;

/// Of the calling thread: a time that other threads and programs do not stretch.
double ProcessorSeconds() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Of the models' axes that which points up in a replay's picture: z.
constexpr int kAxisUp = 2;

double ToMicrosecond(double seconds) { return std::round(seconds * 1e6) / 1e6; }

/// A case while it runs.
struct Running {
  std::optional<parts::HumanModel> model;
  std::optional<parts::Segmentation> found;
};

class PartsExperiment : public experiment::Task {
 public:
  explicit PartsExperiment(PartsSetup setup) : setup_(std::move(setup)) {}

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (const ModelClass& one : setup_.classes) {
      for (const int id : one.tune) AddCases(one, id, Split::kTune, cases);
      for (const int id : one.report) AddCases(one, id, Split::kReport, cases);
    }
    return cases;
  }

  Result Run(const Case& which) const override {
    Running running;
    return RunCase(which, running);
  }

  Result Replay(const Case& which, const experiment::ReplayOptions& options) const override {
    if (!options.video.empty() || !options.camera.empty()) {
      throw base::InputError(
          "--video, --camera: an experiment with parts has nothing that moves; a replay leaves "
          "labels, a colored mesh and a picture");
    }
    Running running;
    Result result = RunCase(which, running);
    if (!running.model) return result;
    const parts::HumanModel& model = *running.model;
    std::vector<std::int32_t> labels;
    if (running.found) labels = parts::LabelsOfInput(model.shape, model.input.mesh, *running.found);
    if (options.view) {
      *options.view = PartsView(model, json::parse(which.params).at("method"), labels);
    } else if (running.found) {
      WriteParts(options.folder / which.id, model.input, labels, kAxisUp);
    }
    return result;
  }

  void AddTo(experiment::Stamp& stamp) const override { parts_task::AddTo(stamp, setup_); }

 private:
  void AddCases(const ModelClass& one, int id, Split split, std::vector<Case>& cases) const {
    for (const Method method : setup_.methods) {
      json params = {{"class", one.name},
                     {"model", id},
                     {"method", base::Word(method)},
                     {"split", base::Word(split)}};
      const std::string name = fmt::format("{}-{:04}-{}", one.name, id, base::Word(method));
      cases.push_back({name, one.name, /*seed=*/0, params.dump()});
      for (const CloudGrade& grade : setup_.clouds) {
        params["points"] = grade.points;
        params["noise_percent"] = grade.noise_percent;
        cases.push_back({fmt::format("{}-{}-{}", name, grade.points, grade.noise_percent), one.name,
                         /*seed=*/0, params.dump()});
      }
    }
  }

  /// What a method finds of a model, or of the cloud of it that the case names, and how long that
  /// took.
  parts::Segmentation Segment(const parts::Shape& mesh, const json& params, double& seconds) const {
    const auto method = base::FromWord<Method>(params.at("method").get<std::string>(), "method");
    const parts::MethodOptions options = OptionsOf(method, params.at("class"));
    const auto timed = [&](const parts::Shape& shape) {
      const double begin = ProcessorSeconds();
      parts::Segmentation found = parts::SegmentBy(method, shape, options);
      seconds = ToMicrosecond(ProcessorSeconds() - begin);
      return found;
    };
    if (!params.contains("points")) return timed(mesh);
    const CloudGrade grade{params.at("points"), params.at("noise_percent")};
    // The same points for every method.
    base::Rng rng(base::DeriveSeed(
        static_cast<std::uint64_t>(params.at("model").get<int>()),
        fmt::format("cloud of {} points, {} % noise", grade.points, grade.noise_percent)));
    const parts::Shape cloud = SampleCloud(mesh, grade, rng);
    return OfMesh(mesh, cloud, timed(cloud));
  }

  /// Figures are filled in all together or, of a method that fails, not at all.
  Result RunCase(const Case& which, Running& running) const {
    Result result;
    result.outcome = "failed";
    result.stage = "read";
    try {
      const json params = json::parse(which.params);
      const parts::HumanModel& model =
          running.model.emplace(parts::ReadHumanModel(setup_.folder, params.at("model")));
      result.stage = "method";
      double seconds = 0.0;
      const parts::Segmentation& found =
          running.found.emplace(Segment(model.shape, params, seconds));
      result.stage = "score";
      const parts::HumanScore score = parts::ScoreAgainstHumans(model, found);
      json data = {{"parts", found.parts}, {"rand_error", score.rand_error}};
      data["cut_discrepancy"] =
          score.cut_discrepancy ? json(*score.cut_discrepancy) : json(nullptr);
      result = {"scored", "score", found.note, data.dump(), {{"method", seconds}}};
    } catch (const std::exception& e) {
      result.detail = e.what();
    }
    // One line.
    std::replace_if(
        result.detail.begin(), result.detail.end(), [](char c) { return c == '\n' || c == '\r'; },
        ' ');
    return result;
  }

  /// As in the chapter's evaluation: k-means is told the class's mean number of segments, mirroring
  /// goes on where no centre inside is found.
  parts::MethodOptions OptionsOf(Method method, const std::string& class_name) const {
    parts::MethodOptions options;
    options.go_on_outside = true;
    for (const ModelClass& one : setup_.classes) {
      if (method == Method::kKMeans && one.name == class_name)
        options.clusters = one.human_segments;
    }
    return options;
  }

  PartsSetup setup_;
};

std::unique_ptr<experiment::Task> ReadParts(base::YamlMap& map, const experiment::Common&) {
  return std::make_unique<PartsExperiment>(ReadPartsSetup(map));
}

}  // namespace

const experiment::TaskKind& PartsTask() {
  static const experiment::TaskKind kind{
      .name = "parts",
      .description = "Methods that take objects apart against the segmentations of people.",
      .trials_key = "models_per_class",
      .uses_seed = false,
      .success = {},
      .read = ReadParts,
      .read_keys = ReadPartsKeys,
      .report = PartsReport,
      .has_views = true};
  return kind;
}

}  // namespace rangegrasp::parts_task
