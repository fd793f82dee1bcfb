#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/point_cloud.h"
#include "geometry/ray_caster.h"
#include "recognition/model_shape.h"

namespace rangegrasp::recognition {

/// What is known of an object before it is looked for.
struct KnownObject {
  std::string name;
  std::string title;               ///< as people call it
  geometry::TriangleMesh mesh_B;   ///< what is seen of it, in the frame of its body
  geometry::PointCloud surface_B;  ///< evenly sampled from the mesh, with outward normals
  geometry::MeshColors colors;     ///< of its triangles; empty: not known
  Symmetry symmetry;               ///< of its shape, whatever its colors
};

/// Samples a mesh evenly and finds its symmetry.
/// @param colors  of the mesh's triangles; may be empty
/// @throws std::invalid_argument naming the object if the mesh is too small to be one (fewer than 4
/// samples), or the colors are of another one.
KnownObject MakeKnownObject(std::string name, std::string title, geometry::TriangleMesh mesh_B,
                            geometry::MeshColors colors = {});

/// Known objects, prepared for recognition. Immutable; a copy shares its content. In a process that
/// forks it may be made before or after.
class Library {
 public:
  /// @throws std::invalid_argument if two have one name
  explicit Library(std::vector<KnownObject> objects);

  /// @throws base::InputError naming the known ones.
  const KnownObject& Find(const std::string& name) const;

  struct Prepared;  ///< internal/prepared_object.h
  const Prepared& prepared() const { return *prepared_; }

 private:
  std::shared_ptr<const Prepared> prepared_;
};

}  // namespace rangegrasp::recognition
