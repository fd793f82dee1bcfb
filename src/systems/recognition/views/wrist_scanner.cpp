#include "recognition/views/wrist_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <map>
#include <utility>

#include "base/error.h"
#include "base/frames.h"
#include "grasp/surface.h"
#include "sensing/hand_eye.h"
#include "sensing/line_scanner.h"
#include "sim/execute.h"

namespace rangegrasp::views {
namespace {

/// Radius of the space about the highest object that views show: half of the longest object.
constexpr double kRegionRadius_m = 0.15;
/// Points below this height above the table are noise and mixed points, not objects.
constexpr double kStands_m = 0.015;
/// Margin above the highest point, so that the space over it belongs to the region.
constexpr double kAbove_m = 0.03;
/// Height that includes everything on the table, plus a hand's breadth.
constexpr double kObstacles_m = 0.35;
/// Distance at which the fixed scanner's rotational calibration error is converted to a shift.
constexpr double kFixedDistance_m = 1.0;
/// Cells for finding the highest object, and the minimum points in one, against stray points.
constexpr double kMap_m = 0.02;
constexpr std::size_t kMinInCell = 4;
/// Maximum error of a calibration of this head; beyond it, the file belongs to another head.
constexpr double kOtherHead_m = 0.02;

void ReadLook(base::YamlMap map, WristViewOptions& options) {
  using base::kDeg;
  using base::kMm;
  constexpr double kCm3 = 1e-6;
  map.ReadPath("sensor", options.sensor,
               "file of the line scanner or depth camera at the scene's site wrist_scanner");
  map.ReadScaled("mount_sigma_mm", options.mount_sigma_m, kMm, 0.0, 20.0,
                 "position error of the head on the flange, unknown to the robot, root mean "
                 "square; one draw per trial");
  map.ReadScaled("mount_sigma_deg", options.mount_sigma_rad, kDeg, 0.0, 5.0,
                 "rotation error of the head on the flange, root mean square; one draw per trial");
  map.ReadPath(
      "hand_eye", options.hand_eye,
      "calibrated pose of the head, a file from calibrate-hand-eye, instead of the random error");
  for (const char* key : {"mount_sigma_mm", "mount_sigma_deg"}) {
    if (!options.hand_eye.empty() && map.Has(key)) {
      map.Fail(key,
               "cannot be used with look.hand_eye, which has the pose of the head and its error");
    }
  }
  map.Read("until_probability", options.until_probability, 0.0, 1.0,
           "grasping: take no further view once the best grasp's predicted probability of delivery "
           "reaches this value, and use the most promising detection; 1: take all views");
  map.ReadScaled("min_gain_cm3", options.next.min_gain_m3, kCm3, 0.0, 1e6,
                 "minimum new space that a view must see there");
  map.Finish();
}

template <typename Visit>
void ForEachPoint(const geometry::Observation& observation, const Visit& visit) {
  for (const geometry::View& view : observation.views) {
    for (const Eigen::Vector3d& p : view.image.points_C) {
      if (p.allFinite()) visit(p);
    }
  }
}

}  // namespace

void ReadWristViewOptions(base::YamlMap& map, WristViewOptions& options) {
  map.Read("views", options.views, 1, 10,
           "number of views per trial: the first by the sensor, more by the wrist scanner, where "
           "they add most information; `task: recognition` stops when every object is sure");
  ReadLook(map.Child("look", "views by the wrist scanner, if `views` is above 1"), options);
  if (options.views > 1 && options.sensor.empty()) {
    map.Fail("views",
             "more than one view needs look: {sensor: FILE}, the scanner on the wrist "
             "(models/sensors/wrist_scanner.yaml)");
  }
}

WristScanner::WristScanner(const trial::Options& options, const robot::Robot& robot,
                           std::uint64_t seed)
    : options_(options),
      look_(trial::Of<WristViewOptions>(options, kWristViews)),
      robot_(robot),
      seed_(base::DeriveSeed(seed, "looks")),
      scanner_(sensing::ReadRangeSensor(look_.sensor)) {
  auto& shared = sensing::SharedOf(scanner_);
  shared.color = shared.color || options.color;
  if (!robot.X_HWristScanner) {
    throw base::InputError(options.scene.string() +
                           ": views by the wrist scanner need a site \"wrist_scanner\" on the "
                           "arm's last link, as in scenes/tabletop_wrist.xml; without them: remove "
                           "`look` and `views` (--set 'look={}' --set views=1)");
  }
  if (!look_.hand_eye.empty()) {
    BelieveCalibration(*robot.X_HWristScanner);
    return;
  }
  mount_error_m_ = look_.mount_sigma_m;
  mount_error_rad_ = look_.mount_sigma_rad;
  base::Rng rng = Stream("mount");
  X_SBelieved_ = base::DrawRigidError(mount_error_m_, mount_error_rad_, rng);
}

void WristScanner::BelieveCalibration(const base::Pose& X_HS) {
  const sensing::HandEye found = sensing::ReadHandEye(look_.hand_eye);
  X_SBelieved_ = X_HS.inverse() * found.X_HS;
  mount_error_m_ = found.shift_error_m;
  mount_error_rad_ = found.turn_error_rad;
  const double off_m = X_SBelieved_.translation().norm();
  if (off_m > kOtherHead_m) {
    throw base::InputError(
        fmt::format("{}: its head is {:.0f} mm from the one in {}: is it the calibration of "
                    "another arm or sensor? `rangegrasp calibrate-hand-eye {}` makes a new one",
                    look_.hand_eye.string(), off_m * base::kMmPerM, options_.scene.string(),
                    options_.scene.string()));
  }
}

base::Rng WristScanner::Stream(const char* name) const {
  return base::Rng(base::DeriveSeed(base::DeriveSeed(seed_, name), looks_));
}

std::optional<Eigen::AlignedBox3d> WristScanner::RegionOfHighest(
    const geometry::Observation& so_far) const {
  const double table_z_m = robot_.X_WWorkspace.translation().z();
  const auto workspace = grasp::WorkspaceOf(robot_, options_.workspace_margin_m);
  std::map<std::array<long, 3>, geometry::Points> cells;
  ForEachPoint(so_far, [&](const Eigen::Vector3d& p) {
    if (p.z() < table_z_m + kStands_m || !workspace.Contains(p)) return;
    cells[grasp::GridCell(p, kMap_m)].push_back(p);
  });
  const auto height = [](const Eigen::Vector3d& p) { return p.z(); };
  std::optional<Eigen::Vector3d> highest;
  for (const auto& [at, points] : cells) {
    if (points.size() < kMinInCell) continue;
    const Eigen::Vector3d& of_cell = *std::ranges::max_element(points, {}, height);
    if (!highest || of_cell.z() > highest->z()) highest = of_cell;
  }
  return highest ? std::optional(RegionAbout(*highest, so_far)) : std::nullopt;
}

Eigen::AlignedBox3d WristScanner::RegionAbout(const Eigen::Vector3d& place_W,
                                              const geometry::Observation& so_far) const {
  const double table_z_m = robot_.X_WWorkspace.translation().z();
  const double radius_m = kRegionRadius_m;
  double top_m = std::max(place_W.z(), table_z_m + kStands_m);
  ForEachPoint(so_far, [&](const Eigen::Vector3d& p) {
    const bool near = (p - place_W).head<2>().norm() < radius_m;
    if (near && p.z() < place_W.z() + kAbove_m) top_m = std::max(top_m, p.z());
  });
  // The box begins above the noise of the table.
  const double low_m = table_z_m + 0.5 * look_.next.cell_m;
  return {Eigen::Vector3d(place_W.x() - radius_m, place_W.y() - radius_m, low_m),
          Eigen::Vector3d(place_W.x() + radius_m, place_W.y() + radius_m, top_m + kAbove_m)};
}

Eigen::AlignedBox3d WristScanner::AroundWorkspace(double below_m) const {
  const Eigen::Vector3d middle_W = robot_.X_WWorkspace.translation();
  const double radius_m = robot_.workspace_radius_m + options_.workspace_margin_m;
  return {middle_W - Eigen::Vector3d(radius_m, radius_m, below_m),
          middle_W + Eigen::Vector3d(radius_m, radius_m, kObstacles_m)};
}

trial::Sensed WristScanner::Scan(const sim::World& world) {
  base::Rng rng = Stream("scan");
  ++looks_;
  const base::Pose X_WS = world.SitePose("wrist_scanner");
  sensing::Scan scan = sensing::ScanScene(world.VisualMeshes(), X_WS, scanner_, rng);
  // Points measured in the sensor's frame appear where the robot believes the sensor to be.
  const base::Pose X_move = X_WS * X_SBelieved_ * X_WS.inverse();
  trial::Sensed sensed{geometry::ObservationOf({}), {std::move(scan.truth)}};
  sensed.observation.views.front() = Moved(std::move(scan.view), X_move);
  return sensed;
}

Refinement WristScanner::Add(trial::Sensed look, trial::Sensed& to) const {
  const Eigen::AlignedBox3d box_W = AroundWorkspace(0.05);
  // The first view is from the cell's scanner, with its own calibration error.
  const sensing::LineScannerOptions fixed;
  const sensing::RangeSensorOptions& scanner = sensing::SharedOf(scanner_);
  const auto rms = [](std::initializer_list<double> parts) {
    double sum = 0.0;
    for (const double part : parts) sum += part * part;
    return std::sqrt(sum);
  };
  RefineOptions refine;
  refine.shift_error_m =
      rms({mount_error_m_, scanner.calibration_sigma_m, fixed.calibration_sigma_m,
           fixed.calibration_sigma_rad * kFixedDistance_m});
  refine.turn_error_rad =
      rms({mount_error_rad_, scanner.calibration_sigma_rad, fixed.calibration_sigma_rad});
  geometry::View& view = look.observation.views.front();
  const Refinement refinement = Refine(to.observation, view, box_W, refine);
  to.observation.views.push_back(Moved(std::move(view), refinement.X_by));
  to.truth.push_back(std::move(look.truth.front()));
  return refinement;
}

std::optional<trial::LookRecord> WristScanner::AddBestView(const Eigen::AlignedBox3d& region_W,
                                                           sim::World& world, Eigen::VectorXd& q,
                                                           trial::Sensed& to) {
  const ViewRequest request{region_W, AroundWorkspace(0.0), sensing::FieldOf(scanner_),
                            *robot_.X_HWristScanner, q};
  base::Rng rng = Stream("next");
  const auto look =
      NextBestView(robot_, to.observation, request, look_.next, options_.planning, rng);
  if (!look) return std::nullopt;
  const sim::MoveLog move = sim::MoveArm(world, look->way);
  q = move.arrived ? look->q : world.ArmPositions();
  trial::LookRecord record{look->gain_m3, look->unseen_m3, move.simulated_s, move.arrived};
  if (!move.arrived) return record;
  const Refinement refinement = Add(Scan(world), to);
  record.refined = refinement.refined;
  record.deviations = refinement.deviations;
  record.sigma_m = refinement.sigma_m;
  record.pairs = refinement.pairs;
  return record;
}

trial::LookedAround AddWristViews(const trial::Cell& cell, trial::Sensed first, sim::World& world,
                                  std::uint64_t seed, const trial::Promise& promise) {
  trial::LookedAround around{std::move(first), cell.robot.home, {}};
  WristScanner wrist(cell.options, cell.robot, seed);
  const auto& options = trial::Of<WristViewOptions>(cell.options, kWristViews);
  for (int view = 1; view < options.views; ++view) {
    if (promise && options.until_probability < 1.0 &&
        promise(around.sensed) >= options.until_probability) {
      break;
    }
    const auto region_W = wrist.RegionOfHighest(around.sensed.observation);
    if (!region_W) break;
    const auto look = wrist.AddBestView(*region_W, world, around.q, around.sensed);
    if (!look) break;
    around.looks.push_back(*look);
    if (!look->arrived) break;
  }
  return around;
}

}  // namespace rangegrasp::views
