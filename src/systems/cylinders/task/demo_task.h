#pragma once

#include "cylinders/task/demo_detector.h"
#include "experiment/task.h"
#include "trial/trial.h"

namespace rangegrasp::cylinders {

/// True if the robot knows from its own sensors that it can try again: nothing was found, planned
/// or held, and nothing has been offered to a person.
bool KnowsItFailed(const trial::Attempt& attempt, Delivery delivery);

/// `task: cylinder_demo`: the live demo of section 4.4. A case is one run: one of several given
/// cylinders among other objects is wanted, grasped, and handed over or put down.
const experiment::TaskKind& DemoTask();

/// Table 4.1: events of each kind of problem compared with the published ones, with and without
/// influence on the run; the number of handovers; the number of pulls that were felt.
experiment::Report DemoReport(const experiment::Stamp& stamp,
                              const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::cylinders

namespace rangegrasp::draw {

/// Draws the detection of given cylinders in a cloud (figures 4.4, 4.7, 4.11): the table grey-blue,
/// outliers red, curvature points by normals green and by scan lines orange, the barrel of every
/// found cylinder blue, the cylinder itself in the color of its given one, its axis black.
void DrawCylinders(const cylinders::CylinderScene& scene, const Eigen::Vector3d& sensor_origin_C,
                   const std::filesystem::path& png);

}  // namespace rangegrasp::draw
