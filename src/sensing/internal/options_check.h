#pragma once

#include "sensing/line_scanner.h"

namespace rangegrasp::sensing::internal {

/// @throws std::invalid_argument naming the key (in the units of a sensor file) that is out of
/// range, its value and its range.
void CheckOptions(const LineScannerOptions& options);

}  // namespace rangegrasp::sensing::internal
