#pragma once

#include "experiment/view.h"
#include "parts/metrics/human_score.h"

namespace rangegrasp::parts_task {

/// Labels of the same faces in the colors of others: each of them becomes that one of `reference`
/// with which it shares most faces, none twice, the largest shares first; what is left over becomes
/// new ones.
/// @param labels, reference  >= 0, as many
std::vector<std::int32_t> MatchedLabels(const std::vector<std::int32_t>& labels,
                                        const std::vector<std::int32_t>& reference);

/// A model as a method takes it apart, beside how people do, in matching colors. The model is
/// moved and scaled into a box of 1 m.
/// @param name   of the method
/// @param found  labels of the input's faces; empty: the method found none
experiment::View PartsView(const parts::HumanModel& model, const std::string& name,
                           const std::vector<std::int32_t>& found);

}  // namespace rangegrasp::parts_task
