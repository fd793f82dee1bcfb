#include "parts/command/parts_commands.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/file.h"
#include "base/stopwatch.h"
#include "base/words.h"
#include "cli/output.h"
#include "cli/step_line.h"
#include "geometry/mesh_file.h"
#include "parts/command/part_table.h"
#include "parts/function/description.h"
#include "parts/method.h"
#include "parts/shape/shape_file.h"
#include "parts/task/write_parts.h"

namespace rangegrasp::cli {
namespace {

using nlohmann::ordered_json;
using parts::Method;
using parts::Segmentation;

struct SegmentArguments {
  std::vector<std::string> files;
  std::string out = "results/parts", method = "mirror", up = "z";
  std::optional<int> clusters, level;
  std::optional<double> cut_quality;
  bool pose_invariant = false, go_on_outside = false, meshes = false, json = false;
};

// An option that the method would not look at is a mistake of the caller.
void CheckOptions(const SegmentArguments& arguments) {
  const auto refuse = [&](const std::string& option, const std::string& methods) {
    throw base::InputError(option + ": method '" + arguments.method + "' has no use for it; " +
                           methods);
  };
  const Method method = base::FromWord<Method>(arguments.method, "--method");
  if (arguments.clusters && (method == Method::kMirror || method == Method::kCore)) {
    refuse("--parts",
           "it is for --method hierarchy, kmeans and sdf, the others find the number themselves");
  }
  if (arguments.level && method != Method::kHierarchy && method != Method::kCore) {
    refuse("--level", "it is for --method hierarchy and core, the others have no levels");
  }
  if (arguments.level == 0 && method == Method::kCore) {
    refuse("--level 0", "core extraction has at least one level");
  }
  if (arguments.cut_quality && method != Method::kHierarchy) {
    refuse("--cut-quality", "it is for --method hierarchy");
  }
  if (arguments.pose_invariant && method != Method::kMirror) {
    refuse("--pose-invariant", "it is for --method mirror");
  }
  if (arguments.go_on_outside && method != Method::kMirror) {
    refuse("--go-on-outside", "it is for --method mirror");
  }
}

// A shape with what was found of it.
struct Segmented {
  geometry::PolygonMesh input;
  Segmentation found;
  std::vector<parts::PartDescription> described;
  std::vector<std::int32_t> labels;    // of its triangles or points
  std::vector<std::int32_t> elements;  // of its polygons or points
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

std::string HexOf(const std::array<std::uint8_t, 3>& color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color[0], color[1], color[2]);
}

// A tree of cuts: `quality` is that of a node's best cut; none where it is null.
ordered_json TreeOf(const Segmentation& found) {
  ordered_json tree = ordered_json::array();
  for (std::size_t k = 0; k < found.tree.size(); ++k) {
    const parts::PartNode& node = found.tree[k];
    tree.push_back({{"node", k},
                    {"parent", node.parent < 0 ? ordered_json() : ordered_json(node.parent)},
                    {"level", node.level},
                    {"label", node.label < 0 ? ordered_json() : ordered_json(node.label)},
                    {"cut_quality",
                     std::isfinite(node.quality) ? ordered_json(node.quality) : ordered_json()}});
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
  std::vector<std::size_t> sizes(static_cast<std::size_t>(found.parts), 0);
  std::size_t elements = 0;  // that have a place, and so a part
  for (const std::int32_t label : result.elements) {
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
    DescribePart(result.described[static_cast<std::size_t>(part)], mesh, json["parts"].back());
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
  parts_task::WriteParts(base, result.input, result.labels, /*up=*/arguments.up[0] - 'x');
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

}  // namespace

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

}  // namespace rangegrasp::cli
