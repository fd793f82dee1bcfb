#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/world.h"

namespace rangegrasp::sim {

/// Known friction of the glove on a surface: the static coefficient's range, its middle, and the
/// kinetic coefficient that belongs to the middle.
struct GloveRange {
  double middle = 0.6, low = 0.45, high = 0.8;
  double kinetic = 0.5;
};

/// The surface of the scene, which the glove may also touch: the table's laminate.
inline constexpr std::string_view kTableSurface = "laminate";

/// The glove's friction pair on a surface, as the options choose it. A drawn one depends on a
/// random u from 0 to 1, by which the static coefficient is distributed triangularly over its range
/// with the middle as mode; without u it is the middle. The kinetic coefficient keeps its tabulated
/// ratio to the static one. glove_friction overrides both.
FrictionPair GloveFriction(const GloveRange& range, const PhysicsOptions& options,
                           std::optional<double> u = {});

/// Whether a contact slides, with hysteresis. Sliding starts at 1 mm/s (held contacts creep at
/// 0.016 mm/s, a dropped object reaches 20 mm/s in one step) and ends below half of that. A contact
/// that is briefly lost (a sliding body chatters) has not stuck.
struct SlipState {
  bool sliding = false;

  /// @param speed_m_s  tangential speed of the fastest contact; negative if there is no contact.
  void Update(double speed_m_s) {
    if (speed_m_s > 0.001) sliding = true;
    if (speed_m_s >= 0.0 && speed_m_s < 0.0005) sliding = false;
  }
  double Coefficient(const FrictionPair& pair) const {
    return sliding ? pair.kinetic_mu : pair.static_mu;
  }
};

/// Known properties of a kind of surface. An object names one in its custom text "surface".
struct Surface {
  std::string name;
  GloveRange glove;                        ///< friction of the hand's PVC glove on it
  FrictionPair on_laminate;                ///< its friction on the table's laminate
  OpticalSurface optical;                  ///< used if an object's file gives none
  double specular = 0.2, shininess = 0.3;  ///< in pictures, for an object made of a mesh
  double density_kg_m3 = 900.0;            ///< of such an object if no mass is given
};

/// Bounds of an object's density: foam, and what only the heaviest metals exceed.
inline constexpr double kMinDensity_kg_m3 = 20.0, kMaxDensity_kg_m3 = 12000.0;

std::filesystem::path ShippedSurfaces();  ///< models/surfaces.yaml of the data folder

/// The files in which an object's surface is looked up, in this order: surfaces.yaml in its folder,
/// in the parent folder, and the shipped one. Those that are not there are left out.
std::vector<std::filesystem::path> SurfaceFiles(const std::filesystem::path& object_mjcf);

/// Reads a file of surfaces: a mapping for each name.
/// @throws base::InputError naming file, line, key and what is expected.
std::vector<Surface> ReadSurfaces(const std::filesystem::path& file);

/// All surfaces that an object may name. Of two with the same name, the one looked up first counts.
std::vector<Surface> SurfacesFor(const std::filesystem::path& object_mjcf);

/// @throws base::InputError naming the surface and the known ones.
const Surface& FindSurface(const std::vector<Surface>& surfaces, std::string_view name);

}  // namespace rangegrasp::sim
