#pragma once

#include "experiment/task.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

/// Labels of the same faces in the colors of others: each of them becomes that one of `reference`
/// with which it shares most faces, none twice, the largest shares first; what is left over becomes
/// new ones.
/// @param labels, reference  >= 0, as many
Labels MatchedLabels(const Labels& labels, const Labels& reference);

/// `task: parts`: methods that segment an object against the segmentations of people (chapter 6,
/// figures 6.19-6.22, table 6.1). A case is one method on one model, e.g. "cup-0021-mirror"; its
/// group is the model's class.
const experiment::TaskKind& PartsTask();

}  // namespace rangegrasp::parts
