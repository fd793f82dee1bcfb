#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "cli/commands.h"
#include "cli/output.h"
#include "core/error.h"
#include "core/stopwatch.h"
#include "draw/plot.h"
#include "draw/shape_picture.h"
#include "parts/baselines.h"
#include "parts/benchmark.h"
#include "parts/embedding.h"
#include "parts/files.h"
#include "parts/improved.h"
#include "parts/mirror.h"
#include "report/parts_table.h"
#include "sim/render.h"

namespace rangegrasp::cli {
namespace {

using nlohmann::ordered_json;
using parts::Method;
using parts::Segmentation;

// ---- parts FILE ----

struct SegmentArguments {
  std::string file, out = "results/parts", method = "mirror", up = "z";
  std::optional<int> clusters;
  bool pose_invariant = false, go_on_outside = false, json = false;
};

Method MethodFrom(const std::string& name) {
  for (const Method method : parts::kMethods) {
    if (name == parts::Name(method)) return method;
  }
  throw core::InputError("--method '" + name + "' is no method");
}

// An option that the method would not look at is a mistake of the caller.
void CheckOptions(const SegmentArguments& arguments) {
  const auto refuse = [&](const std::string& option, const std::string& methods) {
    throw core::InputError(option + ": method '" + arguments.method + "' has no use for it; " +
                           methods);
  };
  const Method method = MethodFrom(arguments.method);
  if (arguments.clusters && method != Method::kKMeans && method != Method::kSdf) {
    refuse("--parts", "it is for --method kmeans and sdf, the others find the number themselves");
  }
  if (arguments.pose_invariant && method != Method::kMirror) {
    refuse("--pose-invariant", "it is for --method mirror");
  }
  if (arguments.go_on_outside && method != Method::kMirror) {
    refuse("--go-on-outside", "it is for --method mirror");
  }
}

Segmentation Mirrored(const parts::Shape& shape, const SegmentArguments& arguments) {
  parts::MirrorOptions mirror;
  mirror.go_on_outside = arguments.go_on_outside;
  if (!arguments.pose_invariant) return parts::SegmentByMirroring(shape, mirror);
  parts::PoseInvariantOptions options;
  options.mirror = mirror;
  return parts::SegmentPoseInvariant(shape, options);
}

Segmentation SegmentAsAsked(const parts::Shape& shape, const SegmentArguments& arguments) {
  switch (MethodFrom(arguments.method)) {
    case Method::kMirror:
      return Mirrored(shape, arguments);
    case Method::kImproved:
      return parts::SegmentImproved(shape, {});
    case Method::kKMeans: {
      parts::KMeansOptions options;
      options.clusters = arguments.clusters.value_or(options.clusters);
      return parts::SegmentByKMeans(shape, options);
    }
    case Method::kSdf: {
      parts::SdfOptions options;
      options.clusters = arguments.clusters.value_or(options.clusters);
      return parts::SegmentBySdf(shape, options);
    }
    case Method::kCore:
      break;
  }
  return parts::SegmentByCoreExtraction(shape, {});
}

// A shape with what was found of it.
struct Segmented {
  geometry::TriangleMesh input;
  Segmentation found;
  std::vector<std::int32_t> labels;  // of the input
  double seconds = 0.0;
};

Segmented Segment(const SegmentArguments& arguments) {
  Segmented result;
  result.input = parts::ReadInput(arguments.file);
  try {
    const parts::Shape shape = parts::MakeShape(result.input);
    if (!shape.IsMesh() && arguments.method != parts::Name(Method::kMirror)) {
      throw core::InputError("is a point cloud; method '" + arguments.method +
                             "' needs a mesh, --method mirror takes clouds too");
    }
    const core::Stopwatch watch;
    result.found = SegmentAsAsked(shape, arguments);
    result.seconds = watch.Seconds();
    result.labels = parts::LabelsOfInput(shape, result.input, result.found);
  } catch (const core::InputError& e) {
    throw core::InputError(arguments.file + ": " + e.what());
  }
  return result;
}

std::string HexOf(const std::array<std::uint8_t, 3>& color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color[0], color[1], color[2]);
}

ordered_json JsonOf(const SegmentArguments& arguments, const Segmented& result) {
  const auto& found = result.found;
  const bool mesh = !result.input.triangles.empty();
  ordered_json json = {{"file", arguments.file},
                       {"method", arguments.method},
                       {"vertices", result.input.vertices.size()},
                       {"faces", result.input.triangles.size()},
                       {"element", mesh ? "face" : "point"},
                       {"elements", 0},
                       {"parts", ordered_json::array()},
                       {"note", found.note},
                       {"seconds", result.seconds}};
  std::vector<std::size_t> sizes(static_cast<std::size_t>(found.parts), 0);
  std::size_t elements = 0;  // that have a place, and so a part
  for (const std::int32_t label : result.labels) {
    if (label < 0) continue;
    ++sizes[static_cast<std::size_t>(label)];
    ++elements;
  }
  json["elements"] = elements;
  for (int part = 0; part < found.parts; ++part) {
    const std::size_t size = sizes[static_cast<std::size_t>(part)];
    json["parts"].push_back({{"label", part},
                             {"core", found.has_core && part == 0},
                             {"elements", size},
                             {"share", static_cast<double>(size) / static_cast<double>(elements)},
                             {"color", HexOf(parts::PartColor(part))}});
  }
  return json;
}

std::string TextOf(const ordered_json& json) {
  std::string text =
      fmt::format("{} parts of {} {}s\n", json["parts"].size(), json["elements"].get<std::size_t>(),
                  json["element"].get<std::string>());
  for (const auto& part : json["parts"]) {
    text += fmt::format("part {}: {} {}s, {:.1f} %, {}{}\n", part["label"].get<int>(),
                        part["elements"].get<std::size_t>(), json["element"].get<std::string>(),
                        100.0 * part["share"].get<double>(), part["color"].get<std::string>(),
                        part["core"].get<bool>() ? ", the core" : "");
  }
  return text;
}

void SegmentFile(const SegmentArguments& arguments) {
  if (arguments.file.empty()) {
    throw core::InputError(
        "parts: a FILE (.off, .obj, .stl, .ply, .pcd) or 'evaluate' must follow");
  }
  CheckOptions(arguments);
  const Segmented result = Segment(arguments);
  const auto base = std::filesystem::path(arguments.out) /
                    std::filesystem::path(arguments.file).filename().stem();
  const auto named = [&](const char* ending) { return base.string() + ending; };
  MakeFolderOf(base);
  parts::WriteLabels(named(".seg"), result.labels);
  parts::WriteColoredShape(named(".ply"), result.input, result.labels);
  const int up = arguments.up[0] - 'x';
  sim::WritePng(named(".png"),
                draw::Render(draw::DrawLabels(result.input, result.labels, parts::PartColor),
                             draw::LookAtShape(result.input.vertices, up), 960, 720));
  const ordered_json json = JsonOf(arguments, result);
  if (!result.found.note.empty()) spdlog::info("{}", result.found.note);
  WriteResult(arguments.json ? json.dump(2) + "\n" : TextOf(json));
  spdlog::info("labels, coloured shape and picture in {}.seg, .ply, .png", base.string());
}

// ---- parts evaluate EXPERIMENT.yaml ----

struct EvaluateArguments {
  std::string experiment, data, out, format = "text";
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  bool resume = false, json = false;
};

// Figures 6.19 to 6.22: a metric by class and over all.
void WriteFigures(const parts::BenchmarkOptions& options,
                  const std::vector<parts::BenchmarkRow>& rows, report::PartsMetric metric,
                  std::optional<parts::Split> split, const std::filesystem::path& folder) {
  const report::PartsMeans means = report::MeansOf(options, rows, metric, split);
  const bool rand = metric == report::PartsMetric::kRandError;
  const std::string name =
      std::string(rand ? "rand_index" : "cut_discrepancy") + (split ? "" : "_all_models");
  WriteResult(report::PartsMeansCsv(means, metric), folder / (name + ".csv"));
  draw::BarChart classes{rand ? "1 - Rand index by class" : "Cut discrepancy by class",
                         "lower is better",
                         means.classes,
                         {},
                         {}};
  draw::BarChart overall{
      rand ? "1 - Rand index, mean of the classes" : "Cut discrepancy, mean of the classes",
      "lower is better",
      {},
      {""},
      {{}}};
  const auto number = [](const std::optional<double>& value) {
    return value.value_or(std::numeric_limits<double>::quiet_NaN());
  };
  for (std::size_t m = 0; m < means.methods.size(); ++m) {
    classes.series.emplace_back(parts::Name(means.methods[m]));
    auto& bars = classes.values.emplace_back();
    for (const auto& value : means.by_class[m]) bars.push_back(number(value));
    overall.groups.emplace_back(parts::Name(means.methods[m]));
    overall.values[0].push_back(number(means.overall[m]));
  }
  WriteResult(draw::PlotSvg(classes, 1100), folder / (name + "_by_class.svg"));
  WriteResult(draw::PlotSvg(overall, 600), folder / (name + "_overall.svg"));
}

bool HasReportModels(const parts::BenchmarkOptions& options) {
  return std::any_of(options.classes.begin(), options.classes.end(),
                     [](const auto& one) { return !one.report.empty(); });
}

// What a run that was stopped left, whole lines only; nothing for a new run.
std::vector<parts::BenchmarkRow> RowsBefore(const std::filesystem::path& csv, bool resume) {
  std::vector<parts::BenchmarkRow> rows;
  if (resume) rows = parts::ReadRows(csv);
  std::erase_if(rows, [](const parts::BenchmarkRow& row) { return row.failed; });
  parts::WriteRows(csv, rows);
  return rows;
}

void Evaluate(const EvaluateArguments& arguments) {
  const auto options = parts::ReadBenchmark(arguments.experiment, arguments.data);
  const auto folder = arguments.out.empty() ? std::filesystem::path("results") / options.name
                                            : std::filesystem::path(arguments.out);
  // A broken published table, or a folder that cannot be made, shows before the work.
  report::FormatParts(options, {}, report::TableFormat::kText);
  const auto csv = folder / "rows.csv";
  MakeFolderOf(csv);
  const auto before = RowsBefore(csv, arguments.resume);
  std::size_t total = 0;
  for (const auto& one : options.classes) total += one.tune.size() + one.report.size();
  total *= options.methods.size();
  std::size_t now = std::min(before.size(), total);
  const auto rows =
      parts::RunBenchmark(options, arguments.jobs, before, [&](const parts::BenchmarkRow& row) {
        parts::AppendRow(csv, row);
        ++now;
        if (isatty(STDERR_FILENO)) {
          std::fprintf(stderr, "\r%zu/%zu\033[K%s", now, total, now == total ? "\n" : "");
        }
        if (row.failed) {
          spdlog::warn("{} {}, {}: {}", row.class_name, row.id, parts::Name(row.method), row.note);
        }
      });
  parts::WriteRows(csv, rows);
  for (const auto metric :
       {report::PartsMetric::kRandError, report::PartsMetric::kCutDiscrepancy}) {
    if (HasReportModels(options)) {
      WriteFigures(options, rows, metric, parts::Split::kReport, folder);
    }
    WriteFigures(options, rows, metric, std::nullopt, folder);
  }
  const auto format =
      arguments.json ? report::TableFormat::kJson : ParseTableFormat(arguments.format);
  WriteResult(report::FormatParts(options, rows, report::TableFormat::kJson),
              folder / "tables.json");
  WriteResult(report::FormatParts(options, rows, format));
}

void AddEvaluate(CLI::App& command) {
  auto* evaluate = command.add_subcommand(
      "evaluate", "Methods against human segmentations: both metrics, times, figures 6.19-6.22.");
  auto arguments = std::make_shared<EvaluateArguments>();
  evaluate->add_option("experiment", arguments->experiment, "parts experiment file")->required();
  evaluate->add_option("--data", arguments->data,
                       "folder of off/ and seg/, instead of the experiment's");
  evaluate->add_option("-o,--out", arguments->out, "folder (results/<name>)");
  evaluate->add_option("--jobs", arguments->jobs)->check(CLI::Range(1, 1024));
  evaluate->add_flag("--resume", arguments->resume, "go on with a run that was stopped");
  evaluate->add_option("--format", arguments->format)
      ->check(CLI::IsMember({"text", "markdown", "csv", "json"}));
  evaluate->add_flag("--json", arguments->json);
  evaluate->footer("Example: rangegrasp parts evaluate experiments/parts_psb.yaml --data psb");
  evaluate->callback([arguments] { Evaluate(*arguments); });
}

}  // namespace

void AddPartsCommands(CLI::App& app) {
  auto* command = app.add_subcommand("parts", "Cuts a mesh or a point cloud into its parts.");
  auto arguments = std::make_shared<SegmentArguments>();
  command->add_option("file", arguments->file, "OFF, OBJ, STL, PLY or PCD");
  std::vector<std::string> methods;
  for (const Method method : parts::kMethods) methods.emplace_back(parts::Name(method));
  command->add_option("--method", arguments->method, "all but mirror need a mesh (mirror)")
      ->check(CLI::IsMember(methods));
  command->add_option("--parts", arguments->clusters, "clusters of kmeans and sdf (5)")
      ->check(CLI::Range(1, 1000));
  command->add_flag("--pose-invariant", arguments->pose_invariant,
                    "mirror: of the shape with its limbs stretched out");
  command->add_flag("--go-on-outside", arguments->go_on_outside,
                    "mirror: also where no centre inside of the shape is found");
  command->add_option("--up", arguments->up, "axis that points up in the picture (z)")
      ->check(CLI::IsMember({"x", "y", "z"}));
  command->add_option("-o,--out", arguments->out, "folder (results/parts)");
  command->add_flag("--json", arguments->json);
  command->footer("Example: rangegrasp parts cup.off --method improved -o results/cup");
  command->require_subcommand(0, 1);
  AddEvaluate(*command);
  command->callback([command, arguments] {
    if (command->get_subcommands().empty()) SegmentFile(*arguments);
  });
}

}  // namespace rangegrasp::cli
