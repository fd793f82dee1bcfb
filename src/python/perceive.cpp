#include "perception/perceive.h"

#include <fmt/format.h>
#include <nanobind/stl/optional.h>

#include <cmath>
#include <map>

#include "base/error.h"
#include "base/installation.h"
#include "base/words.h"
#include "grasp/detector.h"
#include "grasp/score_model.h"
#include "perception/doubts.h"
#include "python/values.h"

namespace rangegrasp::python {
namespace {

namespace fs = std::filesystem;

// Caches the robot of each scene: sampling the hand from its model takes longer than perception.
const robot::Robot& RobotOf(const std::string& scene) {
  static std::map<std::string, robot::Robot> robots;
  const auto found = robots.find(scene);
  if (found != robots.end()) return found->second;
  const fs::path file =
      scene.empty() ? base::DataFolder() / "scenes/tabletop.xml" : fs::path(scene);
  return robots.emplace(scene, robot::Robot::Load(file)).first->second;
}

// Reasons to doubt the result, in the words of the function's arguments.
std::vector<std::string> WarningsOf(const perception::Scene& scene, const Eigen::Vector3d& sensor_C,
                                    bool pose_is_known, bool noise_is_given) {
  const perception::Cures cures{
      .smaller_unit = "points must be in metres; divide millimetres by 1000",
      .larger_unit = "points must be in metres",
      .sensor = "X_WV must be in metres",
      .upper_side = "pass X_WV, or up=(x, y, z)",
      .other_things = "pass crop=(x, y, z, x, y, z), or up=(x, y, z)",
      .noise = "pass noise=... in metres"};
  const std::string of_origin =
      pose_is_known ? ""
                    : "there is no X_WV: the sensor is assumed at 0,0,0 (pass its pose, or "
                      "X_WV=np.eye(4) if it is there)";
  return perception::Doubts(scene, sensor_C, of_origin, noise_is_given, cures);
}

// Leaves out the points of each view that were not measured; returns the warnings.
std::vector<std::string> LeaveOutUnmeasured(geometry::Observation& observation) {
  std::vector<std::string> warnings;
  for (geometry::View& view : observation.views) {
    const Eigen::Vector3d sensor_C = view.image.origins_C.front();
    std::ranges::move(perception::LeaveOutUnmeasured(sensor_C, view.image.points_C),
                      std::back_inserter(warnings));
  }
  return warnings;
}

// Leaves out the points of all views outside the box.
void CropViews(const std::vector<double>& corners_m, geometry::Observation& observation) {
  std::vector<geometry::Points*> clouds_C;
  for (geometry::View& view : observation.views) clouds_C.push_back(&view.image.points_C);
  perception::Crop(corners_m, {.name = "crop", .unit = "crop and points must be in metres"},
                   clouds_C);
}

Eigen::Vector3d UpFrom(const Vector3& numbers) {
  const Eigen::Map<const Eigen::Vector3d> up(numbers.data());
  if (up.norm() > 0.0 && std::isfinite(up.norm())) return up.normalized();
  throw base::InputError(fmt::format(
      "up must be a direction, e.g. (0, 0, 1), not ({:g}, {:g}, {:g})", up.x(), up.y(), up.z()));
}

nb::dict Perceive(const nb::dict& scan, const std::optional<std::vector<double>>& crop,
                  std::optional<double> noise_m, const std::optional<Vector3>& up,
                  const std::string& segmentation, const std::string& scene_file,
                  std::uint64_t seed, std::size_t grasped, bool pose_is_known) {
  if (noise_m && !(*noise_m >= 0.0 && *noise_m <= perception::kMaxNoise_m)) {
    throw base::InputError(fmt::format("noise {:g} m must be 0 to {:g} m: is it in millimetres?",
                                       *noise_m, perception::kMaxNoise_m));
  }
  geometry::Observation observation = ObservationFrom(scan);
  perception::PerceptionOptions options;
  options.segment.method = base::FromWord<perception::SegmentMethod>(segmentation, "segmentation");
  options.noise_m = noise_m;
  if (up) options.preprocess.up_C = UpFrom(*up);
  const robot::Robot& robot = RobotOf(scene_file);
  static const grasp::ScoreModel score(grasp::ScoreModelOf({}));
  // A scan made from an array has no workspace.
  std::optional<perception::Workspace> workspace;
  const double radius_m = nb::cast<double>(scan["radius"]);
  if (std::isfinite(radius_m)) {
    const auto center = nb::cast<Vector3>(scan["center"]);
    base::Pose X_WWorkspace = base::Pose::Identity();
    X_WWorkspace.translation() = Eigen::Map<const Eigen::Vector3d>(center.data());
    workspace.emplace(X_WWorkspace, radius_m);
  }
  perception::Scene scene;
  std::vector<std::vector<grasp::Grasp>> grasps;
  std::vector<std::string> warnings;
  {
    const nb::gil_scoped_release others_may_run;
    // A scan with a workspace comes from a calibrated cell: it has NaN where nothing was measured,
    // and there an empty table is a usual result.
    if (!workspace) warnings = LeaveOutUnmeasured(observation);
    if (crop) CropViews(*crop, observation);
    base::Rng rng(seed);
    scene = perception::Perceive(observation, options, rng, workspace);
    const Eigen::Vector3d origin = observation.views.front().image.origins_C.front();
    if (!workspace) {
      std::ranges::move(WarningsOf(scene, origin, pose_is_known, noise_m.has_value()),
                        std::back_inserter(warnings));
    }
    for (std::size_t i = 0; i < std::min(grasped, scene.objects.size()); ++i) {
      grasps.push_back(grasp::PlanGrasps(scene, i, robot.hand(),
                                         grasp::Arm(2.0 * scene.objects[i].center_C - origin), {}));
      score.Rank(observation, scene, i, robot.hand(), grasps.back());
    }
  }
  const auto all_objects = grasp::DetectionFrom(scene, {}).objects;
  nb::list objects, all;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    objects.append(DictOf(all_objects[i],
                          geometry::Select(scene.cloud.points, scene.objects[i].points),
                          observation));
    if (i >= grasps.size()) continue;
    for (const grasp::DetectedGrasp& g : grasp::DetectionFrom(scene, grasps[i], i).grasps) {
      all.append(DictOf(g, robot.hand()));
    }
  }
  nb::dict found;
  found["table_normal"] = ArrayOf(scene.table.plane.normal);
  found["table_offset"] = scene.table.plane.offset_m;
  found["noise"] = scene.sampling.noise_m;
  found["features"] = nb::none();
  found["objects"] = objects;
  found["grasps"] = all;
  found["warnings"] = warnings;
  return found;
}

}  // namespace

void AddPerceive(nb::module_& m) {
  m.def("perceive", &Perceive, nb::arg("scan"), nb::arg("crop").none(), nb::arg("noise_m").none(),
        nb::arg("up").none(), nb::arg("segmentation"), nb::arg("scene"), nb::arg("seed"),
        nb::arg("grasped"), nb::arg("pose_is_known"));
}

}  // namespace rangegrasp::python
