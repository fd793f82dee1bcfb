#include "trial/command/perceive_command.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/error.h"
#include "base/file.h"
#include "base/image/image.h"
#include "base/installation.h"
#include "base/pattern.h"
#include "base/units.h"
#include "base/words.h"
#include "cli/output.h"
#include "geometry/mesh_file.h"
#include "grasp/grasp.h"
#include "grasp/scene_view.h"
#include "perception/doubts.h"
#include "perception/perceive.h"
#include "perception/preprocess.h"
#include "robot/robot.h"

namespace rangegrasp::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

using GraspLists = std::vector<std::vector<grasp::Grasp>>;  // one list per object

double UnitFrom(const std::string& name) {
  if (name == "mm") return 1e-3;
  if (name == "cm") return 1e-2;
  return 1.0;
}

// Parses "x,y,z" into a vector. @throws base::InputError naming the option.
Eigen::Vector3d ParseVector(const std::string& text, const char* option) {
  double x = 0.0, y = 0.0, z = 0.0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &x, &y, &z, &rest) != 3 ||
      !std::isfinite(x + y + z)) {
    throw base::InputError(std::string(option) + " '" + text + "' must be x,y,z, e.g. 0,0,1");
  }
  return {x, y, z};
}

struct PerceiveArguments : CloudArguments {
  std::string out, segmentation = "convexity";
  std::string scene;
  std::optional<double> noise_mm;
  std::uint64_t seed = 1;
  bool json = false;
};

perception::PerceptionOptions OptionsFor(const PerceiveArguments& arguments) {
  perception::PerceptionOptions options;
  options.segment.method =
      base::FromWord<perception::SegmentMethod>(arguments.segmentation, "--segmentation");
  if (arguments.noise_mm) options.noise_m = *arguments.noise_mm * base::kMm;
  options.preprocess.up_C = UpOf(arguments);
  return options;
}

// What a user can do about a doubt, by the options of a command that reads a cloud.
perception::Cures CommandCures() {
  return {.smaller_unit = "try --unit mm",
          .larger_unit = "try --unit m",
          .sensor = "its position (--sensor-origin) must be in metres",
          .upper_side = "give --sensor-origin or --up",
          .other_things = "try --crop or --up",
          .noise = "give --noise-mm"};
}

// Warning if points this far apart (perception::Sampling) are not those of a tabletop, so that the
// file has another unit; else empty.
std::string UnitWarning(double spacing_m) {
  return perception::DoubtOfUnit(spacing_m, CommandCures());
}

// Warning if neither the option nor the file states the sensor's position; else empty.
std::string OriginWarning(const CloudArguments& arguments, const geometry::CloudFile& file) {
  if (!arguments.origin.empty() || file.sensor_origin) return "";
  return "the file has no viewpoint: the sensor is assumed at 0,0,0 (--sensor-origin x,y,z)";
}

ordered_json Json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ordered_json JsonOfRows(const Eigen::MatrixXd& m) {
  ordered_json rows = ordered_json::array();
  for (const auto& row : m.rowwise()) rows.push_back(std::vector<double>(row.begin(), row.end()));
  return rows;
}

// The keys of a detector's answer (docs/bring-your-own-detector.md), and more.
ordered_json Json(const grasp::Grasp& grasp) {
  return {{"type", base::Word(grasp.type)},
          {"position_m", Json(grasp.X_CG.translation())},
          {"rotation", JsonOfRows(grasp.X_CG.linear())},
          {"width_m", grasp.width_m},
          {"opening_m", grasp.opening_m},
          {"X_CH", JsonOfRows(grasp.X_CH.matrix())},
          {"score", grasp.score},
          {"collides", grasp.collides}};
}

ordered_json Json(const PerceiveArguments& arguments, const perception::Scene& scene,
                  const GraspLists& grasps, const std::vector<std::string>& warnings) {
  const auto& table = scene.table;
  ordered_json json = {{"cloud", arguments.cloud},
                       {"unit", arguments.unit},
                       {"frame", "cloud"},  // of all positions [m] and directions below
                       {"noise_m", scene.sampling.noise_m},
                       {"spacing_m", scene.sampling.spacing_m},
                       {"gap_m", scene.sampling.gap_m},
                       {"table",
                        {{"normal", Json(table.plane.normal)},
                         {"offset_m", table.plane.offset_m},
                         {"points", table.points.size()}}},
                       {"objects", ordered_json::array()}};
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const auto& object = scene.objects[i];
    ordered_json item = {{"points", object.points.size()},
                         {"kind", base::Word(object.kind)},
                         {"open", object.open},
                         {"center_m", Json(object.center_C)},
                         {"size_m", Json(object.size_m)},
                         {"height_m", object.height_m},
                         {"grasps", ordered_json::array()}};
    for (const auto& grasp : grasps[i]) item["grasps"].push_back(Json(grasp));
    json["objects"].push_back(item);
  }
  json["warnings"] = warnings;
  json["seconds"] = ordered_json::object();
  for (const auto& [step, seconds] : scene.seconds) json["seconds"][step] = seconds;
  return json;
}

std::string Text(const perception::Scene& scene, const GraspLists& grasps) {
  const auto& n = scene.table.plane.normal;
  std::string text =
      fmt::format("noise {:.2f} mm, points {:.2f} mm apart\n",
                  scene.sampling.noise_m * base::kMmPerM, scene.sampling.spacing_m * base::kMmPerM);
  text += fmt::format("table: {}, normal ({:.3f}, {:.3f}, {:.3f}), offset {:.4f} m\n",
                      base::Counted(scene.table.points.size(), "point"), n.x(), n.y(), n.z(),
                      scene.table.plane.offset_m);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const auto& object = scene.objects[i];
    const auto free = std::ranges::count(grasps[i], false, &grasp::Grasp::collides);
    text += fmt::format("object {}: {}, {}{}, {:.0f} x {:.0f} x {:.0f} mm, {}, {} free", i + 1,
                        base::Counted(object.points.size(), "point"), base::Word(object.kind),
                        object.open ? ", open" : "", object.size_m.x() * base::kMmPerM,
                        object.size_m.y() * base::kMmPerM, object.size_m.z() * base::kMmPerM,
                        base::Counted(grasps[i].size(), "grasp"), free);
    if (free > 0) text += fmt::format(", best: {}", base::Word(grasps[i].front().type));
    text += "\n";
  }
  return text;
}

// Writes the measured points of one object as a gray cloud.
void WriteObject(const perception::Scene& scene, std::size_t object, const fs::path& file) {
  const auto& points = scene.objects[object].points;
  const geometry::TriangleMesh cloud{geometry::Select(scene.cloud.points, points), {}};
  geometry::WriteColoredPly(
      file, cloud,
      std::vector<std::array<std::uint8_t, 3>>(cloud.vertices.size(), {160, 160, 160}));
}

bool IsObjectsCloud(const fs::path& file) {
  return base::FindMatch(file.filename().string(), R"(^object_[0-9]+\.ply$)").has_value();
}

// Removes the clouds of objects of an earlier run, which may have found more of them.
void RemoveObjects(const fs::path& folder) {
  std::vector<fs::path> old;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file() && IsObjectsCloud(entry.path())) old.push_back(entry.path());
  }
  for (const fs::path& file : old) fs::remove(file);
}

// Results that are printed for a cloud.
struct Perceived {
  ordered_json json;
  std::string text;
  std::vector<std::string> warnings;
  std::string error = {};  // why the results above are missing; empty if they are not
};

// The renderer can draw only one picture at a time.
void Draw(const fs::path& file, const draw::Canvas& canvas, const draw::View& view) {
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  image::WritePng(file, draw::Render(canvas, view, 1280, 960));
}

Perceived Perceive(const PerceiveArguments& arguments, const robot::HandModel& hand) {
  const fs::path cloud(arguments.cloud);
  if (!arguments.out.empty() && IsObjectsCloud(cloud)) {
    RefuseOverwriting(cloud, fs::path(arguments.out) / cloud.filename());
  }
  const auto file = ReadCloud(arguments);
  const geometry::Points points = MeasuredPoints(file);
  const Eigen::Vector3d origin = OriginOf(arguments, file);
  const auto options = OptionsFor(arguments);
  base::Rng rng(arguments.seed);
  perception::Scene scene;
  try {
    scene = perception::Perceive(points, origin, options, rng);
  } catch (const base::InputError& e) {
    throw base::InputError(arguments.cloud + ": " + e.what() +
                           TableAdvice(points, origin, options, rng) +
                           OriginAdvice(arguments, origin));
  }
  GraspLists grasps;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    grasps.push_back(grasp::PlanGrasps(scene, i, hand,
                                       grasp::Arm(2.0 * scene.objects[i].center_C - origin),
                                       grasp::GraspOptions{}));
  }
  std::vector<std::string> warnings = file.warnings;
  std::ranges::move(perception::Doubts(scene, origin, OriginWarning(arguments, file),
                                       options.noise_m.has_value(), CommandCures()),
                    std::back_inserter(warnings));
  const Perceived perceived{Json(arguments, scene, grasps, warnings), Text(scene, grasps),
                            warnings};
  if (arguments.out.empty()) return perceived;
  const fs::path folder(arguments.out);
  WriteResult(perceived.json.dump(2) + "\n", folder / "perceived.json");
  RemoveObjects(folder);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    WriteObject(scene, i, folder / fmt::format("object_{}.ply", i + 1));
  }
  Draw(folder / "perceived.png", draw::DrawScene(points, scene, grasps, hand),
       draw::LookAtScene(scene, origin));
  return perceived;
}

robot::HandModel HandOf(const std::string& scene) {
  const auto file = scene.empty() ? base::DataFolder() / "scenes/tabletop.xml" : fs::path(scene);
  return robot::Robot::Load(file).hand();
}

void PrintWarnings(const std::string& cloud, const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) spdlog::warn("{}: {}", cloud, warning);
}

void PerceiveOne(const PerceiveArguments& arguments) {
  const Perceived perceived = Perceive(arguments, HandOf(arguments.scene));
  PrintWarnings(arguments.cloud, perceived.warnings);
  WriteResult(arguments.json ? perceived.json.dump(2) + "\n" : perceived.text);
  if (!arguments.out.empty()) {
    spdlog::info("picture and clouds of the objects in {}", arguments.out);
  }
}

// ---- several clouds ----

// The named files, and the files of named folders in alphabetical order.
std::vector<std::string> CloudsIn(const std::vector<std::string>& named) {
  constexpr std::array<std::string_view, 4> kEndings = {".pcd", ".ply", ".npy", ".xyz"};
  std::vector<std::string> clouds;
  for (const std::string& name : named) {
    if (!fs::is_directory(name)) {
      clouds.push_back(name);
      continue;
    }
    std::vector<std::string> inside;
    for (const auto& entry : fs::directory_iterator(name)) {
      const std::string ending = base::EndingOf(entry.path());
      if (std::ranges::find(kEndings, ending) != kEndings.end())
        inside.push_back(entry.path().string());
    }
    if (inside.empty()) {
      throw base::InputError(name + ": a folder without a .pcd, .ply, .npy or .xyz file");
    }
    std::ranges::sort(inside);
    std::ranges::move(inside, std::back_inserter(clouds));
  }
  return clouds;
}

// Each cloud has an output folder with its name in the named output folder.
std::vector<PerceiveArguments> ArgumentsOfEach(const PerceiveArguments& all,
                                               const std::vector<std::string>& clouds) {
  std::vector<PerceiveArguments> each;
  std::map<std::string, std::string> cloud_of;
  for (const std::string& cloud : clouds) {
    each.push_back(all);
    each.back().cloud = cloud;
    if (all.out.empty()) continue;
    const std::string stem = std::filesystem::path(cloud).stem().string();
    each.back().out = (fs::path(all.out) / stem).string();
    const auto [other, fresh] = cloud_of.try_emplace(stem, cloud);
    if (fresh) continue;
    throw base::InputError(
        fmt::format("{} and {}: have the same name, so that both would be written to {}; use two "
                    "output folders",
                    other->second, cloud, each.back().out));
  }
  return each;
}

void PrintNext(const PerceiveArguments& arguments, const Perceived& perceived) {
  PrintWarnings(arguments.cloud, perceived.warnings);
  if (!perceived.error.empty()) spdlog::error(perceived.error);
  if (arguments.json) {
    const ordered_json failed = {{"cloud", arguments.cloud}, {"error", perceived.error}};
    // File names in a folder may be invalid UTF-8.
    WriteResult((perceived.error.empty() ? perceived.json : failed)
                    .dump(-1, ' ', false, ordered_json::error_handler_t::replace) +
                "\n");
  } else if (perceived.error.empty()) {
    WriteResult(arguments.cloud + "\n" + perceived.text + "\n");
  }
}

// Processes several clouds in parallel and reports them in their given order. An error in one cloud
// does not stop the others.
void PerceiveAll(const std::vector<PerceiveArguments>& each, int jobs) {
  const robot::HandModel hand = HandOf(each.front().scene);
  std::vector<std::promise<Perceived>> promises(each.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < each.size(); i = next++) {
      Perceived perceived;
      try {
        perceived = Perceive(each[i], hand);
      } catch (const std::exception& e) {
        perceived.error = e.what();
        if (perceived.error.find(each[i].cloud) == std::string::npos) {
          perceived.error = each[i].cloud + ": " + perceived.error;
        }
      }
      promises[i].set_value(std::move(perceived));
    }
  };
  std::vector<std::jthread> threads;
  for (int i = 0; i < jobs; ++i) threads.emplace_back(work);
  std::size_t failed = 0;
  for (std::size_t i = 0; i < each.size(); ++i) {
    const Perceived perceived = promises[i].get_future().get();
    PrintNext(each[i], perceived);
    failed += perceived.error.empty() ? 0 : 1;
  }
  if (failed > 0) {
    throw base::InputError(
        fmt::format("{} of {} clouds could not be perceived", failed, each.size()));
  }
}

}  // namespace

void AddCloudOptions(CLI::App& command, CloudArguments& arguments) {
  command.add_option(
      "--sensor-origin", arguments.origin,
      "x,y,z of the sensor in the cloud's frame [m] (default: the file's viewpoint, else 0,0,0)");
  command
      .add_option("--crop", arguments.crop,
                  "use only points between x,y,z and x,y,z, e.g. -0.3,-0.3,-1,0.3,0.3,1 [m]")
      ->delimiter(',')
      ->expected(6);
  command.add_option("--up", arguments.up, "direction away from the table, if it is known");
  command.add_option("--unit", arguments.unit, "unit of the cloud's coordinates")
      ->check(CLI::IsMember({"m", "cm", "mm"}));
}

Cloud ReadCloud(const CloudArguments& arguments) {
  Cloud file{geometry::ReadCloud(arguments.cloud, UnitFrom(arguments.unit)), {}};
  file.warnings = perception::LeaveOutUnmeasured(OriginOf(arguments, file), file.points);
  if (!arguments.crop.empty()) {
    perception::Crop(arguments.crop, {.name = "--crop", .unit = "another unit: --unit"},
                     std::array{&file.points});
  }
  return file;
}

Eigen::Vector3d OriginOf(const CloudArguments& arguments, const geometry::CloudFile& file) {
  if (!arguments.origin.empty()) return ParseVector(arguments.origin, "--sensor-origin");
  return file.sensor_origin.value_or(Eigen::Vector3d::Zero());
}

void WarnOfCloud(const CloudArguments& arguments, const Cloud& cloud) {
  std::vector<std::string> warnings = cloud.warnings;
  warnings.push_back(OriginWarning(arguments, cloud));
  const geometry::Points points = MeasuredPoints(cloud);
  const std::string of_unit = UnitWarning(perception::MeasureSampling(points, {}).spacing_m);
  warnings.push_back(of_unit);
  if (of_unit.empty()) {
    warnings.push_back(
        perception::DoubtOfDistance(points, OriginOf(arguments, cloud), CommandCures()));
  }
  std::erase(warnings, "");
  PrintWarnings(arguments.cloud, warnings);
}

std::string SideWarning(const geometry::Plane& table, const Eigen::Vector3d& sensor) {
  return perception::DoubtOfSide(table, sensor, CommandCures());
}

geometry::Points MeasuredPoints(const geometry::CloudFile& file) {
  geometry::Points points = file.points;
  std::erase_if(points, [](const Eigen::Vector3d& p) { return !p.allFinite(); });
  return points;
}

std::string OriginAdvice(const CloudArguments& arguments, const Eigen::Vector3d& origin) {
  // PCL also writes the viewpoint 0 0 0 for a cloud without one.
  if (!arguments.origin.empty() || !origin.isZero()) return "";
  return "; the sensor is assumed to be at 0,0,0: if it was not, give its position with "
         "--sensor-origin x,y,z";
}

std::string TableAdvice(const geometry::Points& points, const Eigen::Vector3d& origin,
                        const perception::PerceptionOptions& options, base::Rng& rng) {
  std::string advice;
  const double spacing_m = perception::MeasureSampling(points, options.sampling).spacing_m;
  if (const auto warning = UnitWarning(spacing_m); !warning.empty()) advice += "; " + warning;
  if (options.preprocess.up_C) {
    auto other = options.preprocess;
    other.up_C = -*other.up_C;
    if (const auto table = perception::FindTable(points, origin, other, rng)) {
      const bool in_plane = !SideWarning(table->plane, origin).empty();
      advice += in_plane ? "; the sensor's position lies in the table's plane: give --sensor-origin"
                         : "; the sensor's position lies below the table: give --sensor-origin, or "
                           "try --up with the other sign";
    }
  }
  return advice;
}

std::optional<Eigen::Vector3d> UpOf(const CloudArguments& arguments) {
  if (arguments.up.empty()) return std::nullopt;
  const Eigen::Vector3d up = ParseVector(arguments.up, "--up");
  if (up.norm() == 0.0) throw base::InputError("--up must not be 0,0,0");
  return up.normalized();
}

void AddPerceiveCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "perceive", "Find objects and grasps in one or more clouds, recorded or simulated.");
  auto arguments = std::make_shared<PerceiveArguments>();
  auto clouds = std::make_shared<std::vector<std::string>>();
  auto jobs =
      std::make_shared<int>(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  command->add_option("clouds", *clouds, "PCD, PLY, NPY or XYZ files, or folders of them")
      ->required();
  AddCloudOptions(*command, *arguments);
  command
      ->add_option("--noise-mm", arguments->noise_mm,
                   "noise of the sensor (default: measured from the cloud)")
      ->check(NumberBetween(0.0, perception::kMaxNoise_m * base::kMmPerM));
  command
      ->add_option("--segmentation", arguments->segmentation,
                   "segmentation of the points above the table (convexity)")
      ->check(CLI::IsMember(base::WordList<perception::SegmentMethod>()));
  command->add_option("--scene", arguments->scene,
                      "scene with the hand (default: the installed tabletop.xml)");
  command->add_option("--seed", arguments->seed, "seed of the random draws")
      ->transform(WholeNumber());
  command->add_flag("--json", arguments->json, "print the result as JSON; one line per cloud");
  command->add_option("-o,--out", arguments->out,
                      "output folder for perceived.json, perceived.png and each object's "
                      "object_<n>.ply; for several clouds one subfolder each");
  command
      ->add_option("--jobs", *jobs,
                   "number of clouds processed in parallel (default: number of cores)")
      ->transform(WholeNumber(1, 1024));
  command->footer(
      "Example: rangegrasp perceive table.pcd --sensor-origin 0,0,0 --json -o results/table");
  command->callback([arguments, clouds, jobs] {
    const auto all = CloudsIn(*clouds);
    if (all.size() == 1) {
      arguments->cloud = all.front();
      PerceiveOne(*arguments);
    } else {
      PerceiveAll(ArgumentsOfEach(*arguments, all), *jobs);
    }
  });
}

}  // namespace rangegrasp::cli
