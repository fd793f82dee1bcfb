#pragma once

#include <filesystem>
#include <string>

#include "sim/world.h"

namespace rangegrasp::sim::samples {

/// Writes a file into the tests' temporary folder and returns its path.
std::filesystem::path WriteFile(const std::string& name, const std::string& text);

/// A horizontal plane, or one that is tilted about y by an angle [rad] (downhill is +x), with the
/// friction of laminate.
std::filesystem::path PlaneScene(double tilt_rad = 0.0);

/// An object whose collision geometry is these geoms; surface "cardboard".
ObjectModel MakeObject(const std::string& name, const std::string& geoms);

/// An object and the scene of the repository.
ObjectModel RepositoryObject(const std::string& name);
std::filesystem::path Tabletop();

}  // namespace rangegrasp::sim::samples
