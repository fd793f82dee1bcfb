#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/mesh.h"
#include "mesh/solid.h"
#include "sim/surfaces.h"

namespace rangegrasp::objects {

/// Unit of a mesh file's numbers. Only glTF says its own (metres).
enum class LengthUnit { kMm, kCm, kM, kInch };
constexpr std::array<std::string_view, 4> WordsOf(LengthUnit) { return {"mm", "cm", "m", "inch"}; }

/// [m]
double MetersOf(LengthUnit unit);

/// The unit (mm, cm or m) that makes `longest` of a file's numbers a likely size, 20 mm (a dice) to
/// 400 mm (a bottle); of two the one that is nearer to 100 mm in proportion.
std::optional<LengthUnit> GuessUnit(double longest);

/// How far a part's hull may stand off from the solid, as a share of half its longest edge: 2.5 mm
/// of 100 mm. Smaller: more parts, slower to cut and to simulate.
inline constexpr double kConcavity = 0.05;

/// Approximate convex decomposition (CoACD; Wei et al. 2022): closed hulls, faces outward, in the
/// solid's frame and unit. The same solid gives the same bytes, on any number of cores.
/// @param solid  as geometry::RepairMesh makes it.
/// @throws base::RunError saying how to install CoACD's library where there is none.
std::vector<geometry::TriangleMesh> ConvexParts(const geometry::TriangleMesh& solid,
                                                double concavity = kConcavity);

/// Whether CoACD's library is there.
bool CanCut();

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
  geometry::RepairOptions repair;
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

/// What an object's file says besides its shape.
struct ObjectLook {
  std::string name;   ///< letters, digits and '_'
  std::string title;  ///< in tables
  sim::Surface surface;
  std::string texture_png;  ///< a PNG's bytes; may be empty
};

/// A file's name as that of an object: letters, digits and '_'.
std::string ObjectNameFrom(const std::string& text);

/// The files of an object's folder by their names, MJCF and meshes as in models/objects.
std::map<std::string, std::string> ObjectFiles(const MeshObject& object, const ObjectLook& look);

}  // namespace rangegrasp::objects
