#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/friction.h"
#include "sim/visual_mesh.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// What is known of a kind of surface: an object names one in its custom text "surface".
struct Surface {
  std::string name;
  GloveRange glove;              ///< friction of the hand's PVC glove on it
  FrictionPair on_laminate;      ///< it on the table's laminate
  OpticalSurface optical;        ///< where an object's file does not say
  double specular = 0.2;         ///< of pictures, where an object is made of a mesh
  double shininess = 0.3;        ///< likewise
  double density_kg_m3 = 900.0;  ///< likewise, where no mass is given
};

/// The file that comes with the program: models/surfaces.yaml of the data folder.
std::filesystem::path ShippedSurfaces();

/// The files in which the surface of an object is looked up, in this order: surfaces.yaml in its
/// own folder, in the folder that that stands in, and the shipped one. Those that exist.
std::vector<std::filesystem::path> SurfaceFiles(const std::filesystem::path& object_mjcf);

/// A file of surfaces: a mapping for each name.
/// @throws base::InputError naming file, line, key and what would be right.
std::vector<Surface> ReadSurfaces(const std::filesystem::path& file);

/// All that an object may name; of two with the same name the one that is looked up first.
std::vector<Surface> SurfacesFor(const std::filesystem::path& object_mjcf);

/// @throws base::InputError naming the surface and those that there are.
const Surface& FindSurface(const std::vector<Surface>& surfaces, std::string_view name);

}  // namespace rangegrasp::sim
