#pragma once

#include <string>

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

/// Objects further outside the workspace are not perceived (workspace_margin_mm of experiments).
constexpr double kPerceived_m = 0.15;
constexpr double kMaxHidden = 0.05;  ///< share of the workspace that the arm at home may hide

/// What the scanner sees of the arm at its present joint positions.
struct Seen {
  double hidden = 0.0;      ///< share of the workspace that the arm hides
  bool in_the_way = false;  ///< a part of the arm is where objects are looked for
  int body = -1;            ///< the body in the way, or that hides the workspace
};
/// Sees nothing without the sites "workspace" and "scanner".
Seen LookAtWorkspace(Model& model);

/// Proposes a home pose: free of contact, out of the scanner's view, the hand near the workspace
/// and pointing down. Empty if none was found. Leaves the joints at the model's own home.
Cure SuggestHome(Model& model);

void CheckBodies(Model& model);    ///< masses, inertias, meshes, visible and collision geoms
void CheckContacts(Model& model);  ///< at home, and pairs that always touch
void CheckCell(Model& model);      ///< options of the engine, table, scanner's view

}  // namespace rangegrasp::check::internal
