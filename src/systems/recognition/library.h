#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/mesh_colors.h"
#include "geometry/point_cloud.h"
#include "recognition/symmetry.h"

namespace rangegrasp::recognition {

/// What is known of an object before it is looked for.
struct KnownObject {
  std::string name;
  std::string title;               ///< as people call it
  geometry::TriangleMesh mesh_B;   ///< what is seen of it, in the frame of its body
  geometry::PointCloud surface_B;  ///< evenly sampled from the mesh, with outward normals
  geometry::MeshColors colors;     ///< of its triangles; empty: not known
  Symmetry symmetry;               ///< of its shape, whatever its colors
  double radius_m = 0.0;           ///< of the ball about symmetry.center_B that holds the mesh
};

struct LibraryOptions {
  double spacing_m = 0.003;  ///< of KnownObject::surface_B
  /// How far beside its base the middle of a body that rests on it may stand, for nobody says what
  /// it weighs where.
  double lying_slack_m = 0.004;
  double yaw_step_rad =
      0.1745;  ///< of the ways to lie that are tried; refining turns by half of it
  double pair_spacing_m = 0.009;  ///< of the points whose pairs are compared with a scene's
  SymmetryOptions symmetry;
};

/// Samples a mesh evenly and finds its symmetry.
/// @param colors  of the mesh's triangles; may be empty
/// @throws std::invalid_argument naming the object if the mesh is too small to be one (fewer than 4
/// samples), or the colors are of another one.
KnownObject MakeKnownObject(std::string name, std::string title, geometry::TriangleMesh mesh_B,
                            const LibraryOptions& options = {}, geometry::MeshColors colors = {});

/// Known objects, made ready to be looked for. Immutable; a copy shares what is in it. In a process
/// that forks it may be made before or after.
class Library {
 public:
  /// @throws std::invalid_argument if two have one name
  explicit Library(std::vector<KnownObject> objects, const LibraryOptions& options = {});

  const std::vector<KnownObject>& objects() const;
  /// @throws base::InputError naming the nearest known one.
  const KnownObject& Find(const std::string& name) const;

  struct Prepared;  ///< internal/prepared.h
  const Prepared& prepared() const { return *prepared_; }

 private:
  std::shared_ptr<const Prepared> prepared_;
};

}  // namespace rangegrasp::recognition
