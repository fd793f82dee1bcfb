#pragma once

#include "experiment/task.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

/// Renumbers labels so that they get the colors of `reference`. Each becomes the reference label
/// with which it shares most faces, largest overlaps first, none used twice. The remaining ones get
/// new numbers.
/// @param labels, reference  >= 0, of equal length
Labels MatchedLabels(const Labels& labels, const Labels& reference);

/// `task: parts`: compares segmentation methods with segmentations by people (chapter 6, figures
/// 6.19-6.22, table 6.1). A case is one method on one model, e.g. "cup-0021-mirror"; its group is
/// the model's class.
const experiment::TaskKind& PartsTask();

}  // namespace rangegrasp::parts
