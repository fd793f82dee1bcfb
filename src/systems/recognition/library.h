#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/rng.h"
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

/// The same object as a model with errors shows it: every point p is displaced by
///
///   d(p) = s (sum over waves of a sin(k . p + phase) - the mean over the vertices)
///
/// with waves 50 to 100 mm long in random directions, and s such that the displacements of the
/// vertices have the root mean square rms_m [m]. Triangles are split first, so that flat faces
/// bend. Colors stay with their triangles.
geometry::ColoredMesh Distorted(const geometry::ColoredMesh& exact, double rms_m, base::Rng& rng);

/// What a task's library is made of: the simulator's own meshes, which no real user has, or what
/// is known less well.
struct LibraryOptions {
  std::filesystem::path folder;  ///< of NAME.stl; empty: the objects' own meshes
  double distortion_m = 0.0;     ///< root mean square (Distorted)
  std::uint64_t seed = 1;        ///< of the experiment
};

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
