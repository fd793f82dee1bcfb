#pragma once

#include "base/image/image.h"
#include "experiment/view.h"

namespace rangegrasp::report::internal {

/// What the list of cases shows of a view: what was perceived; of what nothing was perceived, the
/// bodies as they stand at first; the first of what is painted; the first diagram's lines.
image::Image ViewPicture(const experiment::View& view);

}  // namespace rangegrasp::report::internal
