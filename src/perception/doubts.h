#pragma once

#include <string>
#include <vector>

#include "perception/scene.h"

namespace rangegrasp::perception {

/// What a caller of Perceive can do about a doubt, in the words of its own interface: an option of
/// the command line, an argument of a function.
struct Cures {
  std::string smaller_unit;  ///< for points too far apart: "try --unit mm"
  std::string larger_unit;   ///< for points too close together: "try --unit m"
  std::string upper_side;    ///< if the table's upper side is not known
  std::string other_things;  ///< if something else than objects on a table was perceived
};

/// Why points this far apart (Sampling::spacing_m) are not those of a tabletop in metres; empty if
/// they may be.
std::string DoubtOfUnit(double spacing_m, const Cures& cures);

/// Reasons to doubt a scene, a sentence each, without its period: the unit, the sensor's position,
/// no objects, objects that are none. Sizes are not judged if the unit is in doubt. O(objects).
/// @param of_origin  says that the sensor was assumed at 0,0,0; empty if its position is known
std::vector<std::string> Doubts(const Scene& scene, const std::string& of_origin,
                                const Cures& cures);

}  // namespace rangegrasp::perception
