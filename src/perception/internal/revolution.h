#pragma once

#include "perception/internal/completion.h"

namespace rangegrasp::perception::internal {

/// Completes a rotational part (section 5.1.4): the points square to the axis that agree with their
/// section are turned about the axis in the options' steps. One point a section is turned, at the
/// section's radius; turning every one would give the same circles 30 times over. Sections that
/// were not seen lie between their neighbors; the lowest goes on down to the base. The surface is
/// one of revolution, an open container's with its cavity; points off the circles (a handle) are
/// added as convex pieces.
Completion CompleteRotational(const ObjectContext& context, const Part& part, double base_m);

}  // namespace rangegrasp::perception::internal
