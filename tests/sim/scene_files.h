#pragma once

#include <filesystem>
#include <string>

#include "sim/world.h"

namespace rangegrasp::sim::samples {

/// Writes a file into the tests' temporary folder and returns its path.
std::filesystem::path WriteFile(const std::string& name, const std::string& text);

/// A plane with the friction of laminate, tilted about y by an angle [rad] (downhill is +x).
std::filesystem::path PlaneScene(double tilt_rad = 0.0);

/// An object with these collision geoms and the surface "cardboard".
ObjectModel MakeObject(const std::string& name, const std::string& geoms);

/// An object of the repository; Tabletop() is its scene.
ObjectModel RepositoryObject(const std::string& name);
std::filesystem::path Tabletop();

}  // namespace rangegrasp::sim::samples
