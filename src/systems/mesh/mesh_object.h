#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/mass_properties.h"
#include "geometry/mesh.h"
#include "mesh/convex_parts.h"
#include "mesh/length_unit.h"
#include "mesh/repair.h"

namespace rangegrasp::objects {

/// Which of a file's axes points up.
enum class Up { kZ, kY, kX };
constexpr std::array<std::string_view, 3> WordsOf(Up) { return {"z", "y", "x"}; }

struct MeshObjectOptions {
  std::optional<LengthUnit> unit;   ///< guessed where not given
  std::optional<double> height_m;   ///< along the axis that points up, whatever the unit
  std::optional<double> longest_m;  ///< longest edge of the box round it, whatever the unit
  double scale = 1.0;               ///< after the unit
  std::optional<Up> up;             ///< z where not given; y of glTF, which says so
  std::optional<double> mass_kg;    ///< goes before density
  double density_kg_m3 = 900.0;
  /// What is seen has at most so many triangles: 0.5 mm each on an object of 100 mm.
  std::size_t max_seen_triangles = 40000;
  geometry::RepairOptions repair;
  CutOptions cut;
  double max_beyond = 0.1;  ///< hulls that stand out by more of the volume are cut again, finer
  SizeRange sizes;
};

/// What a mesh became: a solid in the object's frame O, whose origin is the middle of the box round
/// it, z up.
struct MeshObject {
  geometry::TriangleMesh seen_O;
  std::vector<std::array<Eigen::Vector2d, 3>> uv;  ///< of the corners of seen_O; may be empty
  std::vector<geometry::TriangleMesh> hulls_O;
  geometry::Overlap overlap;  ///< of the hulls with the solid
  Eigen::Vector3d size_m;
  double mass_kg = 0.0;
  double volume_m3 = 0.0;
  Eigen::Vector3d center_O;       ///< of mass [m]
  Eigen::Matrix3d inertia_O;      ///< about the center of mass, along the axes of O [kg m^2]
  std::vector<std::string> said;  ///< what was guessed or repaired, a sentence each
};

/// Reads, scales, repairs, weighs and cuts a mesh.
/// @param keep_uv  texture coordinates: the file's, else the mesh is unrolled round its z axis.
/// @throws base::InputError naming the file and why it cannot become an object.
MeshObject MakeMeshObject(const std::filesystem::path& file, const MeshObjectOptions& options,
                          bool keep_uv = false);

}  // namespace rangegrasp::objects
