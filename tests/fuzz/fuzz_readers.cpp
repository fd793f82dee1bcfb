// Fuzzes every reader of files and answers, and perception and grasp planning, with clang's
// libFuzzer:
//
//   fuzz_readers --reader=pcd [libFuzzer's options] CORPUS
//
// A reader may refuse its input with one of the project's errors. Any other exception, a sanitizer
// report, a hang or too much memory is a finding. scripts/fuzz runs all of them.

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "base/image/image.h"
#include "base/yaml_map.h"
#include "experiment/experiment.h"
#include "experiment/slurm.h"
#include "experiment/store.h"
#include "external/internal/detector_message.h"
#include "geometry/cloud_file.h"
#include "geometry/mesh_file.h"
#include "grasp/fixtures.h"
#include "grasp/grasp.h"
#include "grasp/mover.h"
#include "grasp/named_grasps.h"
#include "grasp/obstacles.h"
#include "grasp/score_model.h"
#include "parts/shape/shape_file.h"
#include "perception/perceive.h"
#include "robot/internal/mjcf.h"
#include "seam/calibration.h"
#include "seam/internal/tiff_file.h"
#include "seam/monitor.h"
#include "seam/profile_io.h"
#include "seam/stitching/stripe_sensor.h"
#include "seam/tracker.h"
#include "sensing/hand_eye.h"
#include "sensing/range_sensor.h"
#include "sim/surfaces.h"
#include "stereo/camera.h"
#include "stereo/sensing/stereo_camera.h"

namespace rangegrasp {
namespace {

namespace fs = std::filesystem;
using base::YamlMap;

// A file in memory, for readers that take paths; its name has the reader's extension.
const fs::path& Folder() {
  static const fs::path folder = [] {
    const fs::path made = fs::path("/dev/shm") / fmt::format("rangegrasp_fuzz_{}", getpid());
    fs::create_directories(made);
    std::atexit([] { fs::remove_all(Folder()); });
    return made;
  }();
  return folder;
}
fs::path FileOf(std::string_view bytes, const std::string& name) {
  fs::path file = Folder() / name;
  std::ofstream(file, std::ios::binary) << bytes;
  return file;
}

void ReadMeshes(std::string_view bytes, const std::string& name) {
  const fs::path file = FileOf(bytes, name);
  geometry::ReadPolygonMesh(file);
  geometry::ReadTexturedMesh(file);
}

void ReadYaml(std::string_view bytes, const std::function<void(YamlMap&)>& read) {
  YamlMap map = YamlMap::FromText(std::string(bytes), FileOf("", "file.yaml"));
  read(map);
  map.Finish();
}

// Any of the formats: a preset, or keys up to a line "===" before the profiles.
void ReadProfiles(const std::string& keys, std::string_view text) {
  seam::ProfileFileOptions options;
  seam::ReadProfileFileOptions(YamlMap::FromText(keys, "keys.yaml"), options);
  std::istringstream in{std::string(text)};
  seam::ProfileStream stream(in, options);
  while (stream.Next()) {
  }
  stream.grid();
}
void ReadProfilesOfPreset(std::string_view bytes) {
  if (bytes.empty()) return;
  const auto& presets = seam::FormatPresets();
  const auto preset = static_cast<unsigned char>(bytes[0]) % (presets.size() + 1);
  ReadProfiles(preset < presets.size() ? std::string(presets[preset].yaml) : "", bytes.substr(1));
}
void ReadProfilesWithKeys(std::string_view bytes) {
  const auto end = bytes.find("\n===\n");
  if (end == std::string_view::npos) return;
  ReadProfiles(std::string(bytes.substr(0, end)), bytes.substr(end + 5));
}

// Numbers from bytes; zeros after their end.
class Numbers {
 public:
  explicit Numbers(std::string_view bytes) : bytes_(bytes) {}
  bool Left() const { return !bytes_.empty(); }
  int Byte() {
    if (bytes_.empty()) return 0;
    const int byte = static_cast<unsigned char>(bytes_.front());
    bytes_.remove_prefix(1);
    return byte;
  }
  double Coordinate(double scale_m) {  // from two bytes
    const int high = Byte();
    return (256 * high + Byte() - 32768) / 32768.0 * scale_m;
  }

 private:
  std::string_view bytes_;
};

// A patch of a scan: a height of each sample above an otherwise flat table, and all kinds of
// missing values that a sensor may produce.
geometry::RangeImage AnyImage(Numbers& numbers) {
  geometry::RangeImage image;
  image.profiles = 12 + numbers.Byte() % 24;
  image.samples = 12 + numbers.Byte() % 24;
  const double spacing_m = 0.001 + 0.0001 * numbers.Byte();
  const int kind = numbers.Byte();
  image.origins_C = {{0.0, 0.0, 0.3 + 0.01 * numbers.Byte()}};
  for (int i = 0; i < image.profiles; ++i) {
    for (int j = 0; j < image.samples; ++j) {
      const int height = numbers.Byte();
      Eigen::Vector3d p(spacing_m * i, spacing_m * j, 0.001 * (height > 127 ? 0 : height));
      if (height == 255) p.setConstant(NAN);
      if (height == 254) p.z() = INFINITY;
      if (height == 253) p = image.points_C.empty() ? p : image.points_C.back();
      if (kind % 4 == 1) p.x() += numbers.Coordinate(0.1);
      if (kind % 4 == 2) p *= 1000.0;
      image.points_C.push_back(p);
    }
  }
  return image;
}

void Perceive(std::string_view bytes) {
  Numbers numbers(bytes);
  base::Rng rng(1);
  perception::PerceptionOptions options;
  if (numbers.Byte() % 2 == 1) {
    base::SwitchAll<perception::PreprocessAdditions>(false, options.preprocess);
    base::SwitchAll<perception::FeatureAdditions>(false, options.features);
  }
  perception::Perceive(geometry::ObservationOf(AnyImage(numbers)), options, rng);
}

// An object with arbitrary triangles and points, top and axis.
perception::PerceivedObject AnyObject(Numbers& numbers) {
  const int scale = numbers.Byte();
  const double scale_m = 0.01 + 0.0004 * scale;  // up to what a hand can hold
  const auto vector = [&](double m) {
    const double x = numbers.Coordinate(m);
    const double y = numbers.Coordinate(m);
    return Eigen::Vector3d(x, y, numbers.Coordinate(m));
  };
  const auto direction = [&] {
    const Eigen::Vector3d v = vector(1.0);
    return Eigen::Vector3d(v.norm() > 0.0 ? Eigen::Vector3d(v.normalized())
                                          : Eigen::Vector3d::UnitZ());
  };
  perception::PerceivedObject object;
  const int kind = numbers.Byte();
  object.open = kind % 2 == 1;
  object.center_C = vector(scale_m);
  object.size_m = vector(scale_m).cwiseAbs();
  object.axis_C = Eigen::Vector3d::UnitX();
  object.height_m = std::abs(numbers.Coordinate(scale_m));
  if (kind % 4 > 1) {
    object.kind = perception::ObjectKind::kRotational;
    object.axis = {.center_C = vector(scale_m),
                   .direction_C = direction(),
                   .radius_m = std::abs(numbers.Coordinate(scale_m))};
    if (kind % 8 > 3) object.axis->length_m = std::abs(numbers.Coordinate(scale_m));
  }
  if (kind % 16 > 7) {
    grasp::test::SceneBuilder::SetTop(
        vector(scale_m), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(),
        std::abs(numbers.Coordinate(scale_m)), std::abs(numbers.Coordinate(scale_m)), object);
  }
  const int vertices = 3 + numbers.Byte() % 60;
  for (int i = 0; i < vertices; ++i) object.surface_C.vertices.push_back(vector(scale_m));
  while (numbers.Left() && object.surface_C.triangles.size() < 100) {
    const auto corner = [&] { return static_cast<std::uint32_t>(numbers.Byte() % vertices); };
    const auto a = corner();
    const auto b = corner();
    object.surface_C.triangles.push_back({a, b, corner()});
  }
  object.completed_C = object.surface_C.vertices;
  return object;
}

void PlanGrasps(std::string_view bytes) {
  Numbers numbers(bytes);
  static const robot::HandModel hand = grasp::test::SensorHand();
  grasp::GraspOptions options;
  if (numbers.Byte() % 2 == 1) base::SwitchAll<grasp::GraspAdditions>(false, options);
  perception::Scene scene;
  scene.table.plane.normal = Eigen::Vector3d::UnitZ();
  auto& object = scene.objects.emplace_back(AnyObject(numbers));
  for (const Eigen::Vector3d& p : object.completed_C) {
    object.points.push_back(static_cast<std::uint32_t>(scene.cloud.points.size()));
    scene.cloud.points.push_back(p);
  }
  grasp::PlanGrasps(scene, 0, hand, grasp::test::ArmBase(), options);
}

void ReadAnswer(std::string_view bytes) {
  static const geometry::Observation observation = [] {
    Numbers none("");
    return geometry::ObservationOf(AnyImage(none));
  }();
  try {
    external::internal::ParseAnswer(std::string(bytes), observation);
  } catch (const grasp::DetectorFailed&) {
  }
}

void ReadDatabase(std::string_view bytes) {
  FileOf(bytes, "results.sqlite");
  const auto store = experiment::Store::Open(Folder());
  store.ReadStamp();
  store.Count();
  store.Ids();
  for (const auto& record : store.ReadAll()) ToJson(record);
}

void ReadSlurm(std::string_view bytes) {
  if (bytes.empty()) return;
  if (bytes[0] == '{') {
    fs::create_directories(Folder() / "slurm");
    FileOf(bytes, "slurm/submission.json");
    const auto submission = experiment::ReadSubmission(Folder());
    experiment::ArrayScriptText(submission, "/usr/bin/rangegrasp");
    return;
  }
  experiment::ParseQueue(std::string(bytes));
}

void ReadExperiment(YamlMap& map) {
  experiment::Common common;
  experiment::ReadCommon(map, common);
  perception::PerceptionOptions perception;
  grasp::DetectorOptions grasp;
  grasp::MoverOptions planning;
  grasp::ObstacleOptions obstacles;
  perception::ReadOptions(map.Child("perception"), perception);
  grasp::ReadGraspOptions(map.Child("grasp"), grasp);
  grasp::ReadPlanningOptions(map.Child("planning"), planning, obstacles);
}

void ReadDetection(YamlMap& map) {
  seam::TrackerOptions tracker;
  seam::MonitorOptions monitor;
  seam::ProfileFileOptions file;
  seam::ReadMonitorOptions(map.Child("monitor"), monitor);
  seam::ReadProfileFileOptions(map.Child("file"), file);
  seam::ReadTrackerOptions(map, tracker);
}

void ReadCsv(std::string_view bytes) {
  const auto table = base::CsvTable::Parse(bytes, "table.csv");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (std::size_t i = 0; i < table.header().size(); ++i) table.OptionalNumber(row, i);
  }
}

using Reader = std::function<void(std::string_view)>;

const std::map<std::string, Reader>& Readers() {
  const auto yaml = [](void (*read)(YamlMap&)) {
    return [read](std::string_view bytes) { ReadYaml(bytes, read); };
  };
  const auto mesh = [](const std::string& name) {
    return [name](std::string_view bytes) { ReadMeshes(bytes, name); };
  };
  static const std::map<std::string, Reader> readers = {
      {"pcd", [](std::string_view b) { geometry::ReadCloud(FileOf(b, "file.pcd")); }},
      {"npy", [](std::string_view b) { geometry::ReadCloud(FileOf(b, "file.npy")); }},
      {"xyz", [](std::string_view b) { geometry::ReadCloud(FileOf(b, "file.xyz")); }},
      {"ply",
       [](std::string_view b) {
         const fs::path file = FileOf(b, "file.ply");
         if (geometry::PlyHoldsMesh(file)) {
           geometry::ReadPolygonMesh(file);
         } else {
           geometry::ReadCloud(file);
         }
       }},
      {"off", mesh("file.off")},
      {"obj", mesh("file.obj")},
      {"stl", mesh("file.stl")},
      {"gltf", mesh("file.gltf")},
      {"glb", mesh("file.glb")},
      {"seg", [](std::string_view b) { parts::ReadLabels(FileOf(b, "file.seg")); }},
      {"experiment", yaml(ReadExperiment)},
      {"scanner", [](std::string_view b) { sensing::ReadLineScanner(FileOf(b, "file.yaml")); }},
      {"detection", yaml(ReadDetection)},
      {"mjcf", [](std::string_view b) { robot::internal::Mjcf model(FileOf(b, "file.xml")); }},
      {"profiles", ReadProfilesOfPreset},
      {"profile_keys", ReadProfilesWithKeys},
      {"png",
       [](std::string_view b) {
         switch (b.size() % 3) {
           case 0:
             image::DecodePng<image::Image>(b);
             break;
           case 1:
             image::DecodePng<image::Grey8>(b);
             break;
           default:
             image::DecodePng<image::Grey16>(b);
         }
       }},
      {"tiff", [](std::string_view b) { image::ReadTiff(FileOf(b, "file.tif")); }},
      {"csv", ReadCsv},
      {"calibration", [](std::string_view b) { seam::ReadCalibration(FileOf(b, "file.yaml")); }},
      {"stripe_sensor", [](std::string_view b) { seam::ReadStripeSensor(FileOf(b, "file.yaml")); }},
      {"depth_camera",
       [](std::string_view b) { sensing::ReadDepthCamera(FileOf(b, "file.yaml")); }},
      {"stereo_camera",
       [](std::string_view b) { sensing::ReadStereoCamera(FileOf(b, "file.yaml")); }},
      {"hand_eye", [](std::string_view b) { sensing::ReadHandEye(FileOf(b, "file.yaml")); }},
      {"surfaces", [](std::string_view b) { sim::ReadSurfaces(FileOf(b, "file.yaml")); }},
      {"named_grasps", [](std::string_view b) { grasp::ReadNamedGrasps(FileOf(b, "file.yaml")); }},
      {"score_model", [](std::string_view b) { grasp::ScoreModel model(FileOf(b, "file.json")); }},
      {"stereo", [](std::string_view b) { stereo::ReadStereoCalibration(FileOf(b, "file.yaml")); }},
      {"answer", ReadAnswer},
      {"database", ReadDatabase},
      {"slurm", ReadSlurm},
      {"perceive", Perceive},
      {"grasps", PlanGrasps},
  };
  return readers;
}

const Reader* chosen = nullptr;

}  // namespace
}  // namespace rangegrasp

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  using namespace rangegrasp;
  constexpr std::string_view kOption = "--reader=";
  std::string names;
  for (const auto& [name, reader] : Readers()) names += name + "\n";
  for (int i = 1; i < *argc; ++i) {
    const std::string_view word = (*argv)[i];
    if (word == "--list") {
      std::fputs(names.c_str(), stdout);
      std::exit(0);
    }
    if (!word.starts_with(kOption)) continue;
    const auto found = Readers().find(std::string(word.substr(kOption.size())));
    if (found != Readers().end()) chosen = &found->second;
  }
  if (chosen == nullptr) {
    std::fprintf(stderr, "--reader=NAME must name one of\n%s", names.c_str());
    std::exit(2);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace rangegrasp;
  try {
    (*chosen)({reinterpret_cast<const char*>(bytes), size});
  } catch (const base::InputError&) {
  } catch (const base::RunError&) {
  }
  return 0;
}
