#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "seam/monitor.h"
#include "seam/tracker.h"
#include "stitching/mats.h"
#include "stitching/stripe_sensor.h"

namespace rangegrasp::stitching {

struct HeadOptions {
  double speed_m_s = 0.03;              ///< of the needle along the track, > 0
  double max_lateral_speed_m_s = 0.03;  ///< of corrections
  double max_acceleration_m_s2 = 0.3;
  double max_rotation_rad_s = 0.5;
  double max_rotation_acceleration_rad_s2 = 2.0;
  bool rotate = true;  ///< turn into the seam; false: only shift (section 3.5.2)
  double correction_period_s = 0.1;
};

struct TrackOptions {
  HeadOptions head;
  seam::TrackerOptions tracker;
  seam::MonitorOptions monitor;
  double wanted_distance_m = 5e-3;  ///< seam to edge, on the low side of the edge
  double length_m = 0.4;            ///< of the CAD track along y, from y = 0
};

/// Where the needle was, and how far it was from where it should have been.
struct TrackPoint {
  double time_s, x_m, y_m, heading_rad;
  double distance_m;  ///< true distance from the needle to the edge (nearest point); NaN beyond the
                      ///< mats' end
};

enum class TrackEnd { kDone, kMatEnd, kObstacle, kLost };
const char* Name(TrackEnd end);  ///< "done", "mat_end", "obstacle", "lost"

struct TrackResult {
  std::vector<TrackPoint> path;  ///< at every correction and every control step
  std::vector<seam::Reading> readings;
  std::vector<TrackPoint>
      sensed;  ///< the edge positions that were sent, in frame M (distance_m unused)
  std::vector<std::string> packets;  ///< XML, as sent
  TrackEnd end = TrackEnd::kDone;
  bool reached_hazard = false;  ///< the needle passed the mats' end or touched an obstacle
  double mean_error_m = 0.0;    ///< |distance - wanted| over the path after settle_m
  double p95_error_m = 0.0;
  double max_error_m = 0.0;
  double share_within_1mm = 0.0;  ///< of the path's length after settle_m
};
constexpr double kSettle_m = 0.1;

/// Drives a head with its sensor ahead over mats that deviate from the track: scans at the sensor's
/// rate, hands profiles to the tracker, sends a correction every period, and moves within the
/// head's limits until the track's end, the mats' end or an obstacle. Depends on its arguments and
/// the seed alone.
TrackResult Track(const Mats& mats, const StripeSensor& sensor,
                  const seam::Calibration& calibration, const TrackOptions& options,
                  std::uint64_t seed);

/// A correction as it is sent to the robot control unit, and its way back.
struct Correction {
  double time_s = 0.0;
  bool valid = false;
  double edge_x_m = 0.0;     ///< of the edge in the line's frame
  double deviation_m = 0.0;  ///< of the edge from where CAD has it
  std::optional<seam::StopReason> stop;
};
std::string ToXml(const Correction& correction);
/// @throws core::InputError saying what is wrong.
Correction FromXml(const std::string& xml);

}  // namespace rangegrasp::stitching
