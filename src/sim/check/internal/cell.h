#pragma once

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

/// Proposes a home pose: free of contact, out of the scanner's view, the hand near the workspace
/// and pointing down. Empty if none was found. Leaves the joints at the model's own home.
Cure SuggestHome(Model& model);

void CheckBodies(Model& model);    ///< masses, inertias, meshes, visible and collision geoms
void CheckContacts(Model& model);  ///< at home, and pairs that always touch
void CheckCell(Model& model);      ///< options of the engine, table, scanner's view

}  // namespace rangegrasp::check::internal
