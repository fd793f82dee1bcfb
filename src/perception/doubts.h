#pragma once

#include <span>
#include <string>
#include <vector>

#include "perception/scene.h"

namespace rangegrasp::perception {

/// What a caller of Perceive can do about a doubt, in the words of its own interface: an option of
/// the command line, an argument of a function.
struct Cures {
  std::string smaller_unit;  ///< for points too far apart: "try --unit mm"
  std::string larger_unit;   ///< for points too close together: "try --unit m"
  std::string sensor;        ///< if the sensor is too far away
  std::string upper_side;    ///< if the table's upper side is not known
  std::string other_things;  ///< if something else than objects on a table was perceived
  std::string noise;         ///< if the noise cannot be measured
};

/// Why points this far apart (Sampling::spacing_m) are not those of a tabletop in metres; empty if
/// they may be.
std::string DoubtOfUnit(double spacing_m, const Cures& cures);

/// Why the sensor's position is in doubt: it is so far from the points that it is in another unit;
/// empty if it may be right. Only if the points' unit is not in doubt. O(n).
std::string DoubtOfDistance(geometry::PointSpan points_C, const Eigen::Vector3d& sensor_C,
                            const Cures& cures);

/// Why the table's upper side is in doubt: the sensor lies in the table's plane or below it; empty
/// if it lies above.
std::string DoubtOfSide(const geometry::Plane& table, const Eigen::Vector3d& sensor_C,
                        const Cures& cures);

/// Reasons to doubt a scene, a sentence each, without its period: the unit, the sensor's position,
/// the noise, no objects, objects that are none. Sizes and noise are not judged if the unit is in
/// doubt. O(objects).
/// @param sensor_C        the sensor's position, assumed or known
/// @param of_origin       says that it was assumed; empty if it is known
/// @param noise_is_given  the scene's noise was not measured
std::vector<std::string> Doubts(const Scene& scene, const Eigen::Vector3d& sensor_C,
                                const std::string& of_origin, bool noise_is_given,
                                const Cures& cures);

/// Sets to NaN what stands for points that were not measured: points at exactly 0,0,0 or at the
/// sensor's position. Of more than 64 points in any other place, e.g. 0,0,0 that was moved into
/// another frame, one is kept. The search for neighbors would take quadratic time. O(n log n).
/// @return a warning for each kind that occurs, without its period
std::vector<std::string> LeaveOutUnmeasured(const Eigen::Vector3d& sensor_C,
                                            geometry::Points& points_C);

/// The interface that states a crop, for its errors.
struct CropWords {
  std::string name;  ///< of the option or argument: "--crop"
  std::string unit;  ///< if no point is inside: "another unit: --unit"
};

/// Sets the points outside a box to NaN.
/// @param corners_m  x,y,z of the low corner, then of the high one
/// @param clouds_C   e.g. one per view
/// @throws base::InputError if these are not corners of a box or no point is inside.
void Crop(std::span<const double> corners_m, const CropWords& words,
          std::span<geometry::Points* const> clouds_C);

}  // namespace rangegrasp::perception
