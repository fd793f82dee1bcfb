#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/visual_mesh.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// What is known of the glove's friction on a surface: the static coefficient's range, its middle,
/// and the kinetic coefficient that goes with the middle.
struct GloveRange {
  double middle = 0.6, low = 0.45, high = 0.8;
  double kinetic = 0.5;
};

/// The surface of the scene, which the glove may touch too: the table's laminate.
inline constexpr std::string_view kTableSurface = "laminate";

/// The pair for a draw u from 0 to 1: the static coefficient is triangular over its range with the
/// middle as its mode, the kinetic one in the proportion of the table's two numbers.
FrictionPair DrawnFriction(const GloveRange& range, double u);

/// The glove's pair on a surface as the options choose it; drawn ones by u from 0 to 1, without it
/// the middle of the range. glove_friction overrides both coefficients.
FrictionPair GloveFriction(const GloveRange& range, const PhysicsOptions& options,
                           std::optional<double> u = {});

/// Whether a contact slides, with hysteresis: from 1 mm/s (held contacts creep at 0.016 mm/s, a
/// dropped object reaches 20 mm/s in one step) until it is below half of that. A contact that is
/// lost for a moment (a sliding body chatters) has not stuck.
struct SlipState {
  bool sliding = false;

  /// @param speed_m_s  tangential speed of the fastest contact; negative if there is none.
  void Update(double speed_m_s) {
    if (speed_m_s > 0.001) sliding = true;
    if (speed_m_s >= 0.0 && speed_m_s < 0.0005) sliding = false;
  }
  double Coefficient(const FrictionPair& pair) const {
    return sliding ? pair.kinetic_mu : pair.static_mu;
  }
};

/// What is known of a kind of surface: an object names one in its custom text "surface".
struct Surface {
  std::string name;
  GloveRange glove;                        ///< friction of the hand's PVC glove on it
  FrictionPair on_laminate;                ///< it on the table's laminate
  OpticalSurface optical;                  ///< where an object's file does not say
  double specular = 0.2, shininess = 0.3;  ///< of pictures, where an object is made of a mesh
  double density_kg_m3 = 900.0;            ///< of such an object, where no mass is given
};

std::filesystem::path ShippedSurfaces();  ///< models/surfaces.yaml of the data folder

/// Where the surface of an object is looked up, in this order: surfaces.yaml in its folder, in that
/// folder's folder, and the shipped one. Those that exist.
std::vector<std::filesystem::path> SurfaceFiles(const std::filesystem::path& object_mjcf);

/// A file of surfaces: a mapping for each name.
/// @throws base::InputError naming file, line, key and what would be right.
std::vector<Surface> ReadSurfaces(const std::filesystem::path& file);

/// All that an object may name; of two with the same name the one that is looked up first.
std::vector<Surface> SurfacesFor(const std::filesystem::path& object_mjcf);

/// @throws base::InputError naming the surface and those that there are.
const Surface& FindSurface(const std::vector<Surface>& surfaces, std::string_view name);

}  // namespace rangegrasp::sim
