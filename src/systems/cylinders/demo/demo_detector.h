#pragma once

#include <functional>
#include <memory>

#include "cylinders/demo/demo_options.h"
#include "grasp/detector.h"
#include "robot/robot.h"

namespace rangegrasp::demo {

/// What a viewer may see of a detection.
using CylinderObserver =
    std::function<void(const cylinders::CylinderScene&, const geometry::Observation&)>;

/// Before the name of a step of cylinders::DetectCylinders in Detected::seconds; second looks
/// count.
inline constexpr const char* kCylinderStep = "cylinders:";

/// Chapter 4: finds the wanted one of the given cylinders; everything else that chapter 5's
/// perception finds is an obstacle. Grasps hold it round its barrel at the centre of gravity, from
/// above along its axis where it stands, turned as it suits the arm. An empty detection: it was not
/// found. The arguments must outlive it.
/// The other given cylinders that were found are obstacles with their known shapes.
/// @param wanted  position in options.demo.given
/// @param observer  may be empty
std::unique_ptr<trial::Detector> MakeDemoDetector(const Options& options, const robot::Robot& robot,
                                                  std::size_t wanted,
                                                  CylinderObserver observer = {});

/// A cylinder as perception's objects are: its shape is known, so that it is closed, and its points
/// are those of `scene` that lie within `grown_m` of it. Objects that lie in it mostly are left out
/// of the scene, it is the first one.
void PutFirst(const cylinders::Cylinder& cylinder_C, bool lies, double grown_m,
              perception::Scene& scene);

}  // namespace rangegrasp::demo
