#pragma once

#include <string>

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

/// What lies further outside the workspace is not perceived (workspace_margin_mm of experiments).
constexpr double kPerceived_m = 0.15;
constexpr double kMaxHidden = 0.05;  ///< of the workspace, that the arm at home may hide

/// What the scanner sees of the arm, its joints as they are.
struct Seen {
  double hidden = 0.0;      ///< share of the workspace that the arm hides
  bool in_the_way = false;  ///< a part of the arm stands where objects are looked for
  int body = -1;            ///< that does
};
/// Nothing without the sites "workspace" and "scanner".
Seen LookAtWorkspace(Model& model);

/// A home pose: free of contact, out of the scanner's view, the hand near the workspace
/// and pointing down. Empty if none was found. Leaves the joints at the model's own home.
Cure SuggestHome(Model& model);

void CheckBodies(Model& model);    ///< masses, inertias, meshes, what is seen and what collides
void CheckContacts(Model& model);  ///< at home, and pairs that always touch
void CheckCell(Model& model);      ///< options of the engine, table, scanner's view

}  // namespace rangegrasp::check::internal
