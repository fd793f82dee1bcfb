#pragma once

#include <memory>

#include "trial/sensor.h"

namespace rangegrasp::trial {

/// Section 7.2, figure 7.1: both look at the world, each as it would alone, from the same stream.
/// The observation has two views: the laser's, and of the stereo camera's what the laser is blind
/// to (perception/fill_absorbed.h).
std::unique_ptr<Sensor> MakeLaserAndStereo(std::unique_ptr<Sensor> laser,
                                           std::unique_ptr<Sensor> stereo);

}  // namespace rangegrasp::trial
