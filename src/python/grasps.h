#pragma once

#include "grasp/detector.h"
#include "python/values.h"

namespace rangegrasp::python {

/// A grasp as a dictionary for the package's class Grasp.
nb::dict DictOf(const grasp::DetectedGrasp& grasp, const robot::HandModel& hand);

/// Frame G of the proposal that gives the grasp's hand pose, including pitch and centering.
base::Pose ProposedPose(const grasp::DetectedGrasp& grasp, const robot::HandModel& hand);

/// Positions of the samples in the image of their view.
nb::ndarray<nb::numpy, std::int64_t, nb::c_contig> SamplesOf(
    const std::vector<geometry::SampleId>& samples);

/// Adds the work cell's data to a scan: "center", "radius", "max_opening".
void AddWorkspace(const robot::Robot& robot, double margin_m, nb::dict& scan);

}  // namespace rangegrasp::python
