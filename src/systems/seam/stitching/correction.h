#pragma once

#include <optional>
#include <string>

#include "seam/monitor.h"

namespace rangegrasp::stitching {

/// A correction as it is sent to the robot control unit, and its way back.
struct Correction {
  double time_s = 0.0;
  bool valid = false;
  double edge_x_m = 0.0;     ///< of the edge in the line's frame
  double deviation_m = 0.0;  ///< of the edge from where CAD has it
  std::optional<bool> sure;  ///< whether the edge is beyond doubt (seam::Reading::sure)
  std::optional<seam::StopReason> stop;
};
std::string ToXml(const Correction& correction);
/// @throws base::InputError saying what is wrong.
Correction FromXml(const std::string& xml);

}  // namespace rangegrasp::stitching
