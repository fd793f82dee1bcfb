#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "base/error.h"
#include "geometry/bounds.h"
#include "geometry/mesh_file.h"
#include "perception/perceive.h"
#include "recognition/command/recognition_commands.h"
#include "recognition/learn.h"
#include "trial/command/cloud_arguments.h"

namespace rangegrasp::cli {
namespace {

/// Below this the unseen side is guessed: another view would tell it.
constexpr double kWellSeen = 0.9;

struct LearnArguments : CloudArguments {
  std::vector<std::string> clouds;
  std::string out;
  double spacing_mm = recognition::LearnOptions{}.spacing_m / base::kMm;
};

geometry::Observation ReadViews(const LearnArguments& arguments) {
  geometry::Observation observation;
  for (const std::string& cloud : arguments.clouds) {
    CloudArguments one = arguments;
    one.cloud = cloud;
    const auto file = ReadCloud(one);
    geometry::View& view = observation.views.emplace_back();
    view.image.profiles = file.height;
    view.image.samples = file.width;
    view.image.points_C = file.points;
    view.image.origins_C = {OriginOf(one, file)};
    view.X_CV.translation() = view.image.origins_C.front();
  }
  return observation;
}

void Run(const LearnArguments& arguments) {
  perception::PerceptionOptions options;
  options.preprocess.up_C = UpOf(arguments);
  recognition::LearnOptions learn;
  learn.spacing_m = arguments.spacing_mm * base::kMm;
  base::Rng rng(1);
  recognition::LearntModel model;
  std::size_t things = 0;
  try {
    const auto scene = perception::Perceive(ReadViews(arguments), options, rng);
    things = scene.objects.size();
    model = recognition::Learn(scene, learn);
  } catch (const base::InputError& e) {
    throw base::InputError(fmt::format("{}{}: {}", arguments.clouds.front(),
                                       arguments.clouds.size() > 1 ? " and others" : "", e.what()));
  }
  geometry::WriteStl(arguments.out, model.mesh_B);
  const Eigen::Vector3d size_mm = geometry::BoundsOf(model.mesh_B.vertices).sizes() * base::kMmPerM;
  spdlog::info(
      "{}: {:.0f} x {:.0f} x {:.0f} mm, {} triangles; {:.0f} % of what is above the table "
      "was seen",
      arguments.out, size_mm.x(), size_mm.y(), size_mm.z(), model.mesh_B.triangles.size(),
      100.0 * model.share_seen);
  if (things > 1) {
    spdlog::warn("{} things stand there and are one model: --crop leaves out what is not its",
                 things);
  }
  if (model.share_seen < kWellSeen) {
    spdlog::warn("what was not seen is guessed: a view from another side would tell it");
  }
}

}  // namespace

void AddLearnCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "learn", "A mesh of a thing that stands alone on a table, from views of it.");
  auto arguments = std::make_shared<LearnArguments>();
  command
      ->add_option("clouds", arguments->clouds,
                   "PCD or PLY files in one frame, each seen from the place that it names")
      ->required();
  command->add_option("-o,--out", arguments->out, "the mesh (STL, in metres), for add-object")
      ->required();
  command->add_option("--spacing-mm", arguments->spacing_mm, "of what the mesh is made of (2)")
      ->check(CLI::Range(0.2, 20.0));
  AddCloudOptions(*command, *arguments);
  command->footer(
      "Example: rangegrasp learn mug_1.pcd mug_2.pcd mug_3.pcd -o mug.stl\n"
      "then:    rangegrasp add-object mug.stl --unit m --surface ceramic --mass 320 --out known");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace rangegrasp::cli
