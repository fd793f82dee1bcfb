#pragma once

#include <memory>
#include <string>

#include "experiment/task.h"
#include "recognition/bring/bring_run.h"

namespace rangegrasp::bring {

/// `task: bring`: a wanted object among others is looked for, taken and handed over (section 7.2).
/// A case is one run; the group is the wanted object.
const experiment::TaskKind& BringTask();

/// One run of an experiment of that kind, in words while it goes, with pictures if the options ask
/// for them.
/// @param task  of `task: bring`
/// @throws base::InputError if it is of another kind.
experiment::Result BringAloud(const experiment::Task& task, const experiment::Case& which,
                              const std::function<void(const std::string&)>& say,
                              const experiment::ReplayOptions& options);

}  // namespace rangegrasp::bring
