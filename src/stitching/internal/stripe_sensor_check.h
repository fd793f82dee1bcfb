#pragma once

#include "stitching/stripe_sensor.h"

namespace rangegrasp::stitching::internal {

/// @throws std::invalid_argument naming the key of the sensor file that is out of range.
void CheckOptions(const StripeSensorOptions& options);

}  // namespace rangegrasp::stitching::internal
