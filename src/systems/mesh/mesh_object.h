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

/// Unit of a mesh file's coordinates. Only glTF defines its own (metres).
enum class LengthUnit { kMm, kCm, kM, kInch };
constexpr std::array<std::string_view, 4> WordsOf(LengthUnit) { return {"mm", "cm", "m", "inch"}; }

/// A unit's length [m].
double MetersOf(LengthUnit unit);

/// Guesses the unit (mm, cm or m) in which a file's longest edge has a likely size: 20 mm (a die)
/// to 400 mm (a bottle). Of two units it chooses the one with a size nearer to 100 mm by ratio.
std::optional<LengthUnit> GuessUnit(double longest);

/// Maximum distance of a part's hull from the solid, as a share of half its longest edge: 2.5 mm
/// for 100 mm. Smaller values give more parts, which are slower to compute and to simulate.
inline constexpr double kConcavity = 0.05;

/// Approximate convex decomposition (CoACD; Wei et al. 2022): closed hulls, faces outward, in the
/// solid's frame and unit. The same solid gives the same bytes, on any number of cores.
/// @param solid  from geometry::RepairMesh.
/// @throws base::RunError with instructions to install CoACD's library if it is missing.
std::vector<geometry::TriangleMesh> ConvexParts(const geometry::TriangleMesh& solid,
                                                double concavity = kConcavity);

/// Whether CoACD's library is installed.
bool CanCut();

/// The axis of a file that points up.
enum class Up { kZ, kY, kX };
constexpr std::array<std::string_view, 3> WordsOf(Up) { return {"z", "y", "x"}; }

struct MeshObjectOptions {
  std::optional<LengthUnit> unit;   ///< default: guessed
  std::optional<double> longest_m;  ///< longest edge of the bounding box; overrides the unit
  std::optional<Up> up;             ///< default: z; for glTF y, by its standard
  std::optional<double> mass_kg;    ///< overrides the density
  double density_kg_m3 = 900.0;
  double max_hole = geometry::kMaxHole;  ///< geometry::RepairMesh
};

/// An object made from a mesh: a solid in the object's frame O, z up, with its origin at the center
/// of the bounding box.
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
  std::vector<std::string> said;  ///< guesses and repairs, one sentence each
};

/// Reads, scales and repairs a mesh, computes its mass, and decomposes it into convex parts.
/// @param keep_uv  keeps the file's texture coordinates
/// @throws base::InputError naming the file and why it cannot become an object; also if it has no
/// texture coordinates to keep.
MeshObject MakeMeshObject(const std::filesystem::path& file, const MeshObjectOptions& options,
                          bool keep_uv = false);

/// Properties in an object's file other than its shape.
struct ObjectLook {
  std::string name;   ///< letters, digits and '_'
  std::string title;  ///< in tables
  sim::Surface surface;
  std::string texture_png;  ///< contents of a PNG file; may be empty
};

/// Converts a file name to an object name: letters, digits and '_'.
std::string ObjectNameFrom(const std::string& text);

/// Contents of the files of an object's folder by file name: MJCF and meshes, as in models/objects.
std::map<std::string, std::string> ObjectFiles(const MeshObject& object, const ObjectLook& look);

}  // namespace rangegrasp::objects
