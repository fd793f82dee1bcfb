#pragma once

#include <vector>

#include "experiment/record.h"
#include "experiment/stamp.h"
#include "experiment/store.h"

namespace rangegrasp::experiment {

/// Makes a store that an earlier part of a run left ready to go on. The same run may have more
/// cases now (more trials of each object): what is stored takes its place among them, so that
/// nothing differs from a run that had them all at once.
/// @param now    stamp of what goes on
/// @param cases  all of its cases, whatever the shard
/// @return the stamp to write: `now`, but with the commit that began the run; a commit that differs
/// from it is added to "resumed_with".
/// @throws base::InputError naming the folder if it is another run's, or holds a case that is not
/// among `cases`; nothing is changed then.
Stamp Resume(Store& store, const Stamp& now, const std::vector<Case>& cases);

}  // namespace rangegrasp::experiment
