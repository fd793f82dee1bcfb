#include "parts/task/parts_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <set>

#include "base/error.h"
#include "base/rng.h"
#include "base/words.h"
#include "experiment/view.h"
#include "geometry/mesh.h"
#include "parts/metrics/human_score.h"
#include "parts/shape/shape_file.h"
#include "parts/task/parts_report.h"
#include "parts/task/parts_setup.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;
using experiment::Case;
using experiment::Result;
using experiment::View;
using nlohmann::json;

// ---- views ----

geometry::TriangleMesh InUnitBox(geometry::TriangleMesh mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh.vertices) {
    if (IsUsable(p)) box.extend(p);
  }
  for (Eigen::Vector3d& p : mesh.vertices) {
    if (!IsUsable(p)) p = box.center();
    p = ((p - box.center()) / box.sizes().maxCoeff()).eval();
  }
  return mesh;
}

View::Painted PaintedBy(const geometry::TriangleMesh& mesh, const std::string& name,
                        const Labels& labels) {
  constexpr std::size_t kMaxColors = std::numeric_limits<std::uint8_t>::max() + 1;
  std::map<std::int32_t, std::size_t> position;
  View::Painted painted;
  painted.mesh_W = mesh;
  for (const std::int32_t label : labels) {
    const auto [place, is_new] = position.emplace(label, position.size());
    // More colors could not be distinguished; beyond this number they repeat.
    painted.paint.push_back(static_cast<std::uint8_t>(place->second % kMaxColors));
    if (!is_new || painted.colors.size() == kMaxColors) continue;
    painted.colors.push_back(PaintOf(label));
  }
  painted.layer = name + ": " + base::Counted(static_cast<std::int64_t>(position.size()), "part");
  return painted;
}

/// A model as segmented by a method, next to people's segmentations, in matching colors. The model
/// is moved and scaled into a box of 1 m.
/// @param name   of the method
/// @param found  labels of the input's faces; empty: the method found none
View PartsView(const HumanModel& model, const std::string& name, const Labels& found) {
  const geometry::TriangleMesh mesh = InUnitBox(model.input.mesh);
  View view;
  if (!found.empty()) view.painted.push_back(PaintedBy(mesh, name, found));
  for (std::size_t h = 0; h < model.humans.size(); ++h) {
    const Labels& human = model.humans[h];
    view.painted.push_back(PaintedBy(mesh, fmt::format("person {}", h + 1),
                                     found.empty() ? human : MatchedLabels(human, found)));
  }
  const draw::View look = LookAtShape(mesh.vertices);
  view.eye_W = look.eye;
  view.target_W = look.target;
  return view;
}

// ---- clouds of models ----

/// Points drawn uniformly from the surface, each with normally distributed noise.
/// @throws base::InputError as MakeShape.
Shape SampleCloud(const Shape& mesh, const CloudGrade& grade, base::Rng& rng) {
  const FaceFrames frames = BuildFaceFrames(mesh);
  std::vector<double> up_to(frames.area.size());
  std::partial_sum(frames.area.begin(), frames.area.end(), up_to.begin());
  const double deviation =
      0.01 * grade.noise_percent * geometry::BoundsOf(mesh.points).diagonal().norm();
  geometry::TriangleMesh cloud;
  for (int k = 0; k < grade.points; ++k) {
    const double area = rng.Uniform() * up_to.back();
    const auto face = std::upper_bound(up_to.begin(), up_to.end() - 1, area) - up_to.begin();
    const auto& [a, b, c] = mesh.faces[face];
    const double u = rng.Uniform();
    const double v = rng.Uniform();
    Vector3d p = geometry::TrianglePoint(mesh.points[a], mesh.points[b], mesh.points[c], u, v);
    for (double& x : p) x += deviation * rng.Normal();
    cloud.vertices.push_back(p);
  }
  return MakeShape(cloud);
}

// ---- cases ----

/// CPU time of the calling thread, which other threads and programs do not affect.
double ProcessorSeconds() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

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
    std::optional<HumanModel> model;
    std::optional<Segmentation> found;
    return RunCase(which, model, found);
  }

  Result Replay(const Case& which, const experiment::ReplayOptions& options) const override {
    if (!options.video.empty() || !options.camera.empty()) {
      throw base::InputError(
          "--video, --camera: in an experiment with parts nothing moves; a replay writes labels, a "
          "colored mesh and a picture");
    }
    std::optional<HumanModel> model;
    std::optional<Segmentation> found;
    Result result = RunCase(which, model, found);
    if (!model) return result;
    Labels labels;
    if (found) labels = LabelsOfInput(model->shape, model->input.mesh, *found);
    if (options.view) {
      *options.view = PartsView(*model, which.params.Text("method"), labels);
    } else if (found) {
      WriteParts(options.folder / which.id, model->input, labels);
    }
    return result;
  }

  void AddTo(experiment::Stamp& stamp) const override { parts::AddTo(stamp, setup_); }

 private:
  void AddCases(const ModelClass& one, int id, Split split, std::vector<Case>& cases) const {
    std::vector<std::optional<CloudGrade>> inputs = {std::nullopt};  // the mesh itself
    inputs.insert(inputs.end(), setup_.clouds.begin(), setup_.clouds.end());
    for (const Method method : setup_.methods) {
      const std::string word(base::Word(method));
      for (const auto& cloud : inputs) {
        Case& of = cases.emplace_back();
        of.id = fmt::format("{}-{:04}-{}", one.name, id, word);
        of.group = one.name;
        // Names in alphabetical order, as in stores written earlier.
        of.params = {{"class", one.name}, {"method", word}, {"model", id}};
        if (cloud) {
          of.id += fmt::format("-{}-{}", cloud->points, cloud->noise_percent);
          of.params.Add("noise_percent", cloud->noise_percent);
          of.params.Add("points", cloud->points);
        }
        of.params.Add("split", std::string(base::Word(split)));
      }
    }
  }

  /// Segments a model, or the cloud of it that the case names, and measures the time. For a cloud a
  /// face gets the label of the point nearest to its center.
  Segmentation Segment(const Shape& mesh, const experiment::Params& params, double& seconds) const {
    const auto method = base::FromWord<Method>(params.Text("method"), "method");
    const MethodOptions options = OptionsOf(method, params.Text("class"));
    const auto timed = [&](const Shape& shape) {
      const double begin = ProcessorSeconds();
      Segmentation found = SegmentBy(method, shape, options);
      seconds = std::round((ProcessorSeconds() - begin) * 1e6) / 1e6;  // to the microsecond
      return found;
    };
    if (!params.Has("points")) return timed(mesh);
    const CloudGrade grade{params.Int("points"), params.Number("noise_percent")};
    // All methods get the same points.
    base::Rng rng(base::DeriveSeed(
        static_cast<std::uint64_t>(params.Int("model")),
        fmt::format("cloud of {} points, {} % noise", grade.points, grade.noise_percent)));
    const Shape cloud = SampleCloud(mesh, grade, rng);
    Segmentation found = timed(cloud);
    found.label = LabelsOfNearest(BuildFaceFrames(mesh).center, cloud.points, found.label);
    return found;
  }

  /// Results are filled in completely or, if a method fails, not at all.
  Result RunCase(const Case& which, std::optional<HumanModel>& model,
                 std::optional<Segmentation>& found) const {
    Result result;
    result.outcome = experiment::kCrashed;  // unreadable input fails the run
    result.stage = "read";
    try {
      model = ReadHumanModel(setup_.folder, which.params.Int("model"));
      result.outcome = "failed";
      result.stage = "method";
      double seconds = 0.0;
      found = Segment(model->shape, which.params, seconds);
      result.stage = "score";
      const HumanScore score = ScoreAgainstHumans(*model, *found);
      json data = {{"parts", found->parts}, {"rand_error", score.rand_error}};
      data["cut_discrepancy"] =
          score.cut_discrepancy ? json(*score.cut_discrepancy) : json(nullptr);
      result = {"scored", "score", found->note, data.dump(), {{"method", seconds}}};
    } catch (const std::exception& e) {
      result.detail = e.what();
    }
    // Keeps the text on one line.
    std::ranges::replace_if(
        result.detail, [](char c) { return c == '\n' || c == '\r'; }, ' ');
    return result;
  }

  /// As in the chapter's evaluation: k-means gets the class's mean number of segments, and
  /// mirroring continues if no center inside is found.
  MethodOptions OptionsOf(Method method, const std::string& class_name) const {
    MethodOptions options;
    options.go_on_outside = true;
    for (const ModelClass& one : setup_.classes) {
      if (method != Method::kKMeans || one.name != class_name) continue;
      options.clusters = one.human_segments;
    }
    return options;
  }

  PartsSetup setup_;
};

}  // namespace

Labels MatchedLabels(const Labels& labels, const Labels& reference) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> shares;
  for (std::size_t i = 0; i < labels.size(); ++i) ++shares[{labels[i], reference[i]}];
  std::vector<std::tuple<int, std::int32_t, std::int32_t>> order;
  for (const auto& [pair, faces] : shares) order.emplace_back(-faces, pair.first, pair.second);
  std::sort(order.begin(), order.end());
  std::map<std::int32_t, std::int32_t> matched;
  std::set<std::int32_t> taken;
  std::int32_t next = reference.empty() ? 0 : *std::ranges::max_element(reference) + 1;
  for (const auto& [faces, label, other] : order) {
    if (!matched.contains(label) && taken.insert(other).second) matched[label] = other;
  }
  Labels result;
  for (const std::int32_t label : labels) {
    const auto [place, is_new] = matched.emplace(label, next);
    next += is_new ? 1 : 0;
    result.push_back(place->second);
  }
  return result;
}

const experiment::TaskKind& PartsTask() {
  static const experiment::TaskKind kind{
      .name = "parts",
      .description = "Segmentation of objects into parts, compared with segmentations by people.",
      .trials_key = "models_per_class",
      .uses_seed = false,
      .success = {},
      .read = [](base::YamlMap& map,
                 const experiment::Common&) -> std::unique_ptr<experiment::Task> {
        return std::make_unique<PartsExperiment>(ReadPartsSetup(map));
      },
      .read_keys = ReadPartsKeys,
      .report = PartsReport,
      .has_views = true};
  return kind;
}

}  // namespace rangegrasp::parts
