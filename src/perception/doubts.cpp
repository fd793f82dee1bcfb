#include "perception/doubts.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/units.h"
#include "base/words.h"
#include "geometry/mesh.h"

namespace rangegrasp::perception {
namespace {

// A larger object does not fit on a table or in a hand.
constexpr double kMaxObject_m = 0.6;
// An object with a larger share of the points is the table or the room.
constexpr double kMaxShare = 1.0 / 3.0;
// If the points of a tabletop are further apart, they are in another unit.
constexpr double kMaxSpacing_m = 0.05;
// If the points are closer than those of any sensor, they are in another unit.
constexpr double kMinSpacing_m = 2e-5;
// A sensor that is further from the points does not see objects on a table. In millimetres or
// centimetres, most positions are further away.
constexpr double kMaxDistance_m = 20.0;
// If the sensor's position is closer to the table, noise decides on which side of it it is.
constexpr double kMinHeight_m = 0.02;
// If a table is flatter, its points were computed: no sensor has so little noise.
constexpr double kMinNoise_m = 5e-6;
// Points in one place. A neighborhood has so many (SamplingOptions::neighbors); more say nothing
// about a surface.
constexpr std::size_t kMaxInOnePlace = 64;

// Appends the doubts about the objects' sizes and shares of the points.
void DoubtObjects(const Scene& scene, const Cures& cures, std::vector<std::string>& doubts) {
  const auto points = static_cast<double>(scene.points_C.size());
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const auto& object = scene.objects[i];
    const double size_m = object.size_m.maxCoeff();
    const double share = static_cast<double>(object.points.size()) / points;
    if (size_m > kMaxObject_m) {
      doubts.push_back(
          fmt::format("object {} is {:.2f} m long: too large for a hand or a table; {}", i + 1,
                      size_m, cures.other_things));
    }
    if (share > kMaxShare) {
      doubts.push_back(
          fmt::format("object {} has {:.0f} % of all points: too many for an object on a table; {}",
                      i + 1, 100.0 * share, cures.other_things));
    }
  }
}

std::string Place(const Eigen::Vector3d& p) {
  return fmt::format("{:g},{:g},{:g}", p.x(), p.y(), p.z());
}

void SetNaN(Eigen::Vector3d& p) { p.setConstant(std::numeric_limits<double>::quiet_NaN()); }

// Sets all points in a place to NaN; returns their number.
std::size_t LeaveOutAt(const Eigen::Vector3d& place_C, geometry::Points& points_C) {
  std::size_t count = 0;
  for (Eigen::Vector3d& p : points_C) {
    if (p != place_C) continue;
    SetNaN(p);
    ++count;
  }
  return count;
}

// Keeps one of more than kMaxInOnePlace points in one place; returns the number of the others.
std::size_t LeaveOutTwins(geometry::Points& points_C) {
  const auto finite =
      geometry::PositionsWhere(points_C, [](const Eigen::Vector3d& p) { return p.allFinite(); });
  const geometry::Points measured = geometry::Select(points_C, finite);
  const auto twin = geometry::FirstTwin(measured, geometry::CanonicalOrder(measured));
  std::vector<std::size_t> in_place(measured.size(), 0);
  for (const std::uint32_t first : twin) ++in_place[first];
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < twin.size(); ++i) {
    if (twin[i] == i || in_place[twin[i]] <= kMaxInOnePlace) continue;
    SetNaN(points_C[finite[i]]);
    ++count;
  }
  return count;
}

// The box of a crop.
Eigen::AlignedBox3d BoxOf(std::span<const double> corners_m, const std::string& name) {
  if (corners_m.size() != 6) {
    throw base::InputError(fmt::format(
        "{} must be six numbers, x,y,z of the low and x,y,z of the high corner in metres, not {}",
        name, corners_m.size()));
  }
  const Eigen::Map<const Eigen::Vector3d> low(corners_m.data()), high(corners_m.data() + 3);
  if (!(low.array() < high.array()).all()) {
    throw base::InputError(name + ": the first three numbers must be below the last three");
  }
  return {Eigen::Vector3d(low), Eigen::Vector3d(high)};
}

}  // namespace

std::string DoubtOfUnit(double spacing_m, const Cures& cures) {
  if (spacing_m > kMaxSpacing_m) {
    return fmt::format("the points are {:.1f} m apart: {}", spacing_m, cures.smaller_unit);
  }
  if (spacing_m > 0.0 && spacing_m < kMinSpacing_m) {
    return fmt::format("the points are {:.4f} mm apart: {}", spacing_m * base::kMmPerM,
                       cures.larger_unit);
  }
  return "";
}

std::string DoubtOfDistance(geometry::PointSpan points_C, const Eigen::Vector3d& sensor_C,
                            const Cures& cures) {
  if (points_C.empty()) return "";
  const double distance_m = geometry::BoundsOf(points_C).exteriorDistance(sensor_C);
  if (distance_m <= kMaxDistance_m) return "";
  return fmt::format("the sensor is {:.0f} m from the cloud: {}", distance_m, cures.sensor);
}

std::string DoubtOfSide(const geometry::Plane& table, const Eigen::Vector3d& sensor_C,
                        const Cures& cures) {
  const double height_m = table.Distance(sensor_C);
  if (height_m >= kMinHeight_m) return "";
  if (height_m <= -kMinHeight_m) {
    return fmt::format("the sensor at {} lies {:.2f} m below the table: {}", Place(sensor_C),
                       -height_m, cures.upper_side);
  }
  return fmt::format("{} lies in the table's plane, so its upper side is not known: {}",
                     Place(sensor_C), cures.upper_side);
}

std::vector<std::string> Doubts(const Scene& scene, const Eigen::Vector3d& sensor_C,
                                const std::string& of_origin, bool noise_is_given,
                                const Cures& cures) {
  std::vector<std::string> doubts;
  const auto add = [&](const std::string& doubt) {
    if (!doubt.empty()) doubts.push_back(doubt);
  };
  const std::string of_unit = DoubtOfUnit(scene.sampling.spacing_m, cures);
  add(of_unit);
  add(of_origin);
  if (of_unit.empty()) add(DoubtOfDistance(scene.points_C, sensor_C, cures));
  add(DoubtOfSide(scene.table.plane, sensor_C, cures));
  if (scene.objects.empty()) {
    add(fmt::format("no objects: {} of {} points are above the table", scene.cloud.size(),
                    scene.points_C.size()));
  }
  if (!of_unit.empty()) return doubts;
  // Without a spacing there were too few points to measure noise.
  const bool noise_is_measured = !noise_is_given && scene.sampling.spacing_m > 0.0;
  if (noise_is_measured && scene.sampling.noise_m < kMinNoise_m) {
    add("the table is exactly flat (computed?): its noise says nothing about the objects; " +
        cures.noise);
  }
  DoubtObjects(scene, cures, doubts);
  return doubts;
}

std::vector<std::string> LeaveOutUnmeasured(const Eigen::Vector3d& sensor_C,
                                            geometry::Points& points_C) {
  std::vector<std::string> warnings;
  for (const Eigen::Vector3d& place_C : {Eigen::Vector3d(Eigen::Vector3d::Zero()), sensor_C}) {
    const std::size_t count = LeaveOutAt(place_C, points_C);
    if (count == 0) continue;
    warnings.push_back(fmt::format("{} at {} {} left out as not measured",
                                   base::Counted(static_cast<std::int64_t>(count), "point"),
                                   Place(place_C), count == 1 ? "is" : "are"));
  }
  if (const std::size_t count = LeaveOutTwins(points_C); count > 0) {
    warnings.push_back(
        fmt::format("{} points are left out: each has exactly the coordinates of another", count));
  }
  return warnings;
}

void Crop(std::span<const double> corners_m, const CropWords& words,
          std::span<geometry::Points* const> clouds_C) {
  const Eigen::AlignedBox3d box = BoxOf(corners_m, words.name);
  bool any = false;
  std::size_t count = 0;
  Eigen::AlignedBox3d all;
  for (geometry::Points* points_C : clouds_C) {
    count += points_C->size();
    for (auto& p : *points_C) {
      if (p.allFinite()) all.extend(p);
      const bool inside = box.contains(p);
      if (!inside) p.setConstant(std::numeric_limits<double>::quiet_NaN());
      any = any || inside;
    }
  }
  if (!any) {
    throw base::InputError(fmt::format(
        "{}: the box contains none of the {} points, which are from {:.3g},{:.3g},{:.3g} to "
        "{:.3g},{:.3g},{:.3g} m ({})",
        words.name, count, all.min().x(), all.min().y(), all.min().z(), all.max().x(),
        all.max().y(), all.max().z(), words.unit));
  }
}

}  // namespace rangegrasp::perception
