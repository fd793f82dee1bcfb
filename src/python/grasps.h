#pragma once

#include "grasp/detector.h"
#include "python/values.h"

namespace rangegrasp::python {

/// A grasp as the class Grasp of the package takes it.
nb::dict DictOf(const grasp::DetectedGrasp& grasp, const robot::HandModel& hand);

/// Frame G of the proposal that puts the hand where the grasp has it, pitch and centering included.
base::Pose ProposedPose(const grasp::DetectedGrasp& grasp, const robot::HandModel& hand);

/// Their positions in the image of their view.
nb::ndarray<nb::numpy, std::int64_t, nb::c_contig> SamplesOf(
    const std::vector<geometry::SampleId>& samples);

/// What a scan says of the work cell: "center", "radius", "max_opening".
void AddWorkspace(const robot::Robot& robot, double margin_m, nb::dict& scan);

}  // namespace rangegrasp::python
