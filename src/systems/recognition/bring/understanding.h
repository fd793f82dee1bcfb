#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/rng.h"
#include "geometry/observation.h"
#include "perception/scene.h"
#include "recognition/library.h"
#include "recognition/recognize.h"

namespace rangegrasp::bring {

/// What the program makes of what it has seen. Nothing in it is truth.
struct Understanding {
  perception::Scene scene;
  /// One an object of the scene: what it is taken for; nullopt: an unknown one.
  std::vector<std::optional<recognition::FoundObject>> found;

  /// The position in scene.objects of what is taken for an object; nullopt: it is not seen.
  std::optional<std::size_t> Find(const std::string& object) const;
};

/// Puts a known object into the scene: its samples are one object, whose surface is the model's.
/// What was perceived of it (its kind, its top, its axis) is kept; objects that are mostly it go.
void PutKnown(const recognition::FoundObject& found, const geometry::TriangleMesh& mesh_B,
              Understanding& understanding);

/// The scene with all known objects in it, in the scene's order: topmost first.
Understanding Understand(perception::Scene scene,
                         const std::vector<recognition::FoundObject>& found,
                         const recognition::Library& library);

/// The area of the table [m^2] over which nothing was seen, low above it, in any view, and no known
/// object stands: there another one may stand. Counted in cells of 10 mm, from 10 mm (what noise
/// makes of the table) to 40 mm above it.
/// @param radius_m  about middle_C, a place on the table
double HidingArea(const geometry::Observation& observation, const Understanding& understanding,
                  const recognition::Library& library, const Eigen::Vector3d& middle_C,
                  double radius_m);

/// The area of the smallest face of an object's box [m^2]: it may stand on that.
double SmallestFootprint(const recognition::KnownObject& object);

}  // namespace rangegrasp::bring
