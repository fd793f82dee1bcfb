#pragma once

#include "trial/registry.h"

namespace rangegrasp {

/// Registers the systems that are built. CMake generates it (cmake/RangegraspSystems.cmake).
void RegisterSystems();

/// Registers the words of the core and of all systems.
inline void RegisterAll() {
  RegisterTrial();
  RegisterSystems();
}

}  // namespace rangegrasp
