#pragma once

#include <string>

#include "sim/world.h"

namespace rangegrasp::sim {

/// The physics engine's version, e.g. "4.0.0".
std::string EngineVersion();

/// What an object is called in tables: the custom text "title" of its MJCF, else its name.
/// @throws base::InputError naming the file if it cannot be parsed.
std::string ObjectTitle(const ObjectModel& object);

}  // namespace rangegrasp::sim
