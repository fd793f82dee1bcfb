#pragma once

#include <vector>

#include "perception/internal/part.h"

namespace rangegrasp::perception::internal {

/// Merging of clipped rotational parts (section 5.1.3, eq. 5.6 to 5.8), pairwise until nothing
/// changes: two parts become one if the union is rotational (so at least the body share of all
/// points of both agrees with their sections), at least the rim share of each part's rim points
/// lies on its circle, and at least half of each part's body agrees. The first of the pair keeps
/// its place.
void MergeRotational(const ObjectContext& context, std::vector<Part>& parts, base::Rng& rng);

}  // namespace rangegrasp::perception::internal
