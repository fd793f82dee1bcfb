#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/rng.h"
#include "geometry/point_cloud.h"
#include "geometry/ray_caster.h"
#include "recognition/model_shape.h"

namespace rangegrasp::recognition {

/// Prior knowledge of an object.
struct KnownObject {
  std::string name;
  std::string title;               ///< its everyday name
  geometry::TriangleMesh mesh_B;   ///< its visible surface, in the frame of its body
  geometry::PointCloud surface_B;  ///< evenly sampled from the mesh, with outward normals
  geometry::MeshColors colors;     ///< of its triangles; empty: unknown
  Symmetry symmetry;               ///< of its shape, regardless of its colors
};

/// Samples a mesh evenly and finds its symmetry.
/// @param colors  of the mesh's triangles; may be empty
/// @throws std::invalid_argument naming the object if the mesh is too small (fewer than 4 samples),
/// or the colors belong to another mesh.
KnownObject MakeKnownObject(std::string name, std::string title, geometry::TriangleMesh mesh_B,
                            geometry::MeshColors colors = {});

/// The same object with the errors of an inexact model: every point p is displaced by
///
///   d(p) = s (sum over waves of a sin(k . p + phase) - the mean over the vertices)
///
/// with waves 50 to 100 mm long in random directions, and s such that the displacements of the
/// vertices have the root mean square rms_m [m]. Triangles are split first, so that flat faces
/// bend. Colors stay with their triangles.
geometry::ColoredMesh Distorted(const geometry::ColoredMesh& exact, double rms_m, base::Rng& rng);

/// Source of a task's library: the simulator's own meshes, which no real user has, or less accurate
/// ones.
struct LibraryOptions {
  std::filesystem::path folder;  ///< has NAME/NAME.xml or NAME.stl; empty: the objects' own meshes
  double distortion_m = 0.0;     ///< root mean square (Distorted)
  std::uint64_t seed = 1;        ///< seed of the experiment
};

namespace internal {
struct PreparedObject;
}  // namespace internal

/// Known objects, prepared for recognition. Immutable; copies share their content. In a process
/// that forks, it may be created before or after the fork.
class Library {
 public:
  /// @throws std::invalid_argument if two objects have the same name
  explicit Library(std::vector<KnownObject> objects);

  /// @throws base::InputError listing the known objects if there is no such object.
  const KnownObject& Find(const std::string& name) const;

  const internal::PreparedObject& FindPrepared(const std::string& name) const;  ///< as Find

  /// All, in the order in which they were given.
  const auto& prepared() const { return prepared_; }

 private:
  std::vector<std::shared_ptr<const internal::PreparedObject>> prepared_;
};

}  // namespace rangegrasp::recognition
