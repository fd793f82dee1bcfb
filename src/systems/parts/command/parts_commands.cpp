#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/stopwatch.h"
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

using nlohmann::ordered_json;
using parts::Method;
using parts::Segmentation;

ordered_json Coordinates(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

std::string Number(const ordered_json& part, const std::string& key) {
  if (!part.contains(key) || part[key].is_null()) return "";
  return fmt::format("{:.6g}", part[key].get<double>());
}

void AppendVector(const ordered_json& v, std::vector<std::string>& cells) {
  for (const auto& x : v) cells.push_back(fmt::format("{:.6g}", x.get<double>()));
}

std::string NeighborsOf(const ordered_json& part) {
  std::string text;
  for (const auto& neighbor : part["neighbors"]) {
    text += fmt::format("{}{}", text.empty() ? "" : " ", neighbor["label"].get<int>());
    if (neighbor.contains("border")) {
      text += fmt::format(":{:.6g}", neighbor["border"].get<double>());
    }
  }
  return text;
}

/// Adds to a part's JSON what someone who grasps by parts wants, in the file's unit of length.
void DescribePart(const parts::PartDescription& part, bool mesh, ordered_json& json) {
  json["function"] = base::Word(part.function);
  if (mesh) json["area"] = part.area;
  if (mesh) json["volume"] = part.volume ? ordered_json(*part.volume) : ordered_json();
  json["holds"] = part.holds;
  json["center"] = Coordinates(part.center);
  json["axes"] = {Coordinates(part.axes.col(0)), Coordinates(part.axes.col(1)),
                  Coordinates(part.axes.col(2))};
  json["extents"] = Coordinates(part.extents);
  json["neighbors"] = ordered_json::array();
  for (const parts::PartNeighbor& neighbor : part.neighbors) {
    ordered_json entry = {{"label", neighbor.label}, {"joints", neighbor.joints}};
    if (mesh) entry["border"] = neighbor.border;
    json["neighbors"].push_back(entry);
  }
}

/// The same for people: "area 0.02, 0.1 x 0.08 x 0.08 about (0, 0, 0.05), borders on 1 (0.06)".
std::string PartMeasures(const ordered_json& part) {
  std::string text;
  if (part.contains("area")) text += fmt::format("area {:.4g}, ", part["area"].get<double>());
  if (part.contains("volume") && !part["volume"].is_null()) {
    text += fmt::format("volume {:.4g}, ", part["volume"].get<double>());
  }
  const auto extents = part["extents"].get<std::array<double, 3>>();
  const auto center = part["center"].get<std::array<double, 3>>();
  text += fmt::format("{:.4g} x {:.4g} x {:.4g} about ({:.4g}, {:.4g}, {:.4g})", extents[0],
                      extents[1], extents[2], center[0], center[1], center[2]);
  std::string before = ", borders on ";
  for (const auto& neighbor : part["neighbors"]) {
    text += fmt::format("{}{}", std::exchange(before, ", "), neighbor["label"].get<int>());
    if (neighbor.contains("border")) {
      text += fmt::format(" ({:.4g})", neighbor["border"].get<double>());
    }
  }
  return text;
}

/// CSV of a file's parts, a part a line; `neighbors` as "label:border label:border".
std::string PartTable(const ordered_json& json) {
  std::string text = base::CsvLine({"part", "function", "elements", "share", "area", "volume",
                                    "holds", "center_x", "center_y", "center_z", "axis_x", "axis_y",
                                    "axis_z", "extent_1", "extent_2", "extent_3", "neighbors"});
  for (const auto& part : json["parts"]) {
    std::vector<std::string> cells{std::to_string(part["label"].get<int>()),
                                   part["function"].get<std::string>(),
                                   std::to_string(part["elements"].get<std::size_t>())};
    for (const char* key : {"share", "area", "volume", "holds"}) cells.push_back(Number(part, key));
    AppendVector(part["center"], cells);
    AppendVector(part["axes"][0], cells);
    AppendVector(part["extents"], cells);
    cells.push_back(NeighborsOf(part));
    text += base::CsvLine(cells);
  }
  return text;
}

struct SegmentArguments {
  std::vector<std::string> files;
  std::string out = "results/parts", method = "mirror", up = "z";
  std::optional<int> clusters, level;
  std::optional<double> cut_quality;
  bool pose_invariant = false, go_on_outside = false, meshes = false, json = false;
};

// An option that the method would not look at is a mistake of the caller.
void CheckOptions(const SegmentArguments& arguments) {
  const Method method = base::FromWord<Method>(arguments.method, "--method");
  const auto check = [&](bool is_given, const std::vector<Method>& methods,
                         const std::string& option, const std::string& reason) {
    if (!is_given || std::ranges::find(methods, method) != methods.end()) return;
    throw base::InputError(option + ": method '" + arguments.method + "' has no use for it; " +
                           reason);
  };
  check(arguments.clusters.has_value(), {Method::kHierarchy, Method::kKMeans, Method::kSdf},
        "--parts",
        "it is for --method hierarchy, kmeans and sdf, the others find the number themselves");
  check(arguments.level.has_value(), {Method::kHierarchy, Method::kCore}, "--level",
        "it is for --method hierarchy and core, the others have no levels");
  check(arguments.level == 0, {Method::kHierarchy}, "--level 0",
        "core extraction has at least one level");
  check(arguments.cut_quality.has_value(), {Method::kHierarchy}, "--cut-quality",
        "it is for --method hierarchy");
  check(arguments.pose_invariant, {Method::kMirror}, "--pose-invariant",
        "it is for --method mirror");
  check(arguments.go_on_outside, {Method::kMirror}, "--go-on-outside", "it is for --method mirror");
}

// A shape with what was found of it.
struct Segmented {
  geometry::PolygonMesh input;
  Segmentation found;
  std::vector<parts::PartDescription> described;
  parts::Labels labels;    // of its triangles or points
  parts::Labels elements;  // of its polygons or points
  double seconds = 0.0;
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
                             "' needs a mesh, --method mirror and hierarchy take clouds too");
    }
    line.Begin(fmt::format("taking {} {} apart", shape.Elements(),
                           shape.IsMesh() ? "triangles" : "points"));
    const base::Stopwatch watch;
    result.found = parts::SegmentBy(method, shape,
                                    {.clusters = arguments.clusters,
                                     .level = arguments.level,
                                     .cut_quality = arguments.cut_quality,
                                     .pose_invariant = arguments.pose_invariant,
                                     .go_on_outside = arguments.go_on_outside});
    result.seconds = watch.Seconds();
    line.Begin("describing the parts");
    result.described = parts::DescribeParts(shape, result.found);
    result.labels = parts::LabelsOfInput(shape, result.input.mesh, result.found);
    result.elements = parts::LabelsOfPolygons(result.input, result.labels);
  } catch (const base::InputError& e) {
    throw base::InputError(file + ": " + e.what());
  }
  return result;
}

// A tree of cuts: `quality` is that of a node's best cut; none where it is null.
ordered_json TreeOf(const Segmentation& found) {
  ordered_json tree = ordered_json::array();
  for (std::size_t k = 0; k < found.tree.size(); ++k) {
    const auto& [parent, level, label, quality] = found.tree[k];
    tree.push_back(
        {{"node", k},
         {"parent", parent < 0 ? ordered_json() : ordered_json(parent)},
         {"level", level},
         {"label", label < 0 ? ordered_json() : ordered_json(label)},
         {"cut_quality", std::isfinite(quality) ? ordered_json(quality) : ordered_json()}});
  }
  return tree;
}

ordered_json JsonOf(const std::string& file, const SegmentArguments& arguments,
                    const Segmented& result) {
  const auto& found = result.found;
  const bool mesh = result.input.polygons > 0;
  ordered_json json = {{"file", file},
                       {"method", arguments.method},
                       {"vertices", result.input.mesh.vertices.size()},
                       {"faces", result.input.polygons},
                       {"element", mesh ? "face" : "point"},
                       {"elements", 0},
                       {"parts", ordered_json::array()},
                       {"note", found.note},
                       {"seconds", result.seconds}};
  std::vector<std::size_t> sizes(found.parts, 0);
  std::size_t elements = 0;  // that have a place, and so a part
  for (const std::int32_t label : result.elements) {
    if (label < 0) continue;
    ++sizes[label];
    ++elements;
  }
  json["elements"] = elements;
  for (int part = 0; part < found.parts; ++part) {
    const std::size_t size = sizes[part];
    const auto [r, g, b] = parts::PartColor(part);
    json["parts"].push_back({{"label", part},
                             {"core", found.has_core && part == 0},
                             {"elements", size},
                             {"share", static_cast<double>(size) / static_cast<double>(elements)},
                             {"color", fmt::format("#{:02x}{:02x}{:02x}", r, g, b)}});
    DescribePart(result.described[part], mesh, json["parts"].back());
  }
  if (!found.tree.empty()) json["tree"] = TreeOf(found);
  return json;
}

std::string TextOf(const ordered_json& json) {
  std::string text =
      fmt::format("{} parts of {} {}s\n", json["parts"].size(), json["elements"].get<std::size_t>(),
                  json["element"].get<std::string>());
  for (const auto& part : json["parts"]) {
    const auto function = part["function"].get<std::string>();
    text += fmt::format("part {}: {} {}s, {:.1f} %, {}{}{}\n", part["label"].get<int>(),
                        part["elements"].get<std::size_t>(), json["element"].get<std::string>(),
                        100.0 * part["share"].get<double>(), part["color"].get<std::string>(),
                        part["core"].get<bool>() ? ", the core" : "",
                        function == "other" ? "" : ", a " + function);
    text += "  " + PartMeasures(part) + "\n";
  }
  return text;
}

std::filesystem::path BaseOf(const std::string& file, const SegmentArguments& arguments) {
  return std::filesystem::path(arguments.out) / std::filesystem::path(file).filename().stem();
}

// Each part as BASE_part_<label>.stl.
void WriteMeshes(const std::filesystem::path& base, const Segmented& result) {
  for (std::int32_t part = 0; part < result.found.parts; ++part) {
    geometry::TriangleMesh mesh{result.input.mesh.vertices, {}};
    for (std::size_t f = 0; f < result.labels.size(); ++f) {
      if (result.labels[f] == part) mesh.triangles.push_back(result.input.mesh.triangles[f]);
    }
    geometry::WriteStl(fmt::format("{}_part_{}.stl", base.string(), part), mesh);
  }
}

ordered_json SegmentFile(const std::string& file, const SegmentArguments& arguments) {
  StepLine line(file);
  const Segmented result = Segment(file, arguments, line);
  if (arguments.meshes && result.input.polygons == 0) {
    throw base::InputError(file + ": is a point cloud; --meshes needs a mesh");
  }
  const auto base = BaseOf(file, arguments);
  line.Begin("writing");
  parts::WriteParts(base, result.input, result.labels, /*up=*/arguments.up[0] - 'x');
  if (arguments.meshes) WriteMeshes(base, result);
  line.End();
  if (!result.found.note.empty()) spdlog::info("{}", result.found.note);
  const ordered_json json = JsonOf(file, arguments, result);
  base::WriteFile(base.string() + ".csv", PartTable(json));
  spdlog::info("labels, colored shape, picture and table in {}.seg, .ply, .png, .csv",
               base.string());
  return json;
}

// Files of one name would leave their results in one place.
void CheckNames(const SegmentArguments& arguments) {
  std::map<std::filesystem::path, std::string> seen;
  for (const std::string& file : arguments.files) {
    const auto [at, is_new] = seen.try_emplace(BaseOf(file, arguments), file);
    if (is_new) continue;
    throw base::InputError(fmt::format("{} and {} would both leave {}.seg; give each its own -o",
                                       at->second, file, at->first.string()));
  }
}

void SegmentFiles(const SegmentArguments& arguments) {
  if (arguments.files.empty()) {
    throw base::InputError("parts: a FILE (.off, .obj, .stl, .ply, .glb, .gltf, .pcd) must follow");
  }
  CheckOptions(arguments);
  CheckNames(arguments);
  ordered_json all = ordered_json::array();
  std::string text;
  for (const std::string& file : arguments.files) {
    all.push_back(SegmentFile(file, arguments));
    text += (arguments.files.size() > 1 ? file + ": " : "") + TextOf(all.back());
  }
  const ordered_json& json = all.size() == 1 ? all.front() : all;
  WriteResult(arguments.json ? json.dump(2) + "\n" : text);
}

/// parts FILE
void AddPartsCommands(CLI::App& app) {
  auto* command = app.add_subcommand("parts", "Cuts a mesh or a point cloud into its parts.");
  auto arguments = std::make_shared<SegmentArguments>();
  command->add_option("files", arguments->files, "OFF, OBJ, STL, PLY, glTF or PCD, one or more");
  command
      ->add_option("--method", arguments->method, "mirror and hierarchy take clouds too (mirror)")
      ->check(CLI::IsMember(base::WordList<Method>()));
  command
      ->add_option("--parts", arguments->clusters,
                   "hierarchy: so many parts, best cuts first; kmeans, sdf: clusters (5)")
      ->check(CLI::Range(1, 1000));
  command
      ->add_option("--level", arguments->level,
                   "hierarchy: coarser parts, at most so many cuts deep; core: levels (2)")
      ->check(CLI::Range(0, 100));
  command
      ->add_option("--cut-quality", arguments->cut_quality,
                   "hierarchy: cuts worse than this are not made (0.42); more gives more parts")
      ->check(CLI::Range(0.001, 100.0));
  command->add_flag("--meshes", arguments->meshes,
                    "each part as a mesh too: NAME_part_<label>.stl");
  command->add_flag("--pose-invariant", arguments->pose_invariant,
                    "mirror: of the shape with its limbs stretched out");
  command->add_flag("--go-on-outside", arguments->go_on_outside,
                    "mirror: also where no center inside of the shape is found");
  command->add_option("--up", arguments->up, "axis that points up in the picture (z)")
      ->check(CLI::IsMember({"x", "y", "z"}));
  command->add_option("-o,--out", arguments->out, "folder (results/parts)");
  command->add_flag("--json", arguments->json, "parts and what was found about them, as JSON");
  command->footer("Example: rangegrasp parts cup.off --method hierarchy -o results/cup");
  // Hidden: says where it went.
  auto* evaluate = command->add_subcommand("evaluate")->group("")->allow_extras();
  evaluate->callback([] {
    throw base::InputError(
        "parts evaluate: methods are compared by 'rangegrasp run EXPERIMENT.yaml'");
  });
  command->callback([command, arguments] {
    if (command->get_subcommands().empty()) SegmentFiles(*arguments);
  });
}

}  // namespace
}  // namespace rangegrasp::cli

namespace rangegrasp {

void RegisterParts() {
  experiment::AddKind(parts::PartsTask());
  grasp::AddGraspSelector({.word = "handle",
                           .about = "by the handle that their parts tell (chapter 6)",
                           .prepare = parts::JoinCutOffHandle,
                           .plan = parts::PlanHandleGrasps,
                           .firm = true});  // what hangs next to the pads would creep about them
  cli::AddCommand(cli::AddPartsCommands);
}

}  // namespace rangegrasp
