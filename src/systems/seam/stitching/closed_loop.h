#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "seam/monitor.h"
#include "seam/stitching/mats.h"
#include "seam/stitching/stripe_sensor.h"
#include "seam/tracker.h"

namespace rangegrasp::seam {

/// A correction that is sent to the robot control unit.
struct Correction {
  double time_s = 0.0;
  bool valid = false;
  double edge_x_m = 0.0;     ///< of the edge in the line's frame
  double deviation_m = 0.0;  ///< of the edge from its place in CAD
  std::optional<bool> sure;  ///< whether the edge is beyond doubt (Reading::sure)
  std::optional<StopReason> stop;
};
/// One line, so that a stream of packets can be split at its line ends; numbers read back the same.
std::string ToXml(const Correction& correction);

/// Limits of the stitching head. The dissertation gives the robot's 2 m/s (section 3.1.2), but not
/// its limits with a sewing head; these are far lower. Higher limits follow corners better.
struct HeadOptions {
  double speed_m_s = 0.03;  ///< of the needle along the track, > 0
  double max_lateral_speed_m_s = 0.03;
  double max_acceleration_m_s2 = 0.3;
  double max_rotation_rad_s = 0.5;
  double max_rotation_acceleration_rad_s2 = 2.0;
  bool rotate = true;  ///< false: only shift (section 3.5.2)
};

struct TrackOptions {
  HeadOptions head;
  TrackerOptions tracker;
  MonitorOptions monitor;
  double wanted_distance_m = 5e-3;  ///< seam to edge, on the low side of the edge
  double length_m = 0.4;            ///< of the CAD track along y, from y = 0
};

/// Pose of the needle, and its distance from the edge.
struct TrackPoint {
  double time_s, x_m, y_m, heading_rad;
  double distance_m;  ///< true distance from needle to nearest edge point; NaN beyond the mats' end
};

enum class TrackEnd { kDone, kMatEnd, kObstacle, kLost };
constexpr std::array<std::string_view, 4> WordsOf(TrackEnd) {
  return {"done", "mat_end", "obstacle", "lost"};
}

/// How a track went. Errors are |distance - wanted| over the path after kSettle_m.
struct TrackScore {
  TrackEnd end = TrackEnd::kDone;
  bool reached_hazard = false;  ///< the needle passed the mats' end or touched an obstacle
  double mean_error_m = 0.0;
  double max_error_m = 0.0;
  double share_within_1mm = 0.0;  ///< of the path's length
};
struct TrackResult : TrackScore {
  std::vector<TrackPoint> path;  ///< at every correction and every control step
  std::vector<Reading> readings;
  std::vector<TrackPoint> sensed;    ///< edge positions sent, in frame M, without distance_m
  std::vector<std::string> packets;  ///< XML, as sent
};
/// Start of a track that is excluded from errors: the needle first has to reach the place where the
/// line began, 80 mm ahead.
constexpr double kSettle_m = 0.1;
/// A seam within this of the wanted distance is good (section 3.7.1).
constexpr double kGood_m = 1e-3;

/// Drives a head with its sensor ahead over mats that deviate from the track, with a correction
/// every period, until the track's end, the mats' end or an obstacle. Depends only on its
/// arguments.
TrackResult Track(const Mats& mats, const StripeSensor& sensor, const Calibration& calibration,
                  const TrackOptions& options, std::uint64_t seed);

/// Compares a track with the truth: fills distance_m of its path, reached_hazard and the errors.
void ScoreTrack(const Mats& mats, double wanted_distance_m, TrackResult& result);

}  // namespace rangegrasp::seam
