#include "perception/doubts.h"

#include <fmt/format.h>

#include <cmath>

#include "base/units.h"

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
// If the sensor's position is closer to the table, noise decides on which side of it it is.
constexpr double kMinHeight_m = 0.02;

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

std::vector<std::string> Doubts(const Scene& scene, const std::string& of_origin,
                                const Cures& cures) {
  std::vector<std::string> doubts;
  const std::string of_unit = DoubtOfUnit(scene.sampling.spacing_m, cures);
  if (!of_unit.empty()) doubts.push_back(of_unit);
  if (!of_origin.empty()) {
    doubts.push_back(of_origin);
    if (std::abs(scene.table.plane.Distance(Eigen::Vector3d::Zero())) < kMinHeight_m) {
      doubts.push_back("0,0,0 lies in the table's plane, so its upper side is not known: " +
                       cures.upper_side);
    }
  }
  if (scene.objects.empty()) {
    doubts.push_back(fmt::format("no objects: {} of {} points are above the table",
                                 scene.cloud.size(), scene.points_C.size()));
  }
  if (of_unit.empty()) DoubtObjects(scene, cures, doubts);
  return doubts;
}

}  // namespace rangegrasp::perception
