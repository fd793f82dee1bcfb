#include "cylinders/task/demo_detector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "base/stopwatch.h"
#include "base/units.h"
#include "base/words.h"
#include "experiment/record.h"
#include "geometry/mesh.h"
#include "grasp/obstacles.h"
#include "perception/perceive.h"
#include "sim/bodies.h"

namespace rangegrasp::cylinders {
using base::kMm;
using base::YamlMap;

/// No object to grasp is smaller: less is probably in metres.
constexpr double kMinGiven_mm = 1.0;
/// More than a person's error of measurement. Larger: a can that is a quarter shorter than another
/// one passes for it.
constexpr double kMaxSizeError = 0.15;

std::optional<GivenCylinder> GivenFrom(const std::string& text, char between) {
  const auto parts = base::Split(text, between);
  if (parts.size() != 2) return std::nullopt;
  const auto radius_mm = base::NumberFrom<double>(parts[0]);
  const auto height_mm = base::NumberFrom<double>(parts[1]);
  if (!radius_mm || !height_mm || !std::isfinite(*radius_mm + *height_mm)) return std::nullopt;
  if (std::min(*radius_mm, *height_mm) < kMinGiven_mm) return std::nullopt;
  return GivenCylinder{*radius_mm * kMm, *height_mm * kMm};
}

void ReadGiven(YamlMap& map, TableOptions& options) {
  std::vector<std::string> given;
  map.Read("cylinders", given, "given shapes of `objects`, in the same order: RADIUSxHEIGHT in mm");
  for (const std::string& text : given) {
    const auto one = GivenFrom(text, 'x');
    if (!one) {
      map.Fail(
          "cylinders",
          fmt::format("'{}' must be RADIUSxHEIGHT in mm, both at least 1, e.g. 25.75x173", text));
    }
    options.given.push_back(*one);
  }
}

void ReadTable(YamlMap& map, const char* count, std::uint64_t seed, TableOptions& options) {
  if (map.Has("trials_per_object")) {
    map.Fail("trials_per_object", fmt::format("use `{}` in this task", count));
  }
  map.Require("cylinders");
  options.grasping = trial::ReadOptions(map, seed);
  if (options.grasping.take != grasp::kAnywhere) {
    map.Fail("grasp", "take: only for `task: grasping`");
  }
  if (options.grasping.method == trial::MethodKind::kPublished) options.detection = AsPublished();
  const std::size_t objects = options.grasping.objects.size();
  if (options.given.size() != objects) {
    map.Fail("cylinders",
             fmt::format("has {}, but objects has {}", base::Counted(options.given.size(), "shape"),
                         base::Counted(objects, "name")));
  }
  // Each table holds all of them.
  options.grasping.clutter.always = options.grasping.objects;
}

void CheckGiven(const YamlMap& map, const TableOptions& options) {
  for (std::size_t i = 0; i < options.given.size(); ++i) {
    const std::string& object = options.grasping.objects[i];
    const auto surface = sim::ObjectSurface(trial::ObjectModelOf(options.grasping, object));
    const auto& [radius_m, height_m] = options.given[i];
    const Eigen::Array3d size_m = geometry::BoundsOf(surface.mesh.vertices).sizes();
    // Sorted, so that the model's axis does not matter.
    Eigen::Array3d model_m = size_m;
    Eigen::Array3d given_m(2.0 * radius_m, 2.0 * radius_m, height_m);
    std::ranges::sort(model_m);
    std::ranges::sort(given_m);
    if (((given_m - model_m).abs() <= kMaxSizeError * model_m).all()) continue;
    map.Fail("cylinders", fmt::format("{} is {:.4g} x {:.4g} x {:.4g} mm, but {:g}x{:g} is given "
                                      "(RADIUSxHEIGHT, in the order of `objects`)",
                                      object, size_m.x() / kMm, size_m.y() / kMm, size_m.z() / kMm,
                                      radius_m / kMm, height_m / kMm));
  }
}

DetectOptions FirstLook(const DemoOptions& options) {
  DetectOptions look = options.detection;
  if (!options.thorough) return look;
  // A barrel with a fiftieth of the points is drawn 12 times, and the faces of boxes, which are the
  // first candidates, do not use up all examined candidates.
  look.search.draws = 600;
  look.search.max_lying = 24;
  look.search.max_standing = 24;
  look.search.max_leaning = 6;
  return look;
}

DetectOptions SecondLook(const DemoOptions& options) {
  DetectOptions look = FirstLook(options);
  // A small visible part suffices. Smaller: other objects are mistaken for it.
  look.accept.min_arc_rad = base::Deg(30.0);
  look.accept.min_length_share = 0.1;
  look.accept.min_seen_share = 0.05;
  return look;
}

DemoOptions ReadDemoKeys(YamlMap& map, DemoOptions o) {
  map.Read("runs", o.runs, 1, 100000,
           "number of runs; the target is one of the given cylinders in turn");
  ReadGiven(map, o);
  auto keys = map.Child("demo", "from the detected cylinder to the person");
  keys.Read("delivery", o.delivery, "end of the run: hand the cylinder over or place it");
  keys.Read("max_tries", o.max_tries, 1, 20,
            "maximum number of tries per run: after a failed detection, motion planning or grasp, "
            "the robot looks and tries again");
  base::ReadAdditions<DemoAdditions>(keys, o);
  ReadUser(keys.Child("user", "the person who takes the object"), o.hand_over);
  keys.Finish();
  return o;
}

DemoOptions ReadDemo(YamlMap& map, std::uint64_t seed) {
  DemoOptions options;
  trial::MethodKind method = options.grasping.method;
  map.Read("method", method);
  if (method == trial::MethodKind::kPublished) {
    base::SwitchAll<DemoAdditions>(false, options);
    options.max_tries = 1;
  }
  options = ReadDemoKeys(map, std::move(options));
  ReadTable(map, "runs", seed, options);
  return options;
}

namespace {

using Eigen::Vector3d;

/// Sides of the polygon for a closed cylinder: at most 0.4 % of the radius inside the circle.
constexpr int kSides = 36;
/// Distance of the rings of points on it.
constexpr double kRing_m = 0.005;
/// Points this near to the cylinder are no obstacle: they are due to noise and the pose's error.
constexpr double kGrown_m = 0.006;
/// Clearance of the open hand in a roomy grasp: covers the error of completed surfaces.
constexpr double kRoom_m = 0.010;

/// Rings of points on the barrel, from end to end.
geometry::Points RingsOn(const Cylinder& c) {
  const auto& [u, v] = Across(c.axis);
  const int steps = std::max(1, static_cast<int>(std::ceil(c.height_m / kRing_m)));
  geometry::Points points;
  for (int step = 0; step <= steps; ++step) {
    const Vector3d middle =
        c.center + c.height_m * (static_cast<double>(step) / steps - 0.5) * c.axis;
    for (int side = 0; side < kSides; ++side) {
      const double angle = 2.0 * base::kPi * side / kSides;
      points.push_back(middle + c.radius_m * (std::cos(angle) * u + std::sin(angle) * v));
    }
  }
  return points;
}

perception::PerceivedObject ObjectOf(const Cylinder& c, bool lies, const perception::Scene& scene) {
  perception::PerceivedObject object;
  object.kind = perception::ObjectKind::kRotational;
  for (std::uint32_t i = 0; i < scene.cloud.size(); ++i) {
    if (IsWithin(c, kGrown_m, scene.cloud.points[i])) object.points.push_back(i);
  }
  const Vector3d& up = scene.table.plane.normal;
  const Vector3d out = !lies && c.axis.dot(up) < 0.0 ? Vector3d(-c.axis) : c.axis;
  object.axis = perception::RotationAxis{.center_C = c.center + 0.5 * c.height_m * out,
                                         .direction_C = out,
                                         .radius_m = c.radius_m,
                                         .rim_fraction = 1.0,
                                         .body_fraction = 1.0,
                                         .length_m = lies ? c.height_m : 0.0};
  object.completed_C = RingsOn(c);
  object.surface_C = geometry::ConvexHull(object.completed_C);
  const auto [low, high] = std::ranges::minmax_element(
      object.completed_C, {}, [&](const Vector3d& p) { return p.dot(up); });
  object.base_m = std::max(0.0, scene.table.plane.Distance(*low));
  object.height_m = scene.table.plane.Distance(*high);
  object.center_C = c.center;
  object.size_m = {lies ? c.height_m : 2.0 * c.radius_m, 2.0 * c.radius_m,
                   object.height_m - object.base_m};
  object.axis_C =
      lies ? Vector3d((c.axis - c.axis.dot(up) * up).normalized()) : up.unitOrthogonal();
  return object;
}

/// Share of the cylinder's points in the perceived objects that contain them: 1 if it is a separate
/// object. Points of other given cylinders that it touches are left out.
double PurityOf(const FoundCylinder& one, const perception::Scene& scene,
                const std::vector<FoundCylinder>& found) {
  const auto is_anothers = [&](const Vector3d& p) {
    return std::ranges::any_of(found, [&](const FoundCylinder& other) {
      return other.given != one.given && IsWithin(other.cylinder_C, kGrown_m, p);
    });
  };
  double own = 0.0;
  double pure = 0.0;
  for (const perception::PerceivedObject& object : scene.objects) {
    double within = 0.0;
    double all = 0.0;
    for (const auto i : object.points) {
      const Vector3d& p = scene.cloud.points[i];
      const bool is_own = IsWithin(one.cylinder_C, kGrown_m, p);
      within += is_own;
      all += is_own || !is_anothers(p);
    }
    own += within;
    pure += within * within / std::max(1.0, all);
  }
  return own > 0.0 ? pure / own : 0.0;
}

/// Sorts the finds of each given cylinder by purity, reduced by the error of the radius.
void PurestFirst(const perception::Scene& scene, const DemoOptions& options,
                 std::vector<FoundCylinder>& found) {
  std::vector<std::pair<double, FoundCylinder>> scored;
  for (const FoundCylinder& one : found) {
    const double error_m = std::abs(one.cylinder_C.radius_m - options.given[one.given].radius_m);
    const double score =
        PurityOf(one, scene, found) * std::exp(-error_m / options.detection.accept.max_rim_error_m);
    scored.emplace_back(score, one);
  }
  std::ranges::stable_sort(scored, {},
                           [](const auto& one) { return std::pair(one.second.given, -one.first); });
  for (std::size_t i = 0; i < found.size(); ++i) found[i] = std::move(scored[i].second);
}

class DemoDetector : public trial::Detector {
 public:
  DemoDetector(const DemoOptions& options, const robot::Robot& robot, std::size_t wanted,
               CylinderObserver observer)
      : options_(options), robot_(robot), wanted_(wanted), observer_(std::move(observer)) {}

  trial::Detected Detect(const geometry::Observation& observation, base::Rng& rng,
                         const trial::Turn&) const override {
    const trial::Options& options = options_.grasping;
    trial::Detected detected;
    base::Stopwatch watch;
    const perception::Workspace workspace = trial::WorkspaceOf(robot_, options.workspace_margin_m);
    const auto look = [&](const DetectOptions& how) {
      auto scene = DetectCylinders(observation, options_.given, how, rng, workspace);
      for (const auto& [step, seconds] : scene.seconds) {
        experiment::AddSeconds(kCylinderStep + step, seconds, detected.seconds);
      }
      return scene;
    };
    CylinderScene found = look(FirstLook(options_));
    if (options_.second_look && !found.Find(wanted_)) found = look(SecondLook(options_));
    detected.seconds.emplace_back("cylinders", watch.Restart());
    perception::Scene scene = perception::Perceive(observation, options.perception, rng, workspace);
    detected.seconds.emplace_back("perceive", watch.Restart());
    detected.segments = static_cast<int>(scene.segments.size());
    detected.kept = scene.cloud.size();
    detected.detection.table_C = scene.table.plane;
    if (options_.purity) PurestFirst(scene, options_, found.cylinders);
    if (observer_) observer_(found, observation);
    watch.Restart();
    if (!found.Find(wanted_)) return detected;
    // The wanted one is inserted last, so that it is the scene's first object.
    for (const bool wanted : {false, true}) PutFirstOf(found, wanted, scene);

    grasp::Obstacles obstacles =
        grasp::ObstaclesOf(scene, 0, trial::PlacesOf(observation), options.obstacles);
    const auto grasps = Grasps(scene, obstacles.measured_C);
    detected.seconds.emplace_back("grasp", watch.Restart());
    detected.detection = grasp::DetectionFrom(scene, grasps);
    detected.detection.obstacles = std::move(obstacles);
    return detected;
  }

 private:
  /// Grasps of the first object; those with more clearance to the others come first.
  std::vector<grasp::Grasp> Grasps(const perception::Scene& scene,
                                   std::span<const geometry::TriangleMesh> obstacles_C) const {
    const grasp::Arm arm(robot_);
    grasp::GraspOptions options = options_.grasping.grasp;
    const auto tight = grasp::PlanGrasps(scene, 0, robot_.hand(), arm, options, obstacles_C);
    if (!options_.roomy_grasps) return tight;
    options.object_clearance_m = std::max(options.object_clearance_m, kRoom_m);
    auto grasps = grasp::PlanGrasps(scene, 0, robot_.hand(), arm, options, obstacles_C);
    std::erase_if(grasps, [](const grasp::Grasp& grasp) { return grasp.collides; });
    grasps.insert(grasps.end(), tight.begin(), tight.end());
    return grasps;
  }

  /// Puts the wanted one first, or the best find of each of the others.
  void PutFirstOf(const CylinderScene& seen, bool wanted, perception::Scene& scene) const {
    std::vector<bool> done(options_.given.size(), false);
    for (const FoundCylinder& found : seen.cylinders) {
      if ((found.given == wanted_) != wanted || done[found.given]) continue;
      done[found.given] = true;
      PutFirst(found.cylinder_C, found.lies, scene);
    }
  }

  const DemoOptions& options_;
  const robot::Robot& robot_;
  std::size_t wanted_;
  CylinderObserver observer_;
};

}  // namespace

void PutFirst(const Cylinder& cylinder_C, bool lies, perception::Scene& scene) {
  std::erase_if(scene.objects, [&](const perception::PerceivedObject& object) {
    const auto within = std::ranges::count_if(object.points, [&](auto i) {
      return IsWithin(cylinder_C, kGrown_m, scene.cloud.points[i]);
    });
    return 2 * static_cast<std::size_t>(within) > object.points.size();
  });
  scene.objects.insert(scene.objects.begin(), ObjectOf(cylinder_C, lies, scene));
}

std::unique_ptr<trial::Detector> MakeDemoDetector(const DemoOptions& options,
                                                  const robot::Robot& robot, std::size_t wanted,
                                                  CylinderObserver observer) {
  return std::make_unique<DemoDetector>(options, robot, wanted, std::move(observer));
}

}  // namespace rangegrasp::cylinders
