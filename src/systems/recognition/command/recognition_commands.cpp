#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/installation.h"
#include "base/units.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "cli/run.h"
#include "experiment/experiment.h"
#include "geometry/mesh.h"
#include "geometry/mesh_file.h"
#include "perception/perceive.h"
#include "recognition/learn.h"
#include "recognition/recognize.h"
#include "recognition/task/bring_task.h"
#include "recognition/task/recognition_task.h"
#include "recognition/views/wrist_scanner.h"
#include "trial/command/perceive_command.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::cli {
namespace {

using nlohmann::ordered_json;

struct BringArguments {
  std::string object;
  std::string experiment = "bring";
  std::string arrangement, pictures;
  experiment::Changes changes;
};

/// An object's run.
const experiment::Case& RunOf(const std::string& object, const experiment::Experiment& opened) {
  for (const auto& one : opened.cases) {
    if (one.group == object) return one;
  }
  const auto known = experiment::GroupsOf(opened.cases);
  throw base::InputError(fmt::format(
      "{}: has no '{}'{} (its objects are {}; others need an experiment file that lists them: "
      "--experiment FILE)",
      opened.common.file.string(), object, base::Suggestion(object, known, "; did you mean '{}'?"),
      base::Join(known)));
}

void BringIt(BringArguments a) {
  if (!a.arrangement.empty()) a.changes.set.push_back("arrangement=" + a.arrangement);
  a.changes.trials = 1;
  const auto file = base::FindExperiment(a.experiment);
  const auto opened = experiment::OpenExperiment(file, a.changes, RefuseErrors(file));
  if (opened.kind->name != bring::BringTask().name) {
    throw base::InputError("the experiment has another task; write `task: bring` into it");
  }
  const experiment::Case& which = RunOf(a.object, opened);
  const auto result =
      opened.task->Replay(which, {.folder = a.pictures, .snapshots = !a.pictures.empty()});
  const auto data = ordered_json::parse(result.data);
  for (const std::string words : data.value("words", ordered_json::array())) {
    WriteResult(words + "\n");
  }
  WriteResult(fmt::format("{}: {}\n", which.id, result.outcome));
  if (const auto grasp = opened.kind->summary(result); !grasp.empty()) {
    WriteResult("  " + grasp + "\n");
  }
  if (result.outcome != trial::kHandedOver && result.outcome != bring::kSaidAbsent) {
    // Without an arrangement nothing was run that could have crashed.
    const std::string outcome = result.stage == "arrange" ? "" : result.outcome + " ";
    throw base::RunError(
        fmt::format("the {} was not handed over: {}{}", a.object, outcome, result.detail));
  }
}

void AddBringCommand(CLI::App& app) {
  auto* command = app.add_subcommand("bring",
                                     "Bring an object: find it among others, grasp it and hand it "
                                     "over; prints the steps at the end.");
  auto a = std::make_shared<BringArguments>();
  command->add_option("object", a->object, "the wanted object, e.g. coffee_cup")->required();
  command->add_option("--experiment", a->experiment,
                      "experiment of `task: bring`, with the objects on the table");
  command->add_option(
      "--arrangement", a->arrangement,
      "single, scattered, touching, side_by_side, box or pile, instead of the experiment's");
  command->add_option("--seed", a->changes.seed, "overrides the seed of the experiment")
      ->transform(WholeNumber());
  command->add_option("--set", a->changes.set, "KEY=VALUE, overrides a key of the experiment")
      ->allow_extra_args(false);
  command->add_option("--pictures", a->pictures, "folder for pictures of the run");
  command->footer("Example: rangegrasp bring coffee_cup --arrangement pile --pictures results/cup");
  command->callback([a] { BringIt(*a); });
}

/// Below this share too much is guessed, which another view would show.
constexpr double kWellSeen = 0.9;

struct LearnArguments : CloudArguments {
  std::vector<std::string> clouds;
  std::string out;
  std::vector<double> frame;  // empty: that of LearntModel
  double spacing_mm = recognition::kLearnSpacing_m / base::kMm;
};

/// A cloud's file as a view from its sensor position.
geometry::View ReadView(const CloudArguments& arguments) {
  Cloud file = ReadCloud(arguments);
  const Eigen::Vector3d origin = OriginOf(arguments, file);
  WarnOfCloud(arguments, file);
  geometry::View view;
  view.image = {file.height, file.width, std::move(file.points), {origin}};
  view.X_CV.translation() = origin;
  view.colors = std::move(file.colors);
  return view;
}

std::string AdviceOf(const CloudArguments& arguments, const geometry::Observation& observation,
                     const perception::PerceptionOptions& options, base::Rng& rng) {
  const geometry::View& first = observation.views.front();
  const std::string of_table =
      TableAdvice(geometry::ToCloud(first.image).points, first.X_CV.translation(), options, rng);
  if (!of_table.empty()) return of_table;
  for (const geometry::View& view : observation.views) {
    const std::string advice = OriginAdvice(arguments, view.X_CV.translation());
    if (!advice.empty()) return advice;
  }
  return "";
}

/// Warns of views whose sensor is not on the objects' side of the table, which hides the objects.
/// @param clouds  the files of the views
void WarnOfSides(const std::vector<std::string>& clouds, const perception::Scene& scene,
                 const geometry::Observation& observation) {
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    const Eigen::Vector3d sensor_C = observation.views[i].X_CV.translation();
    const std::string warning = SideWarning(scene.table.plane, sensor_C);
    if (!warning.empty()) spdlog::warn("{}: {}", clouds[i], warning);
  }
}

/// A pose from its 4 x 4 matrix, row by row.
base::Pose PoseOf(const std::vector<double>& rows) {
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(rows.data());
  base::Pose X;
  X.matrix() = matrix;
  constexpr double kRounding = 1e-6;  // of numbers written with ten digits
  const bool turns =
      (X.linear() * X.linear().transpose()).isIdentity(kRounding) && X.linear().determinant() > 0.0;
  if (!turns || !matrix.allFinite() ||
      !matrix.row(3).isApprox(Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0))) {
    throw base::InputError(
        "--frame must be a 4 x 4 pose matrix, row by row: a rotation, a finite translation in "
        "metres, and 0,0,0,1");
  }
  return X;
}

void LearnModel(const LearnArguments& arguments) {
  CheckEnding(arguments.out, {".stl"});
  perception::PerceptionOptions options;
  options.preprocess.up_C = UpOf(arguments);
  base::Rng rng(1);
  recognition::LearntModel model;
  std::size_t things = 0;
  geometry::Observation observation;
  for (const std::string& cloud : arguments.clouds) {
    CloudArguments one = arguments;
    one.cloud = cloud;
    observation.views.push_back(ReadView(one));
    observation.views.back().colors.clear();
  }
  try {
    const auto scene = perception::Perceive(observation, options, rng);
    WarnOfSides(arguments.clouds, scene, observation);
    things = scene.objects.size();
    model = recognition::Learn(scene, arguments.spacing_mm * base::kMm);
  } catch (const base::InputError& e) {
    throw base::InputError(fmt::format("{}{}: {}{}", arguments.clouds.front(),
                                       arguments.clouds.size() > 1 ? " and others" : "", e.what(),
                                       AdviceOf(arguments, observation, options, rng)));
  }
  if (!arguments.frame.empty()) {
    const base::Pose X_CF = PoseOf(arguments.frame);
    model.mesh_B = geometry::Transformed(model.mesh_B, X_CF.inverse() * model.X_CB);
  }
  geometry::WriteStl(arguments.out, model.mesh_B);
  const Eigen::Vector3d size_mm = geometry::BoundsOf(model.mesh_B.vertices).sizes() * base::kMmPerM;
  spdlog::info(
      "{}: {:.0f} x {:.0f} x {:.0f} mm, {} triangles; {:.0f} % of the surface above the table was "
      "seen",
      arguments.out, size_mm.x(), size_mm.y(), size_mm.z(), model.mesh_B.triangles.size(),
      100.0 * model.share_seen);
  if (things > 1) {
    spdlog::warn("{} objects were merged into one model: use --crop to exclude the others", things);
  }
  if (model.share_seen < kWellSeen) {
    spdlog::warn("unseen parts are guessed; add a view from another side");
  }
}

void AddLearnCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "learn", "Make a mesh of a single object on a table from several views of it.");
  auto arguments = std::make_shared<LearnArguments>();
  command
      ->add_option("clouds", arguments->clouds,
                   "PCD, PLY, NPY or XYZ files in one frame, each with its sensor position")
      ->required();
  command->add_option("-o,--out", arguments->out, "output mesh (STL, in metres), for add-object")
      ->required();
  command
      ->add_option("--spacing-mm", arguments->spacing_mm,
                   "spacing of the points that the mesh is made from (2)")
      ->check(NumberBetween(0.2, 20.0));
  command
      ->add_option("--frame", arguments->frame,
                   "pose of the mesh's frame in the clouds' frame: a 4 x 4 matrix, row by row [m] "
                   "(default: z points up from the table, the origin is below the middle)")
      ->delimiter(',')
      ->expected(16);
  AddCloudOptions(*command, *arguments);
  command->footer(
      "Example: rangegrasp learn mug_1.pcd mug_2.pcd "
      "--crop -0.3,-0.3,-0.1,0.3,0.3,0.4 -o mug.stl\n"
      "then:    rangegrasp add-object mug.stl --unit m --surface ceramic --mass 320 --out known");
  command->callback([arguments] { LearnModel(*arguments); });
}

struct RecognizeArguments : CloudArguments {
  std::string library;
  double tolerance_mm = recognition::RecognitionOptions().tolerance_m * base::kMmPerM;
  std::uint64_t seed = 1;
  bool json = false;
};

ordered_json Json(const base::Pose& X_CB) {
  const Eigen::Vector3d& p = X_CB.translation();
  const Eigen::Quaterniond q(X_CB.linear());
  return {{"position_m", {p.x(), p.y(), p.z()}}, {"quaternion", {q.w(), q.x(), q.y(), q.z()}}};
}

/// The result for one cloud.
struct RecognizedCloud {
  std::vector<perception::PerceivedObject> perceived;
  std::vector<recognition::FoundObject> found;
  std::vector<recognition::UnknownObject> unknown;
};

std::string JsonText(const RecognizedCloud& recognized) {
  ordered_json json = {{"perceived", recognized.perceived.size()},
                       {"found", ordered_json::array()},
                       {"unknown", ordered_json::array()}};
  for (const auto& one : recognized.found) {
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
  for (const auto& one : recognized.unknown) {
    const auto& object = recognized.perceived[one.object];
    const Eigen::Vector3d &center = object.center_C, &size = object.size_m;
    json["unknown"].push_back({{"center_m", {center.x(), center.y(), center.z()}},
                               {"size_m", {size.x(), size.y(), size.z()}},
                               {"nearest", one.nearest},
                               {"score", one.score},
                               {"reason", one.reason}});
  }
  return json.dump(2) + "\n";
}

std::string Text(const RecognizedCloud& recognized) {
  std::string text = fmt::format("{} of {} perceived objects are known\n", recognized.found.size(),
                                 recognized.perceived.size());
  for (const auto& one : recognized.found) {
    const Eigen::Vector3d p = one.X_CB.translation() * base::kMmPerM;
    const Eigen::Quaterniond q(one.X_CB.linear());
    text += fmt::format(
        "{}: at {:.1f} {:.1f} {:.1f} mm, turned by {:.4f} {:.4f} {:.4f} {:.4f} (w x y z), score "
        "{:.3f}{}\n",
        one.object, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), one.score,
        one.alternatives_CB.empty() ? "" : ", other poses fit about equally well");
  }
  for (const auto& one : recognized.unknown) {
    const auto& object = recognized.perceived[one.object];
    const Eigen::Vector3d p = object.center_C * base::kMmPerM;
    const Eigen::Vector3d size = object.size_m * base::kMmPerM;
    text += fmt::format("unknown: at {:.0f} {:.0f} {:.0f} mm, {:.0f} x {:.0f} x {:.0f} mm{}: {}\n",
                        p.x(), p.y(), p.z(), size.x(), size.y(), size.z(),
                        one.nearest.empty()
                            ? ""
                            : fmt::format(", nearest {}, score {:.3f}", one.nearest, one.score),
                        one.reason);
  }
  return text;
}

void RecognizeCloud(const RecognizeArguments& arguments) {
  geometry::Observation observation;
  observation.views.push_back(ReadView(arguments));
  if (!observation.views.front().image.HasScanOrder()) {
    spdlog::warn(
        "{}: the cloud has no scan order: rays that did not return are not known, so poses "
        "and names are less certain",
        arguments.cloud);
  }
  // A library takes seconds to prepare: an error of the cloud is reported before.
  const auto library = recognition::LoadLibrary(arguments.library);
  perception::PerceptionOptions options;
  options.preprocess.up_C = UpOf(arguments);
  base::Rng rng(arguments.seed);
  RecognizedCloud recognized;
  try {
    auto scene = perception::Perceive(observation, options, rng);
    WarnOfSides({arguments.cloud}, scene, observation);
    recognition::RecognitionOptions recognition;
    recognition.tolerance_m = arguments.tolerance_mm / base::kMmPerM;
    recognized.found =
        recognition::Recognize(observation, scene, library, recognition, {}, &recognized.unknown);
    recognized.perceived = std::move(scene.objects);
  } catch (const base::InputError& e) {
    throw base::InputError(arguments.cloud + ": " + e.what() +
                           AdviceOf(arguments, observation, options, rng));
  }
  WriteResult(arguments.json ? JsonText(recognized) : Text(recognized));
}

void AddRecognizeCommand(CLI::App& app) {
  auto* command = app.add_subcommand("recognize", "Find known objects and their poses in a cloud.");
  auto arguments = std::make_shared<RecognizeArguments>();
  command->add_option("cloud", arguments->cloud, "PCD, PLY, NPY or XYZ file")->required();
  command
      ->add_option("--library", arguments->library,
                   "folder of known objects (NAME/NAME.xml, or NAME.stl in metres)")
      ->required();
  AddCloudOptions(*command, *arguments);
  command
      ->add_option("--tolerance-mm", arguments->tolerance_mm,
                   "maximum distance of explained samples from a model's surface (3)")
      ->check(NumberBetween(0.5, 20.0));
  command->add_option("--seed", arguments->seed, "seed of perception's random draws")
      ->transform(WholeNumber());
  command->add_flag("--json", arguments->json, "print the result as JSON");
  command->footer("Example: rangegrasp recognize table.pcd --library models/objects --json");
  command->callback([arguments] { RecognizeCloud(*arguments); });
}

}  // namespace
}  // namespace rangegrasp::cli

namespace rangegrasp {

void RegisterRecognition() {
  experiment::AddKind(bring::BringTask());
  experiment::AddKind(recognition::RecognitionTask());
  trial::KeyReaders().push_back([](base::YamlMap& map, trial::Options& options) {
    views::ReadWristViewOptions(map,
                                trial::Of<views::WristViewOptions>(options, views::kWristViews));
  });
  trial::FileLists().push_back([](const trial::Options& options) {
    const auto wrist = trial::Of<views::WristViewOptions>(options, views::kWristViews);
    std::vector<std::filesystem::path> files = {wrist.sensor, wrist.hand_eye};
    std::erase(files, std::filesystem::path());
    return files;
  });
  trial::FurtherLooking() = trial::FurtherLooks{
      .wanted =
          [](const trial::Options& options) {
            return trial::Of<views::WristViewOptions>(options, views::kWristViews).views > 1;
          },
      .look = views::AddWristViews};
  cli::AddCommand(cli::AddBringCommand);
  cli::AddCommand(cli::AddLearnCommand);
  cli::AddCommand(cli::AddRecognizeCommand);
}

}  // namespace rangegrasp
