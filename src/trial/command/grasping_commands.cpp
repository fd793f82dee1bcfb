#include "trial/command/grasping_commands.h"

#include <fmt/format.h>
#include <spawn.h>
#include <spdlog/spdlog.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/file.h"
#include "base/image/image.h"
#include "base/installation.h"
#include "base/process/program.h"
#include "base/stopwatch.h"
#include "base/units.h"
#include "base/words.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "experiment/store.h"
#include "geometry/cloud_file.h"
#include "geometry/draw/canvas.h"
#include "grasp/named_grasps.h"
#include "sensing/line_scanner.h"
#include "sensing/range_sensor.h"
#include "sim/bodies.h"
#include "sim/check/check.h"
#include "sim/check/fix.h"
#include "sim/render.h"
#include "trial/cell.h"
#include "trial/grasping_task.h"
#include "trial/registry.h"
#include "trial/trial.h"
#include "trial/tryout.h"

namespace rangegrasp::cli {
namespace {

namespace fs = std::filesystem;
using Findings = std::vector<base::Finding>;

struct CheckArguments {
  std::string file;
  std::string as;
  std::string detector;
  std::string fix;  // "", "copy", "in-place"
  std::vector<std::string> set;
  bool json = false, quick = false;
};

// Prints the detector's answers on a few scans.
// @throws base::InputError if one is wrong
void CheckDetectorOf(const experiment::Experiment& e, bool quiet = false) {
  const auto& cell = trial::CellOf(*e.task);
  const auto* detector = trial::FindDetector(cell.options.detector);
  if (!detector->check_answers) return;
  std::string text;
  const bool usable = detector->check_answers(cell, text);
  if (!quiet) WriteResult(text);
  if (!usable) throw base::InputError("the detector has errors");
}

// Checks a detector given by its command, in the shipped experiment.
void CheckDetectorAlone(const CheckArguments& arguments) {
  std::vector<std::string> words = base::Split(arguments.detector, ' ');
  std::erase(words, "");
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (fs::exists(words[i])) {
      words[i] = std::filesystem::absolute(words[i]).string();
    } else if (words[i].ends_with(".py")) {
      throw base::InputError("--detector: no file '" + words[i] + "'");
    }
  }
  if (!words.empty()) {
    std::string& program = words.front();
    if (program.find('/') != std::string::npos) {
      program = std::filesystem::absolute(program).string();
    } else if (fs::exists(program)) {  // as in an experiment, a bare name is searched in PATH
      throw base::InputError("--detector: '" + program +
                             "' would be a program on the PATH; give ./" + program);
    }
  }
  experiment::Changes changes{.set = arguments.set};
  changes.set.insert(changes.set.begin(),
                     "detector={command: " + nlohmann::json(words).dump() + "}");
  CheckDetectorOf(experiment::OpenExperiment(base::FindExperiment("laser_single"), changes));
}

bool IsExperiment(const fs::path& file) {
  return file.extension() == ".yaml" || file.extension() == ".yml";
}

// A checked file and the results.
struct Checked {
  std::string kind;
  Findings findings;
  std::optional<trial::Tryout> tried;
  std::vector<check::Change> changes;  // of --fix

  void Add(const Findings& more) {
    findings.insert(findings.end(), more.begin(), more.end());
    std::ranges::stable_partition(findings, &base::Finding::error);
  }

  // Tries the cell if there are no errors.
  void Try(const CheckArguments& arguments, const trial::Options& options) {
    if (arguments.quick || base::HasError(findings)) return;
    tried = trial::TryCell(options, [](const std::string& text) { spdlog::info(text); });
    Add(tried->findings);
  }
};

// Checks the known grasps next to an object's file, with their places if the object has no errors.
void CheckKnownGrasps(const fs::path& mjcf, Findings& findings) {
  try {
    const auto file = grasp::NamedGraspsFile(mjcf);
    const auto known = grasp::ReadNamedGrasps(file);
    if (known.grasps.empty() || base::HasError(findings)) return;
    const auto points_O = sim::ObjectSurface({mjcf.stem().string(), mjcf}).mesh.vertices;
    std::ranges::move(grasp::CheckNamedGrasps(known, file, points_O), std::back_inserter(findings));
  } catch (const base::InputError& error) {
    findings.push_back({true, mjcf.string(), "known grasps", error.what(), ""});
  }
}

Checked CheckFile(const CheckArguments& arguments) {
  Checked checked;
  const fs::path file = arguments.file;
  if (IsExperiment(file)) {
    checked.kind = "experiment";
    const auto e =
        experiment::OpenExperiment(file, {.set = arguments.set}, [&](const Findings& found) {
          checked.findings.insert(checked.findings.end(), found.begin(), found.end());
          return !base::HasError(found);
        });
    if (const auto* scene = dynamic_cast<const trial::SceneTask*>(e.task.get())) {
      checked.Add(trial::CheckSight(scene->cell()));
    }
    if (base::HasError(checked.findings)) return checked;
    if (e.task && e.kind->name == "grasping") {
      CheckDetectorOf(e, arguments.json);
      checked.Try(arguments, trial::CellOf(*e.task).options);
    }
    return checked;
  }
  const check::Kind what = arguments.as.empty() ? check::KindOf(file)
                                                : base::FromWord<check::Kind>(arguments.as, "--as");
  checked.kind = base::Word(what);
  checked.findings = what == check::Kind::kObject ? check::CheckObject({file.stem().string(), file})
                                                  : check::CheckModel(file, what);
  if (what == check::Kind::kScene) {
    const trial::Options options = trial::OptionsOf(file);
    if (!base::HasError(checked.findings)) checked.Add(trial::CheckSight(trial::Cell(options)));
    checked.Try(arguments, options);
  }
  if (what == check::Kind::kObject) CheckKnownGrasps(file, checked.findings);
  return checked;
}

// Applies the definite edits and checks again until there are none. `file` is then the copy.
Checked FixFile(CheckArguments& arguments) {
  if (arguments.file.empty() || IsExperiment(arguments.file)) {
    throw base::InputError("--fix needs an MJCF file, such as the scene of an experiment");
  }
  if (arguments.fix != "copy" && arguments.fix != "in-place") {
    throw base::InputError("--fix '" + arguments.fix + "' must be copy or in-place");
  }
  check::Fixer fixer(arguments.file, arguments.fix == "in-place");
  Checked checked = CheckFile(arguments);
  arguments.as = checked.kind;
  fixer.Run(checked.findings, [&] {
    arguments.file = fixer.file().string();
    checked = CheckFile(arguments);
    return checked.findings;
  });
  checked.changes = fixer.changes();
  return checked;
}

// A change as a diff.
std::string TextOf(const check::Change& change) {
  std::string text = fmt::format("{}:{}:\n", change.file.string(), change.line);
  const auto add = [&](char sign, const std::string& lines) {
    if (lines.empty()) return;
    for (const std::string& line : base::Split(lines, '\n')) {
      text += fmt::format("    {} {}\n", sign, line);
    }
  };
  add('-', change.before);
  add('+', change.after);
  return text;
}

std::string JsonOf(const std::string& file, const Checked& checked) {
  nlohmann::ordered_json json = {
      {"file", file}, {"kind", checked.kind}, {"findings", nlohmann::ordered_json::array()}};
  if (checked.tried) {
    json["tried"] = {{"trials", checked.tried->trials},
                     {"detected", checked.tried->detected},
                     {"delivered", checked.tried->delivered}};
  }
  for (const base::Finding& f : checked.findings) {
    json["findings"].push_back({{"severity", f.error ? "error" : "warning"},
                                {"where", f.where},
                                {"element", f.element},
                                {"what", f.what},
                                {"cure", base::CureOf(f)}});
  }
  for (const check::Change& c : checked.changes) {
    json["edits"].push_back(
        {{"file", c.file.string()}, {"line", c.line}, {"before", c.before}, {"after", c.after}});
  }
  return json.dump(2) + "\n";
}

void Check(CheckArguments arguments) {
  if (arguments.file.empty() == arguments.detector.empty()) {
    throw base::InputError("check needs either a file or --detector");
  }
  if (!arguments.detector.empty()) return CheckDetectorAlone(arguments);
  const std::string ending = base::EndingOf(arguments.file);
  if (!ending.empty() && ending != ".xml" && ending != ".yaml" && ending != ".yml") {
    throw base::InputError(arguments.file +
                           ": check takes MJCF (.xml) and experiments (.yaml); a detector needs "
                           "--detector, a mesh `rangegrasp add-object`");
  }
  const Checked checked = arguments.fix.empty() ? CheckFile(arguments) : FixFile(arguments);
  const Findings& findings = checked.findings;
  const auto errors = std::ranges::count(findings, true, &base::Finding::error);
  const auto warnings = static_cast<std::ptrdiff_t>(findings.size()) - errors;
  if (arguments.json) {
    WriteResult(JsonOf(arguments.file, checked));
  } else {
    std::string text;
    for (const check::Change& change : checked.changes) text += TextOf(change);
    for (const base::Finding& finding : findings) text += base::TextOf(finding) + "\n";
    if (checked.tried) text += checked.tried->Text() + " (generated objects, built-in detector)\n";
    text += fmt::format("{}, checked as {} {}: {}\n", arguments.file,
                        checked.kind.find_first_of("aeo") == 0 ? "an" : "a", checked.kind,
                        findings.empty() ? std::string("no errors")
                                         : base::Counted(errors, "error") + ", " +
                                               base::Counted(warnings, "warning"));
    if (!checked.changes.empty()) text += fmt::format("edits made: {}\n", checked.changes.size());
    WriteResult(text);
  }
  if (errors > 0) throw base::InputError(fmt::format("{}: has errors", arguments.file));
}

// What snapshot, view and scan show.
struct PickArguments {
  std::string file, trial;
  experiment::Changes changes;
};

void AddSetOption(CLI::App& command, std::vector<std::string>& set) {
  command.add_option("--set", set, "KEY=VALUE of an experiment, as for run")
      ->allow_extra_args(false);
}

void AddPickOptions(CLI::App& command, PickArguments& arguments) {
  command.add_option("--trial", arguments.trial,
                     "id of a trial of the experiment (default: its first)");
  command.add_option("--seed", arguments.changes.seed, "overrides the seed of the experiment")
      ->transform(WholeNumber());
  AddSetOption(command, arguments.changes.set);
}

// Refuses results, and options of an experiment for another file.
void CheckPickable(const PickArguments& arguments) {
  const fs::path store = experiment::StoresIn(arguments.file).front();
  if (experiment::Store::Exists(store)) {
    throw base::InputError(fmt::format(
        "{0}: is a results folder; `rangegrasp trial {0} ID --snapshots` draws its trials",
        store.string()));
  }
  if (IsExperiment(arguments.file)) return;
  for (const auto& [option, given] : {std::pair{"--trial", !arguments.trial.empty()},
                                      {"--set", !arguments.changes.set.empty()}}) {
    if (!given) continue;
    throw base::InputError(
        fmt::format("{} needs an experiment file, but {} is none", option, arguments.file));
  }
}

// The settled world of an experiment's trial, or the unchanged world of a scene file.
struct Picked {
  std::unique_ptr<sim::World> world;
  experiment::Experiment experiment;       // empty for a scene
  const trial::SceneTask* task = nullptr;  // of the experiment
  std::uint64_t seed = 1;
  int target = 0;  // of the trial

  const trial::Cell& cell() const { return task->cell(); }
};

// The arm's joints at home in a scene. A hand or an arm alone lacks names of a scene.
Eigen::VectorXd HomeIn(const fs::path& file) {
  try {
    return robot::Robot::Load(file).home;
  } catch (const base::InputError& error) {
    const check::Kind kind = check::KindOf(file);
    if (kind != check::Kind::kHand && kind != check::Kind::kArm) throw;
    throw base::InputError(
        fmt::format("{}: it is neither a scene nor an object; to draw {}, give the scene that "
                    "attaches it",
                    error.what(), kind == check::Kind::kHand ? "a hand" : "an arm"));
  }
}

Picked PickScene(const fs::path& file, std::optional<std::uint64_t> seed) {
  Picked picked;
  picked.world =
      std::make_unique<sim::World>(file, std::vector<sim::ObjectModel>{}, sim::PhysicsOptions{});
  picked.world->SetArm(HomeIn(file));
  picked.world->Settle();
  picked.seed = seed.value_or(picked.seed);
  return picked;
}

// The path of a sensor's file; "laser" and "stereo" are installed ones.
fs::path SensorFile(const std::string& sensor) {
  if (sensor == "laser") return base::DataFolder() / "models/sensors/line_scanner.yaml";
  if (sensor == "stereo") return base::DataFolder() / "models/sensors/stereo_camera.yaml";
  if (!fs::is_regular_file(sensor)) {
    throw base::InputError(
        fmt::format("--sensor: no file '{}'; give laser, stereo or a sensor file (YAML)", sensor));
  }
  return fs::absolute(sensor);
}

constexpr const char* kNeedsLaser = "--picture and --target-only need a line scanner";

// @param by_laser  the trial's sensor must be one that writes no images of its own
Picked PickTrial(const PickArguments& arguments, const std::string& sensor, bool by_laser) {
  Picked picked;
  const auto& [file, trial, given] = arguments;
  experiment::Changes changes = given;
  if (!sensor.empty()) {
    const std::string path = SensorFile(sensor).string();
    changes.set.push_back("sensor=" + nlohmann::json(path).dump());  // which is YAML
  }
  picked.experiment = experiment::OpenExperiment(file, changes);
  picked.task = dynamic_cast<const trial::SceneTask*>(picked.experiment.task.get());
  if (!picked.task) {
    throw base::InputError(fmt::format(
        "{}: has no scene that can be shown (`task: {}`); give an experiment that arranges objects "
        "and shows them, such as one of `task: grasping`, or a scene (MJCF)",
        file, picked.experiment.kind->name));
  }
  if (by_laser && picked.cell().sensor->WritesLook()) throw base::InputError(kNeedsLaser);
  picked.cell().sensor->Prepare();  // before the world is made, since its engine starts threads
  const experiment::Case& which =
      trial.empty() ? picked.experiment.cases.front() : CaseOf(picked.experiment, trial);
  picked.seed = which.seed;
  trial::Redraws redraws;
  auto arranged = picked.task->Arrange(which, redraws);
  if (!arranged) {
    throw base::RunError(fmt::format("{}: no arrangement of {} came to rest in view: {}", file,
                                     which.id, trial::Text(redraws)));
  }
  picked.target = arranged->target;
  picked.world = std::make_unique<sim::World>(std::move(arranged->world));
  return picked;
}

Picked Pick(const PickArguments& arguments, const std::string& sensor = "", bool by_laser = false) {
  CheckPickable(arguments);
  if (IsExperiment(arguments.file)) return PickTrial(arguments, sensor, by_laser);
  return PickScene(arguments.file, arguments.changes.seed);
}

struct SnapshotArguments : PickArguments {
  std::string out, camera, size = "1280x960";
};

// The named file, or a new one in results/ with the name of the drawn file and trial.
fs::path PictureFile(const SnapshotArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  const std::string of_trial = arguments.trial.empty() ? "" : "_" + arguments.trial;
  const auto name = fs::path(arguments.file).stem().string() + of_trial + ".png";
  const fs::path file = fs::path("results") / name;
  if (fs::exists(file)) {  // it may show another view
    throw base::InputError(fmt::format("{0}: already exists; -o {0} replaces it", file.string()));
  }
  return file;
}

image::Image DrawSnapshot(const SnapshotArguments& arguments) {
  CheckPickable(arguments);
  const auto [width, height] = ParseSize(arguments.size);
  const fs::path file = arguments.file;
  if (!IsExperiment(file) && check::IsObjectFile(file)) {
    return sim::DrawObject({file.stem().string(), file}, arguments.camera, width, height);
  }
  const Picked picked = Pick(arguments);
  const std::string camera = arguments.camera.empty() ? "overview" : arguments.camera;
  return sim::Renderer(*picked.world, width, height).Render(*picked.world, camera);
}

void AddSnapshot(CLI::App& app) {
  auto* command = app.add_subcommand(
      "snapshot", "Draw a scene, an object, or the start of an experiment's trial as PNG.");
  auto arguments = std::make_shared<SnapshotArguments>();
  command->add_option("file", arguments->file, "scene or object (MJCF) or experiment (YAML)")
      ->required();
  command->add_option("-o,--out", arguments->out,
                      "PNG file (default: results/<name of the file>[_<trial>].png, if there is "
                      "none yet)");
  command->add_option("--camera", arguments->camera,
                      "camera of the scene, or a free view x,y,z,lookx,looky,lookz [m] (default: "
                      "overview; for an object, a close view)");
  command->add_option("--size", arguments->size, "size, WIDTHxHEIGHT in pixels");
  AddPickOptions(*command, *arguments);
  command->footer(
      "Example: rangegrasp snapshot scenes/tabletop.xml -o table.png --camera overview");
  command->callback([arguments] {
    const fs::path picture = PictureFile(*arguments);
    CheckEnding(picture, {".png"});
    image::WritePng(picture, DrawSnapshot(*arguments));
    spdlog::info("picture in {}", picture.string());
  });
}

// Runs MuJoCo's viewer on FOLDER/model.mjb and FOLDER/state.bin.
constexpr const char* kViewer = R"(
import sys
try:
    import mujoco.viewer, numpy
except ImportError as error:
    sys.exit(f"view: {error}; the viewer is part of MuJoCo's Python package: pip install mujoco=={sys.argv[2]}")
model = mujoco.MjModel.from_binary_path(sys.argv[1] + "/model.mjb")
data = mujoco.MjData(model)
mujoco.mj_setState(model, data, numpy.fromfile(sys.argv[1] + "/state.bin"), mujoco.mjtState.mjSTATE_INTEGRATION)
mujoco.mj_forward(model, data)
mujoco.viewer.launch(model, data)
)";

void View(const PickArguments& arguments) {
  const bool display = std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY");
  if (!display) {
    throw base::InputError(
        fmt::format("view needs a display, but neither DISPLAY nor WAYLAND_DISPLAY is set; for a "
                    "picture: rangegrasp snapshot {}{} -o picture.png",
                    arguments.file, arguments.trial.empty() ? "" : " --trial " + arguments.trial));
  }
  const auto python = process::Find("python3");
  if (!python) throw base::InputError("view needs python3 with MuJoCo's Python package");
  const Picked picked = Pick(arguments);
  const process::OwnFolder folder;
  sim::WriteModelAndState(*picked.world, folder.path());
  std::vector<std::string> words = {python->string(), "-c", kViewer, folder.path().string(),
                                    sim::EngineVersion()};
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t viewer = 0;
  int status = 0;
  if (posix_spawn(&viewer, argv[0], nullptr, nullptr, argv.data(), environ) != 0 ||
      waitpid(viewer, &status, 0) < 0 || status != 0) {
    throw base::RunError("the viewer failed");
  }
}

void AddView(CLI::App& app) {
  auto* command = app.add_subcommand(
      "view", "Open a scene, or the start of an experiment's trial, in MuJoCo's viewer.");
  auto arguments = std::make_shared<PickArguments>();
  command->add_option("file", arguments->file, "scene (MJCF) or experiment (YAML)")->required();
  AddPickOptions(*command, *arguments);
  command->footer("Example: rangegrasp view experiments/laser_pile.yaml --trial spread-0002");
  command->callback([arguments] { View(*arguments); });
}

/// The image with the samples of the target only.
/// @param target  its label
geometry::RangeImage TargetOnly(const sensing::Scan& scan, std::uint32_t target) {
  geometry::RangeImage image = scan.view.image;
  for (std::size_t i = 0; i < image.points_C.size(); ++i) {
    if (scan.truth.label[i] != target) {
      image.points_C[i].setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return image;
}

/// Draws the scan, with different colors for objects and table, and the shadows on the table plane
/// around the workspace.
image::Image DrawScan(const sensing::Scan& scan, const std::vector<sim::VisualMesh>& meshes,
                      const base::Pose& X_WS, const sensing::LineScannerOptions& options) {
  constexpr double kHalf_m = 0.30;
  constexpr double kStep_m = 0.0015;
  geometry::Points grid;
  for (double x = -kHalf_m; x <= kHalf_m; x += kStep_m) {
    for (double y = -kHalf_m; y <= kHalf_m; y += kStep_m)
      grid.emplace_back(x, y, 0.001);  // above the markings painted on the table
  }
  const auto states = sensing::ClassifySurface(grid, meshes, X_WS, options);
  draw::Canvas canvas;
  const auto add = [&](sensing::SurfaceState state, const draw::Color& color) {
    geometry::Points chosen;
    for (std::size_t i = 0; i < grid.size(); ++i) {
      if (states[i] == state) chosen.push_back(grid[i]);
    }
    canvas.dots.push_back({std::move(chosen), color, 3.0F});
  };
  add(sensing::SurfaceState::kLaserShadow, {0.90F, 0.25F, 0.20F, 1.0F});
  add(sensing::SurfaceState::kCameraShadow, {0.95F, 0.75F, 0.15F, 1.0F});
  add(sensing::SurfaceState::kBothShadows, {0.35F, 0.15F, 0.15F, 1.0F});
  geometry::Points scene, target;
  for (std::size_t i = 0; i < scan.view.image.points_C.size(); ++i) {
    const Eigen::Vector3d& p = scan.view.image.points_C[i];
    if (!p.allFinite() || p.head<2>().norm() > 1.5 * kHalf_m) continue;
    (scan.truth.label[i] == 0 ? scene : target).push_back(p);
  }
  canvas.dots.push_back({std::move(scene), {0.45F, 0.58F, 0.80F, 1.0F}, 1.5F});
  canvas.dots.push_back({std::move(target), {0.10F, 0.45F, 0.20F, 1.0F}, 2.5F});
  const draw::View view{{0.75, -0.35, 0.75}, {-0.02, 0.0, 0.0}, Eigen::Vector3d::UnitZ(), 0.55};
  return draw::Render(canvas, view, 1280, 960);
}

struct ScanArguments : PickArguments {
  std::string out, sensor, picture;
  bool target_only = false;
};

// Lets the sensor write the cloud and its images.
// @return false if it does not do that
bool WriteItsLook(const Picked& picked, const std::string& cloud) {
  if (!picked.experiment.task || !picked.cell().sensor->WritesLook()) return false;
  base::Rng rng = trial::StageStream(picked.seed, "scan");
  spdlog::info(picked.cell().sensor->WriteLook(*picked.world, rng, cloud));
  return true;
}

void AddScan(CLI::App& app) {
  auto* command = app.add_subcommand(
      "scan",
      "Simulate one scan and write it as a cloud with labels: an organised PCD, or a PLY of the "
      "measured points.");
  auto arguments = std::make_shared<ScanArguments>();
  command->add_option("file", arguments->file, "experiment (YAML) or scene (MJCF)")->required();
  command->add_option("-o,--out", arguments->out, "output cloud, .pcd or .ply")->required();
  AddPickOptions(*command, *arguments);
  command->add_option("--picture", arguments->picture, "PNG file of the cloud and both shadows");
  command->add_option("--sensor", arguments->sensor,
                      "laser, stereo, or a sensor file (YAML), instead of the experiment's; for a "
                      "scene, the file of a line scanner or depth camera");
  command->add_flag("--target-only", arguments->target_only,
                    "experiments only: write only the target's points, e.g. for rangegrasp parts");
  command->footer(
      "Example: rangegrasp scan experiments/laser_single.yaml --trial coffee_cup-0000 -o "
      "mug.pcd\nFields: x y z [m], label (0 scene, 1 target, in a heap the topmost object, 2 and "
      "up other objects, 1000 an open "
      "box), state (0 measured, 1 camera shadow, 2 dropout, 3 out of view; in a PLY always 0), and "
      "rgb with `color: true`.\n--picture draws the shadows that the objects cast on the table: "
      "laser red, camera "
      "yellow, both dark.\nFor a stereo camera, a folder next to the cloud contains left.png, "
      "right.png, disparity.png and calibration.yaml, in the "
      "format that rangegrasp stereo reads. For a depth camera, the images are NAME_depth.png (16 "
      "bits, 0.1 mm per level) and NAME_color.png.");
  command->callback([arguments] {
    CheckEnding(arguments->out, {".pcd", ".ply"});
    if (!arguments->picture.empty()) CheckEnding(arguments->picture, {".png"});
    const bool by_laser = arguments->target_only || !arguments->picture.empty();
    Picked picked = Pick(*arguments, arguments->sensor, by_laser);
    if (WriteItsLook(picked, arguments->out)) return;
    const sensing::RangeSensor sensor =
        picked.experiment.task      ? picked.cell().scanner
        : arguments->sensor.empty() ? sensing::LineScannerOptions{}
                                    : sensing::ReadRangeSensor(SensorFile(arguments->sensor));
    if (!arguments->picture.empty() &&
        !std::holds_alternative<sensing::LineScannerOptions>(sensor)) {
      throw base::InputError(kNeedsLaser);
    }
    if (arguments->target_only && !picked.experiment.task) {
      throw base::InputError("--target-only: a scene has no target; give an experiment");
    }
    const auto meshes = picked.world->VisualMeshes();
    const base::Pose X_WS = sensing::PoseIn(*picked.world, sensor);
    base::Rng rng(base::DeriveSeed(picked.seed, "scan"));
    base::Stopwatch watch;
    const sensing::Scan scan = sensing::ScanScene(meshes, X_WS, sensor, rng);
    const double seconds = watch.Seconds();
    const auto target = static_cast<std::uint32_t>(picked.target) + 1;
    geometry::WriteCloud(arguments->out,
                         arguments->target_only ? TargetOnly(scan, target) : scan.view.image,
                         trial::TruthFields(scan.view, scan.truth));
    if (!arguments->picture.empty()) {
      image::WritePng(arguments->picture,
                      DrawScan(scan, meshes, X_WS, std::get<sensing::LineScannerOptions>(sensor)));
    }
    const auto measured = std::ranges::count(scan.truth.state, sensing::SampleState::kMeasured);
    spdlog::info("{} in {} of {}, {:.0f} ms", base::Counted(measured, "point"),
                 base::Counted(scan.view.image.profiles, "profile"),
                 base::Counted(scan.view.image.samples, "sample"), seconds * 1e3);
  });
}

}  // namespace

void AddCheckCommand(CLI::App& app) {
  auto* command =
      app.add_subcommand("check",
                         "Check a scene, an arm, a hand, an object (MJCF), an experiment (YAML) or "
                         "your own detector for errors, and print how to correct each.");
  auto a = std::make_shared<CheckArguments>();
  command->add_option("file", a->file, "MJCF or experiment file");
  command->add_option("--as", a->as, "type of an MJCF file (default: from its content)")
      ->check(CLI::IsMember(base::WordList<check::Kind>()));
  command->add_option("--detector", a->detector,
                      "check your own grasp detector on a few scans instead of a file, e.g. "
                      "\"python3 my_detector.py\"");
  AddSetOption(*command, a->set);
  command->add_flag("--fix{copy}", a->fix,
                    "apply the unambiguous fixes to a copy, NAME.fixed.xml next to the file (also "
                    "to copies of files that it includes or attaches), and check the copy; "
                    "--fix=in-place changes the files and keeps the originals as FILE.bak");
  command->add_flag("--json", a->json, "print the findings as JSON");
  command->add_flag("--quick", a->quick,
                    "skip the trials: by default, a scene or experiment without errors is also "
                    "tried on generated boxes, cylinders and balls, which takes about 10 s");
  for (const char* of_a_file : {"--as", "--fix", "--json", "--quick"}) {
    command->get_option(of_a_file)->excludes("--detector");
  }
  command->footer(
      "Examples:\n  rangegrasp check scenes/tabletop.xml\n  rangegrasp check --fix my_hand.xml\n"
      "Exit codes: 0 no errors, 2 errors. `run` does the same check, without trials, before its "
      "first trial.");
  command->callback([a] { Check(*a); });
}

void AddPictureCommands(CLI::App& app) {
  AddSnapshot(app);
  AddView(app);
  AddScan(app);
}

}  // namespace rangegrasp::cli
