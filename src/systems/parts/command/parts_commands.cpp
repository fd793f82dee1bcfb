#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <string>

#include "base/error.h"
#include "base/file.h"
#include "base/installation.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "geometry/mesh_file.h"
#include "grasp/detector.h"
#include "parts/function/description.h"
#include "parts/handle/handle_grasps.h"
#include "parts/method.h"
#include "parts/shape/shape_file.h"
#include "parts/task/parts_task.h"

namespace rangegrasp::cli {
namespace {

using parts::Method;
using parts::Segmentation;

struct SegmentArguments {
  std::vector<std::string> files;
  std::string out = "results/parts", method = "mirror";
  parts::MethodOptions options;
  bool meshes = false;
};

/// Rejects options that the method would ignore: they are a mistake of the caller.
void CheckOptions(const SegmentArguments& arguments) {
  const auto method = base::FromWord<Method>(arguments.method, "--method");
  const auto& options = arguments.options;
  const auto check = [&](bool is_given, const std::vector<Method>& methods,
                         const std::string& option, const std::string& reason) {
    if (!is_given || std::ranges::find(methods, method) != methods.end()) return;
    throw base::InputError(option + ": cannot be used with method '" + arguments.method + "'; " +
                           reason);
  };
  check(options.clusters.has_value(), {Method::kHierarchy, Method::kKMeans, Method::kSdf},
        "--parts",
        "it is for --method hierarchy, kmeans and sdf; the others choose the number of parts");
  check(options.cut_quality.has_value(), {Method::kHierarchy}, "--cut-quality",
        "it is for --method hierarchy");
  check(options.pose_invariant, {Method::kMirror}, "--pose-invariant", "it is for --method mirror");
  check(options.go_on_outside, {Method::kMirror}, "--go-on-outside", "it is for --method mirror");
}

/// A shape with its segmentation.
struct Segmented {
  geometry::PolygonMesh input;
  Segmentation found;
  std::vector<parts::PartDescription> described;
  parts::Labels labels;    ///< of its triangles or points
  std::vector<int> sizes;  ///< of each part, in polygons or points

  bool IsMesh() const { return input.polygons > 0; }
  /// Number of polygons or points that have a position, and thus a part.
  int Elements() const { return std::accumulate(sizes.begin(), sizes.end(), 0); }
  double Share(int part) const { return static_cast<double>(sizes[part]) / Elements(); }
  bool IsCore(int part) const { return found.has_core && part == 0; }
};

Segmented Segment(const std::string& file, const SegmentArguments& arguments, StepLine& line) {
  Segmented result;
  line.Begin("reading");
  result.input = parts::ReadPolygons(file);
  try {
    const parts::Shape shape = parts::MakeShape(result.input.mesh);
    const auto method = base::FromWord<Method>(arguments.method, "--method");
    if (!shape.IsMesh() && !parts::ReadsClouds(method)) {
      throw base::InputError("is a point cloud; method '" + arguments.method +
                             "' needs a mesh; --method mirror and hierarchy also take clouds");
    }
    line.Begin(
        fmt::format("segmenting {} {}", shape.Elements(), shape.IsMesh() ? "triangles" : "points"));
    result.found = parts::SegmentBy(method, shape, arguments.options);
    line.Begin("describing the parts");
    result.described = parts::DescribeParts(shape, result.found);
    result.labels = parts::LabelsOfInput(shape, result.input.mesh, result.found);
    result.sizes.assign(result.found.parts, 0);
    for (const std::int32_t label : parts::LabelsOfPolygons(result.input, result.labels)) {
      if (label >= 0) ++result.sizes[label];
    }
  } catch (const base::InputError& e) {
    throw base::InputError(file + ": " + e.what());
  }
  return result;
}

std::string ColorOf(std::int32_t label) {
  const auto [r, g, b] = parts::PartColor(label);
  return fmt::format("#{:02x}{:02x}{:02x}", r, g, b);
}

/// E.g. "1 (0.06), 2 (0.01)", for a mesh with the length of the border.
std::string NeighborsOf(const Segmented& result, const parts::PartDescription& part,
                        const char* with_border, const char* separator) {
  std::vector<std::string> words;
  for (const parts::PartNeighbor& neighbor : part.neighbors) {
    words.push_back(result.IsMesh()
                        ? fmt::format(fmt::runtime(with_border), neighbor.label, neighbor.border)
                        : std::to_string(neighbor.label));
  }
  return base::Join(words, separator);
}

std::string TextOf(const Segmented& result) {
  const char* element = result.IsMesh() ? "face" : "point";
  std::string text = fmt::format("{} of {}\n", base::Counted(result.found.parts, "part"),
                                 base::Counted(result.Elements(), element));
  for (const auto& part : result.described) {
    text += fmt::format("part {}: {}, {:.1f} %, {}", part.label,
                        base::Counted(result.sizes[part.label], element),
                        100.0 * result.Share(part.label), ColorOf(part.label));
    if (result.IsCore(part.label)) text += ", the core";
    if (part.function != parts::PartFunction::kOther) {
      text += fmt::format(", a {}", base::Word(part.function));
    }
    text += "\n  ";
    if (result.IsMesh()) text += fmt::format("area {:.4g}, ", part.area);
    text += fmt::format("{:.4g} x {:.4g} x {:.4g} about ({:.4g}, {:.4g}, {:.4g})", part.extents[0],
                        part.extents[1], part.extents[2], part.center[0], part.center[1],
                        part.center[2]);
    if (!part.neighbors.empty()) text += ", borders on ";
    text += NeighborsOf(result, part, "{} ({:.4g})", ", ") + "\n";
  }
  return text;
}

/// CSV with one line per part; `neighbors` as "label:border label:border".
std::string TableOf(const Segmented& result) {
  using Part = parts::PartDescription;
  using Columns = std::vector<experiment::Column<Part>>;
  Columns columns = {
      {"part", "", &Part::label},
      {"function", "", [](const Part& part) { return base::Word(part.function); }},
      {"elements", "", [&](const Part& part) { return result.sizes[part.label]; }},
      {"share", ".6g", [&](const Part& part) { return result.Share(part.label); }},
      {"area", ".6g",
       [&](const Part& part) { return result.IsMesh() ? std::optional(part.area) : std::nullopt; }},
      {"holds", ".6g", &Part::holds}};
  const auto add = [&](const std::vector<std::string>& titles, const auto& vector_of) {
    for (int k = 0; k < 3; ++k) {
      columns.push_back({titles[k], ".6g", [=](const Part& part) { return vector_of(part)[k]; }});
    }
  };
  add({"center_x", "center_y", "center_z"}, [](const Part& part) { return part.center; });
  add({"axis_x", "axis_y", "axis_z"},
      [](const Part& part) -> Eigen::Vector3d { return part.axes.col(0); });
  add({"extent_1", "extent_2", "extent_3"}, [](const Part& part) { return part.extents; });
  columns.push_back({"neighbors", "", [&](const Part& part) {
                       return NeighborsOf(result, part, "{}:{:.6g}", " ");
                     }});
  return CsvOf(GridOf(columns, result.described, ""));
}

std::string BaseOf(const std::string& file, const SegmentArguments& arguments) {
  return (std::filesystem::path(arguments.out) / std::filesystem::path(file).stem()).string();
}

/// Writes each part as BASE_part_<label>.stl.
void WriteMeshes(const std::string& base, const Segmented& result) {
  for (std::int32_t part = 0; part < result.found.parts; ++part) {
    geometry::TriangleMesh mesh{result.input.mesh.vertices, {}};
    for (std::size_t f = 0; f < result.labels.size(); ++f) {
      if (result.labels[f] == part) mesh.triangles.push_back(result.input.mesh.triangles[f]);
    }
    geometry::WriteStl(fmt::format("{}_part_{}.stl", base, part), mesh);
  }
}

/// What may find more parts where a method found only one and says nothing about it.
std::string AdviceOnOnePart(const Segmentation& found, const SegmentArguments& arguments) {
  const bool by_diameter = base::FromWord<Method>(arguments.method, "--method") == Method::kSdf;
  if (!by_diameter || found.parts != 1 || !found.note.empty()) return "";
  return "one part: the clusters of the diameters do not tell thick places from thin ones; try "
         "another number of clusters, e.g. --parts 2, or --method hierarchy";
}

Segmented SegmentFile(const std::string& file, const SegmentArguments& arguments) {
  StepLine line(file);
  Segmented result = Segment(file, arguments, line);
  if (arguments.meshes && !result.IsMesh()) {
    throw base::InputError(file + ": is a point cloud; --meshes needs a mesh");
  }
  const std::string base = BaseOf(file, arguments);
  line.Begin("writing");
  parts::WriteParts(base, result.input, result.labels);
  if (arguments.meshes) WriteMeshes(base, result);
  line.End();
  if (!result.found.note.empty()) spdlog::info("{}", result.found.note);
  if (const auto advice = AdviceOnOnePart(result.found, arguments); !advice.empty()) {
    spdlog::warn("{}: {}", file, advice);
  }
  base::WriteFile(base + ".csv", TableOf(result));
  spdlog::info("labels, colored shape, picture and table in {}.seg, .ply, .png, .csv", base);
  return result;
}

/// Files with the same name would overwrite each other's results, and no input may be overwritten.
void CheckNames(const SegmentArguments& arguments) {
  std::map<std::string, std::string> seen;
  for (const std::string& file : arguments.files) {
    const std::string base = BaseOf(file, arguments);
    RefuseOverwriting(file, base + ".ply");  // of the endings written, the only one that is read
    const auto [at, is_new] = seen.try_emplace(base, file);
    if (is_new) continue;
    throw base::InputError(fmt::format("{} and {} would both write {}.seg; give each its own -o",
                                       at->second, file, at->first));
  }
}

// An error in one of several files does not stop the others.
void SegmentFiles(const SegmentArguments& arguments) {
  if (arguments.files.empty()) {
    throw base::InputError(
        "parts: a FILE is missing (.off, .obj, .stl, .ply, .glb, .gltf, .pcd, .npy or .xyz)");
  }
  CheckOptions(arguments);
  CheckNames(arguments);
  const bool several = arguments.files.size() > 1;
  std::size_t failed = 0;
  for (const std::string& file : arguments.files) {
    try {
      const Segmented result = SegmentFile(file, arguments);
      WriteResult((several ? file + ": " : "") + TextOf(result));
    } catch (const base::NotBuilt&) {
      throw;  // the script that started the program may build or install it
    } catch (const base::NotInstalled&) {
      throw;
    } catch (const base::InputError& e) {
      if (!several) throw;
      spdlog::error(e.what());
      ++failed;
    }
  }
  if (failed > 0) {
    throw base::InputError(
        fmt::format("{} of {} shapes could not be segmented", failed, arguments.files.size()));
  }
}

/// parts FILE
void AddPartsCommands(CLI::App& app) {
  auto* command = app.add_subcommand("parts", "Segment a mesh or a point cloud into its parts.");
  auto arguments = std::make_shared<SegmentArguments>();
  command->add_option("files", arguments->files,
                      "OFF, OBJ, STL, PLY, glTF, PCD, NPY or XYZ, one or more");
  command
      ->add_option("--method", arguments->method,
                   "segmentation method; mirror and hierarchy also take clouds (mirror)")
      ->check(CLI::IsMember(base::WordList<Method>()));
  command
      ->add_option(
          "--parts", arguments->options.clusters,
          "hierarchy: number of parts, best cuts first; kmeans, sdf: number of clusters (5)")
      ->transform(WholeNumber(1, 1000));
  command
      ->add_option(
          "--cut-quality", arguments->options.cut_quality,
          "hierarchy: limit on the quality value of a cut (0.38); a larger limit gives more parts")
      ->check(NumberBetween(0.001, 100.0));
  command->add_flag("--meshes", arguments->meshes,
                    "also write each part as a mesh: NAME_part_<label>.stl");
  command->add_flag("--pose-invariant", arguments->options.pose_invariant,
                    "mirror: segment the shape with its limbs stretched out (section 6.2.3)");
  command->add_flag("--go-on-outside", arguments->options.go_on_outside,
                    "mirror: continue if no center inside the shape is found");
  command->add_option("-o,--out", arguments->out, "output folder (results/parts)");
  command->footer("Example: rangegrasp parts cup.off --method hierarchy -o results/cup");
  command->callback([arguments] { SegmentFiles(*arguments); });
}

}  // namespace
}  // namespace rangegrasp::cli

namespace rangegrasp {

void RegisterParts() {
  experiment::AddKind(parts::PartsTask());
  grasp::AddGraspSelector({.word = "handle",
                           .about = "by the handle found by segmentation into parts (chapter 6)",
                           .prepare = parts::JoinCutOffHandle,
                           .plan = parts::PlanHandleGrasps,
                           .firm = true});  // an object next to the pads would creep about them
  cli::AddCommand(cli::AddPartsCommands);
}

}  // namespace rangegrasp
