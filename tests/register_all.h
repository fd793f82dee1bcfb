#pragma once

#include "trial/registry.h"

namespace rangegrasp {

/// Of the systems that are built; CMake writes it (cmake/RangegraspSystems.cmake).
void RegisterSystems();

/// The core and all systems know each other's words.
inline void RegisterAll() {
  RegisterTrial();
  RegisterSystems();
}

}  // namespace rangegrasp
