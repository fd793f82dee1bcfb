#pragma once

#include "trial/trial.h"

namespace rangegrasp::bench {

/// The experiment of table 5.2, prepared once.
const trial::Cell& Cell();

/// Five objects on the table, at rest.
const sim::World& FiveObjects();

/// A scan of it, the same at every run.
const geometry::Observation& FiveObjectsScan();
/// Its points but those of the arm and its pedestal.
const geometry::Points& FiveObjectsCloud();

/// The sensor's place for that cloud [m].
Eigen::Vector3d SensorOrigin();

/// What perception makes of it.
const perception::Scene& FiveObjectsScene();

}  // namespace rangegrasp::bench
