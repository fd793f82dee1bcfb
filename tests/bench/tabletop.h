#pragma once

#include "trial/trial.h"

namespace rangegrasp::bench {

/// The experiment of table 5.2, prepared once.
const trial::Cell& Cell();

/// Five objects on the table, at rest.
const sim::World& FiveObjects();

/// A scan of the five objects, identical in every run.
const geometry::Observation& FiveObjectsScan();
/// The points of the scan without those of the arm and its pedestal.
const geometry::Points& FiveObjectsCloud();

/// The sensor's position for that cloud [m].
Eigen::Vector3d SensorOrigin();

/// Perception's result for that cloud.
const perception::Scene& FiveObjectsScene();

}  // namespace rangegrasp::bench
