#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/units.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "cylinders/detect.h"
#include "cylinders/task/cylinders_task.h"
#include "cylinders/task/demo_detector.h"
#include "experiment/experiment.h"
#include "geometry/mesh.h"
#include "trial/command/perceive_command.h"

namespace rangegrasp::cli {
namespace {

using cylinders::CylinderScene;
using cylinders::FoundCylinder;
using cylinders::GivenCylinder;
using nlohmann::ordered_json;

struct CylindersArguments : CloudArguments {
  std::vector<std::string> given;
  std::string out;
  std::uint64_t seed = 1;
  bool json = false;
  bool as_published = false;
};

GivenCylinder ParseCylinder(const std::string& text) {
  if (const auto given = cylinders::GivenFrom(text, ',')) return *given;
  throw base::InputError("--cylinder '" + text +
                         "' must be RADIUS,HEIGHT in mm, both at least 1, e.g. 25.75,173");
}

std::string Name(const GivenCylinder& given, std::size_t index) {
  return fmt::format("cylinder {} (radius {:g} mm, height {:g} mm)", index + 1,
                     given.radius_m * base::kMmPerM, given.height_m * base::kMmPerM);
}

std::vector<std::string> Warnings(const CylinderScene& scene,
                                  const std::vector<GivenCylinder>& given) {
  std::vector<std::string> warnings;
  if (!scene.scan_order) {
    warnings.push_back("the cloud has no scan order: edges along scan lines are not detected");
  }
  const double extent_m = geometry::BoundsOf(scene.points_C).diagonal().norm();
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (std::max(2.0 * given[i].radius_m, given[i].height_m) > extent_m) {
      warnings.push_back(fmt::format("{} is larger than the scene ({:.0f} mm): try --unit",
                                     Name(given[i], i), extent_m * base::kMmPerM));
    } else if (!scene.Find(i)) {
      warnings.push_back(Name(given[i], i) + " was not found");
    }
  }
  return warnings;
}

ordered_json Json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ordered_json Json(const FoundCylinder& found) {
  const auto& c = found.cylinder_C;
  return {{"given", found.given + 1},
          {"center_m", Json(c.center)},
          {"axis", Json(c.axis)},
          {"top_m", Json(c.Top())},
          {"radius_m", c.radius_m},
          {"height_m", c.height_m},
          {"lies", found.lies},
          {"found_by", found.IsFromRim() ? "rim" : "barrel"},
          {"rim_share", found.rim_share},
          {"barrel_points", found.barrel.size()},
          {"length_seen_m", found.length_seen_m},
          {"rays_on", found.view.on},
          {"rays_before", found.view.before},
          {"rays_through", found.view.through}};
}

ordered_json Json(const CylindersArguments& arguments, const CylinderScene& scene,
                  const std::vector<GivenCylinder>& given) {
  ordered_json json = {{"cloud", arguments.cloud},
                       {"unit", arguments.unit},
                       {"frame", "cloud"},  // of all positions and directions here, in metres
                       {"points", scene.points_C.size()},
                       {"noise_m", scene.sampling.noise_m},
                       {"spacing_m", scene.sampling.spacing_m},
                       {"scan_order", scene.scan_order},
                       {"table",
                        {{"normal", Json(scene.table.plane.normal)},
                         {"offset_m", scene.table.plane.offset_m},
                         {"points", scene.table.points.size()}}},
                       {"outliers", scene.outliers.size()},
                       {"curvature_points", scene.curved.size()},
                       {"edge_points", scene.edges.size()},
                       {"fragments", scene.fragments.size()},
                       {"rims", scene.rims.size()},
                       {"given", ordered_json::array()},
                       {"cylinders", ordered_json::array()},
                       {"warnings", Warnings(scene, given)},
                       {"seconds", ordered_json::object()}};
  for (std::size_t i = 0; i < given.size(); ++i) {
    json["given"].push_back({{"radius_m", given[i].radius_m},
                             {"height_m", given[i].height_m},
                             {"found", scene.Find(i) != nullptr}});
  }
  for (const auto& found : scene.cylinders) json["cylinders"].push_back(Json(found));
  for (const auto& [step, seconds] : scene.seconds) json["seconds"][step] = seconds;
  return json;
}

std::string Text(const CylinderScene& scene, const std::vector<GivenCylinder>& given) {
  std::string text = fmt::format(
      "{}, {} of the table; {} by normals, {} by scan lines; {}, {}\n",
      base::Counted(scene.points_C.size(), "point"), scene.table.points.size(),
      base::Counted(scene.curved.size(), "curvature point"), scene.edges.size(),
      base::Counted(scene.fragments.size(), "fragment"), base::Counted(scene.rims.size(), "rim"));
  for (const FoundCylinder& found : scene.cylinders) {
    const auto& c = found.cylinder_C;
    text += fmt::format(
        "{}: {}, by its {}, center ({:.4f}, {:.4f}, {:.4f}) m, axis ({:.4f}, {:.4f}, {:.4f}), "
        "radius as measured {:.2f} mm\n",
        Name(given[found.given], found.given), found.lies ? "lies" : "stands",
        found.IsFromRim() ? "rim" : "barrel", c.center.x(), c.center.y(), c.center.z(), c.axis.x(),
        c.axis.y(), c.axis.z(), c.radius_m * base::kMmPerM);
  }
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (!scene.Find(i)) text += Name(given[i], i) + ": not found\n";
  }
  return text;
}

void Detect(const CylindersArguments& arguments) {
  std::vector<GivenCylinder> given;
  for (const std::string& text : arguments.given) given.push_back(ParseCylinder(text));
  auto file = ReadCloud(arguments);
  const Eigen::Vector3d origin = OriginOf(arguments, file);
  WarnOfCloud(arguments, file);
  auto options = arguments.as_published ? cylinders::AsPublished() : cylinders::DetectOptions{};
  options.preprocess.up_C = UpOf(arguments);
  base::Rng rng(arguments.seed);
  CylinderScene scene;
  try {
    const auto observation =
        geometry::ObservationOf({file.height, file.width, std::move(file.points), {origin}});
    scene = cylinders::DetectCylinders(observation, given, options, rng);
  } catch (const base::InputError& e) {
    throw base::InputError(arguments.cloud + ": " + e.what() + OriginAdvice(arguments, origin));
  }
  if (const auto warning = SideWarning(scene.table.plane, origin); !warning.empty()) {
    spdlog::warn("{}: {}", arguments.cloud, warning);
  }
  const std::string json = Json(arguments, scene, given).dump(2) + "\n";
  for (const std::string& warning : Warnings(scene, given)) spdlog::warn("{}", warning);
  WriteResult(arguments.json ? json : Text(scene, given));
  if (arguments.out.empty()) return;
  const std::filesystem::path folder(arguments.out);
  WriteResult(json, folder / "cylinders.json");
  draw::DrawCylinders(scene, origin, folder / "cylinders.png");
  spdlog::info("picture in {}", folder.string());
}

}  // namespace

void AddCylindersCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "cylinders", "Find the poses of given cylinders among other objects on a table in a cloud.");
  auto arguments = std::make_shared<CylindersArguments>();
  command->add_option("cloud", arguments->cloud, "PCD, PLY, NPY or XYZ")->required();
  AddCloudOptions(*command, *arguments);
  command
      ->add_option("--cylinder", arguments->given,
                   "RADIUS,HEIGHT of a cylinder to find [mm]; may be repeated")
      ->required()
      ->expected(1)
      ->take_all();
  command->add_flag("--as-published", arguments->as_published,
                    "the dissertation's method with its lengths, without later additions");
  command->add_option("--seed", arguments->seed, "seed of the random draws")
      ->transform(WholeNumber());
  command->add_flag("--json", arguments->json, "print the result as JSON");
  command->add_option("-o,--out", arguments->out,
                      "output folder for cylinders.json and cylinders.png");
  command->footer(
      "Example: rangegrasp cylinders table.pcd --cylinder 25.75,173 --cylinder 26.75,134 -o "
      "results/cylinders");
  command->callback([arguments] { Detect(*arguments); });
}

}  // namespace rangegrasp::cli

namespace rangegrasp {

void RegisterCylinders() {
  experiment::AddKind(cylinders::CylindersTask());
  experiment::AddKind(cylinders::DemoTask());
  experiment::AddKind(cylinders::RecallTask());
  cli::AddCommand(cli::AddCylindersCommand);
}

}  // namespace rangegrasp
