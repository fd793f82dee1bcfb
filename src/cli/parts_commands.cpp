#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/commands.h"
#include "cli/output.h"
#include "core/error.h"
#include "core/stopwatch.h"
#include "core/words.h"
#include "parts/method.h"
#include "parts/shape/shape_file.h"
#include "tasks/parts/write_parts.h"

namespace rangegrasp::cli {
namespace {

using nlohmann::ordered_json;
using parts::Method;
using parts::Segmentation;

struct SegmentArguments {
  std::string file, out = "results/parts", method = "mirror", up = "z";
  std::optional<int> clusters;
  bool pose_invariant = false, go_on_outside = false, json = false;
};

// An option that the method would not look at is a mistake of the caller.
void CheckOptions(const SegmentArguments& arguments) {
  const auto refuse = [&](const std::string& option, const std::string& methods) {
    throw core::InputError(option + ": method '" + arguments.method + "' has no use for it; " +
                           methods);
  };
  const Method method = core::FromWord<Method>(arguments.method, "--method");
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
    if (!shape.IsMesh() && arguments.method != core::Word(Method::kMirror)) {
      throw core::InputError("is a point cloud; method '" + arguments.method +
                             "' needs a mesh, --method mirror takes clouds too");
    }
    const core::Stopwatch watch;
    result.found = parts::SegmentBy(core::FromWord<Method>(arguments.method, "--method"), shape,
                                    {.clusters = arguments.clusters,
                                     .pose_invariant = arguments.pose_invariant,
                                     .go_on_outside = arguments.go_on_outside});
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
    throw core::InputError("parts: a FILE (.off, .obj, .stl, .ply, .pcd) must follow");
  }
  CheckOptions(arguments);
  const Segmented result = Segment(arguments);
  const auto base = std::filesystem::path(arguments.out) /
                    std::filesystem::path(arguments.file).filename().stem();
  tasks::WriteParts(base, result.input, result.labels, /*up=*/arguments.up[0] - 'x');
  const ordered_json json = JsonOf(arguments, result);
  if (!result.found.note.empty()) spdlog::info("{}", result.found.note);
  WriteResult(arguments.json ? json.dump(2) + "\n" : TextOf(json));
  spdlog::info("labels, colored shape and picture in {}.seg, .ply, .png", base.string());
}

}  // namespace

void AddPartsCommands(CLI::App& app) {
  auto* command = app.add_subcommand("parts", "Cuts a mesh or a point cloud into its parts.");
  auto arguments = std::make_shared<SegmentArguments>();
  command->add_option("file", arguments->file, "OFF, OBJ, STL, PLY or PCD");
  command->add_option("--method", arguments->method, "all but mirror need a mesh (mirror)")
      ->check(CLI::IsMember(core::WordList<Method>()));
  command->add_option("--parts", arguments->clusters, "clusters of kmeans and sdf (5)")
      ->check(CLI::Range(1, 1000));
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
    throw core::InputError(
        "parts evaluate: methods are compared by 'rangegrasp run EXPERIMENT.yaml'");
  });
  command->callback([command, arguments] {
    if (command->get_subcommands().empty()) SegmentFile(*arguments);
  });
}

}  // namespace rangegrasp::cli
