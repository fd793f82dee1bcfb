#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <ranges>

#include "base/units.h"
#include "base/words.h"
#include "perception/perceive.h"
#include "surveys/task/measures.h"

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
  const auto sensed = trial::Look(cell, scene.world, seed);
  base::Rng rng = trial::StageStream(seed, "perceive");
  const auto perceived =
      perception::Perceive(sensed.observation, cell.options.perception, rng,
                           trial::WorkspaceOf(cell.robot, cell.options.workspace_margin_m));
  seconds = perceived.seconds;
  const auto* object = perceived.objects.empty() ? nullptr : &perceived.objects.front();
  const auto X_WO = scene.world.ObjectPose(scene.target);
  const Vector3d axis_W = X_WO.linear().col(2);
  ordered_json data = {{"pose", PoseOf(axis_W)},
                       {"kind", object ? base::Word(object->kind) : "nothing"}};
  if (object && object->kind == perception::ObjectKind::kRotational) {
    const auto& axis = *object->axis;
    data["axis_error_rad"] = std::acos(std::min(1.0, std::abs(axis.direction_C.dot(axis_W))));
    data["center_error_m"] = (axis.center_C - X_WO.translation()).cross(axis_W).norm();
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
