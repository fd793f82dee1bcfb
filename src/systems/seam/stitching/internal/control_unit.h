#pragma once

#include <optional>
#include <string>
#include <vector>

#include "seam/stitching/closed_loop.h"
#include "seam/stitching/correction.h"
#include "seam/stitching/internal/head.h"

namespace rangegrasp::stitching::internal {

/// The robot control unit: knows the CAD track, its own poses and the corrections that arrive as
/// XML, and from them tells the head where to go. It never sees the mats.
class ControlUnit {
 public:
  /// @param rate_hz  of the sensor.
  ControlUnit(const TrackOptions& options, double line_ahead_m, double rate_hz);

  /// The head's pose at a control step; times ascend by kControlPeriod_s from 0.
  void Record(const HeadState& head) { poses_.push_back(head); }
  /// The pose at a time, between recorded ones.
  HeadState PoseAt(double time_s) const;
  /// Takes a packet. @return the edge point that it tells of, in frame M, and its time in the
  /// point's time_s; none if it is not valid. @throws base::InputError on a bad packet.
  std::optional<TrackPoint> Receive(const std::string& xml);
  /// What the head shall do from its last recorded pose on.
  HeadCommand Command();
  /// Why the head is at rest, once the last command was to rest.
  std::optional<TrackEnd> end() const { return end_; }

 private:
  void TakeStop(const Correction& correction);
  bool IsJump(const Point& edge, double time_s) const;
  void TakeEdge(const Point& edge);
  std::vector<Point> EdgeFrom(double from_y);
  void PlanRoute();
  double PathX(const std::vector<Point>& edge, double y_m) const;

  TrackOptions options_;
  double ahead_m_;
  double window_s_;   // over which a stop is decided
  double speed_m_s_;  // from which the head can stop for what the line sees
  std::vector<HeadState> poses_;
  std::vector<Point> edge_;         // as sensed, ascending in y
  std::vector<TrackPoint> last_;    // of them, the last ones that were taken
  double sure_to_y_m_;              // where the edge was last seen beyond doubt
  double known_to_y_m_;             // where the needle can go with what is known
  std::optional<double> join_y_m_;  // where the needle begins to leave the CAD track
  std::optional<double> mat_end_y_m_;
  bool obstacle_ = false;
  Route route_;
  std::optional<TrackEnd> end_;
};

}  // namespace rangegrasp::stitching::internal
