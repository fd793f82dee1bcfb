#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <ranges>

#include "base/units.h"
#include "base/words.h"
#include "surveys/task/measures.h"
#include "trial/registry.h"

namespace rangegrasp::surveys {
namespace {

using Eigen::Vector3d;
using experiment::Column;
using nlohmann::ordered_json;

/// Axes within this of the vertical are upright, those within it of the horizontal lying.
constexpr double kStanding_rad = base::Deg(20.0);
/// A perceived axis within this of the model's is correct.
constexpr double kSameAxis_rad = base::Deg(10.0);

const char* PoseOf(const Vector3d& axis_W) {
  const double tilt = std::acos(std::min(1.0, std::abs(axis_W.z())));
  if (tilt < kStanding_rad) return "upright";
  return tilt > 0.5 * base::kPi - kStanding_rad ? "lying" : "leaning";
}

}  // namespace

ordered_json MeasureRotation(const trial::Cell& cell, const trial::Arrangement& scene,
                             std::uint64_t seed, Seconds& seconds) {
  std::optional<perception::PerceivedObject> object;
  std::map<std::string, int> free_grasps;
  const auto look = [&](const perception::Scene& perceived, const std::vector<grasp::Grasp>& grasps,
                        const geometry::Observation&) {
    seconds = perceived.seconds;
    if (!perceived.objects.empty()) object = perceived.objects.front();
    for (const auto& g : grasps) {
      free_grasps[std::string(base::Word(g.type))] += g.collides ? 0 : 1;
    }
  };
  const auto sensed = trial::Look(cell, scene.world, seed);
  base::Rng rng = trial::StageStream(seed, "perceive");
  MakeDetector(cell.options, cell.robot, look)->Detect(sensed.observation, rng);

  const auto X_WO = scene.world.ObjectPose(scene.target);
  const Vector3d axis_W = X_WO.linear().col(2);
  ordered_json data = {{"pose", PoseOf(axis_W)},
                       {"kind", object ? base::Word(object->kind) : "nothing"},
                       {"open", object && object->open},
                       {"free_grasps", free_grasps}};
  if (object && object->kind == perception::ObjectKind::kRotational) {
    const auto& axis = *object->axis;
    data["axis_error_rad"] = std::acos(std::min(1.0, std::abs(axis.direction_C.dot(axis_W))));
    data["center_error_m"] = (axis.center_C - X_WO.translation()).cross(axis_W).norm();
    data["radius_m"] = axis.radius_m;
    data["rim_fraction"] = axis.rim_fraction;
    data["body_fraction"] = axis.body_fraction;
  }
  return data;
}

experiment::Section RotationTable(const std::vector<Measured>& scans) {
  struct Row {
    std::string object, pose;
    int scans = 0, rotational = 0, right_axis = 0;
  };
  std::map<std::pair<std::string, std::string>, Row> counted;
  for (const auto& [record, data] : scans) {
    const std::string pose = data.at("pose");
    Row& row = counted[{record->which.group, pose}];
    row.object = record->which.group;
    row.pose = pose;
    ++row.scans;
    row.rotational += data.contains("axis_error_rad") ? 1 : 0;
    row.right_axis += data.value("axis_error_rad", base::kPi) < kSameAxis_rad ? 1 : 0;
  }
  const std::vector<Column<Row>> columns = {
      {"object", "", &Row::object, experiment::kLeft},
      {"pose of its z axis", "", &Row::pose, experiment::kLeft},
      {"scans", "", &Row::scans},
      {"rotational", "", &Row::rotational},
      {"95 %", "", [](const Row& r) { return experiment::IntervalText(r.rotational, r.scans); }},
      {"about that axis", "", &Row::right_axis}};
  return {"Objects perceived as rotational", GridOf(columns, std::views::values(counted))};
}

}  // namespace rangegrasp::surveys
