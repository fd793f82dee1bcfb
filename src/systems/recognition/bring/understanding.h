#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "geometry/observation.h"
#include "perception/scene.h"
#include "recognition/library.h"
#include "recognition/recognize.h"

namespace rangegrasp::bring {

/// The program's interpretation of its views. It contains no ground truth.
struct Understanding {
  perception::Scene scene;
  /// For each object of the scene, the known object it was recognized as; nullopt: unknown.
  std::vector<std::optional<recognition::FoundObject>> found;

  /// The position of a known object in scene.objects; nullopt: it is not seen.
  std::optional<std::size_t> Find(const std::string& object) const;
};

/// Inserts a known object: its samples become one object with the model's surface. Its perceived
/// attributes (kind, top, axis) are kept; objects that are mostly part of it are removed.
void PutKnown(const recognition::FoundObject& found, const geometry::TriangleMesh& mesh_B,
              Understanding& understanding);

/// The scene with all known objects inserted, in the scene's order: topmost first.
Understanding Understand(perception::Scene scene,
                         const std::vector<recognition::FoundObject>& found,
                         const recognition::Library& library);

/// The area of the table [m^2] where another object may stand: the space just above it was seen in
/// no view, and no known object stands there. Counted in cells of 10 mm, from 10 mm (the noise of
/// the table) to 40 mm above it.
/// @param radius_m  about middle_C, a point on the table
double HidingArea(const geometry::Observation& observation, const Understanding& understanding,
                  const recognition::Library& library, const Eigen::Vector3d& middle_C,
                  double radius_m);

/// The area of the smallest face of an object's bounding box [m^2], on which it may stand.
double SmallestFootprint(const recognition::KnownObject& object);

}  // namespace rangegrasp::bring
