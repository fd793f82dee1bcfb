#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/units.h"
#include "cli/output.h"
#include "perception/perceive.h"
#include "recognition/command/recognition_commands.h"
#include "recognition/recognize.h"
#include "recognition/task/known_objects.h"
#include "trial/command/cloud_arguments.h"

namespace rangegrasp::cli {
namespace {

using nlohmann::ordered_json;

struct RecognizeArguments : CloudArguments {
  std::vector<std::string> library;
  std::uint64_t seed = 1;
  bool json = false;
};

ordered_json Json(const base::Pose& X_CB) {
  const Eigen::Vector3d& p = X_CB.translation();
  const Eigen::Quaterniond q(X_CB.linear());
  return {{"position_m", {p.x(), p.y(), p.z()}}, {"quaternion", {q.w(), q.x(), q.y(), q.z()}}};
}

std::string JsonText(const std::vector<recognition::FoundObject>& found, std::size_t perceived) {
  ordered_json json = {{"perceived", perceived}, {"found", ordered_json::array()}};
  for (const auto& one : found) {
    ordered_json alternatives = ordered_json::array();
    for (const auto& X_CB : one.alternatives_CB) alternatives.push_back(Json(X_CB));
    json["found"].push_back({{"object", one.object},
                             {"pose", Json(one.X_CB)},
                             {"score", one.score},
                             {"color", one.color},
                             {"share_seen", one.share_seen},
                             {"violations", one.violations},
                             {"rms_m", one.rms_m},
                             {"samples", one.samples.size()},
                             {"alternatives", alternatives}});
  }
  return json.dump(2) + "\n";
}

std::string Text(const std::vector<recognition::FoundObject>& found, std::size_t perceived) {
  std::string text = fmt::format("{} of {} perceived objects are known\n", found.size(), perceived);
  for (const auto& one : found) {
    const Eigen::Vector3d p = one.X_CB.translation() * base::kMmPerM;
    const Eigen::Quaterniond q(one.X_CB.linear());
    text += fmt::format(
        "{}: at {:.1f} {:.1f} {:.1f} mm, turned by {:.4f} {:.4f} {:.4f} {:.4f} (w x y z), score "
        "{:.3f}{}\n",
        one.object, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), one.score,
        one.alternatives_CB.empty() ? "" : ", other poses fit about as well");
  }
  return text;
}

void Run(const RecognizeArguments& arguments) {
  const std::vector<std::filesystem::path> folders(arguments.library.begin(),
                                                   arguments.library.end());
  const recognition::Library library = recognition::LoadLibrary(folders);
  const auto file = ReadCloud(arguments);
  geometry::RangeImage image;
  image.profiles = file.height;
  image.samples = file.width;
  image.points_C = file.points;
  image.origins_C = {OriginOf(arguments, file)};
  auto observation = geometry::ObservationOf(std::move(image));
  observation.views.front().colors = file.colors;
  observation.views.front().X_CV.translation() = observation.views.front().image.origins_C.front();
  perception::PerceptionOptions options;
  options.preprocess.up_C = UpOf(arguments);
  base::Rng rng(arguments.seed);
  std::vector<recognition::FoundObject> found;
  std::size_t perceived = 0;
  try {
    const auto scene = perception::Perceive(observation, options, rng);
    perceived = scene.objects.size();
    found = recognition::Recognize(observation, scene, library, {}, rng);
  } catch (const base::InputError& e) {
    throw base::InputError(arguments.cloud + ": " + e.what());
  }
  WriteResult(arguments.json ? JsonText(found, perceived) : Text(found, perceived));
}

}  // namespace

void AddRecognizeCommand(CLI::App& app) {
  auto* command = app.add_subcommand("recognize", "Known objects in a cloud, and their poses.");
  auto arguments = std::make_shared<RecognizeArguments>();
  command->add_option("cloud", arguments->cloud, "PCD or PLY file")->required();
  command
      ->add_option("--library", arguments->library,
                   "folder of known objects (NAME/NAME.xml), or several; of two with one name that "
                   "of the first counts")
      ->required();
  AddCloudOptions(*command, *arguments);
  command->add_option("--seed", arguments->seed, "of the random draws")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--json", arguments->json, "everything as JSON");
  command->footer("Example: rangegrasp recognize table.pcd --library models/objects --json");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace rangegrasp::cli
