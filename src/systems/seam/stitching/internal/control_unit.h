#pragma once

#include <optional>
#include <span>
#include <vector>

#include "seam/stitching/closed_loop.h"
#include "seam/stitching/internal/seam_path.h"

namespace rangegrasp::seam {

/// A tenth of the period of corrections, so that a correction is carried out in small steps.
constexpr double kControlPeriod_s = 0.01;

/// State of the stitching head over the mats, in frame M. Its own frame H has the needle at its
/// origin, x along the sensor's line and y ahead; at heading 0 it is parallel to M.
struct HeadState {
  Point needle = Point::Zero();
  Point velocity = Point::Zero();  ///< [m/s]
  double heading_rad = 0.0;        ///< counter-clockwise seen from above
  double rotation_rad_s = 0.0;

  /// The sensor's line at a distance ahead of the needle.
  LinePose Line(double ahead_m) const;
};

/// Command of the control unit to the head for the next control period.
struct HeadCommand {
  Point velocity = Point::Zero();
  double heading_rad = 0.0;
};

/// State one control period later, within the head's limits for any command.
HeadState Move(const HeadState& head, const HeadCommand& command, const HeadOptions& options);

/// The highest speed from which a head with a reaction time stops within a distance, using the
/// share of its acceleration that a route reserves for braking.
double SafeSpeed(double distance_m, double reaction_s, const HeadOptions& options);

/// A path for the needle with the speed that the head's limits allow at each of its points.
class Route {
 public:
  Route() = default;
  /// @param path  a polyline, with y mostly ascending.
  /// @param speed_m_s  maximum speed, in addition to options.speed_m_s.
  Route(std::span<const Point> path, double speed_m_s, const HeadOptions& options);

  struct Place {
    Point point;
    Point tangent;  ///< unit
    double speed_m_s = 0.0;
    double s_m = 0.0;  ///< from the path's start
  };
  /// The point of the path nearest to `to`. The path must have two points.
  Place Nearest(const Point& to) const;
  /// Length from a place to where the path first reaches y; infinite if it does not.
  double LengthTo(const Place& from, double y_m) const;
  /// The first point after `from` that is this far away from it in a straight line; the path's end
  /// if the path is too short.
  Point AtDistance(const Place& from, double distance_m) const;

 private:
  std::vector<Point> points_;
  std::vector<double> s_m_;  // from the path's start
  std::vector<double> speed_;
};

/// Speed from which a head that brakes steadily stops within a distance.
double BrakingSpeed(double distance_m, const HeadOptions& options);

/// The robot control unit: commands the head from the CAD track, the head's poses and the
/// corrections that arrive. It never sees the mats.
class ControlUnit {
 public:
  /// @param rate_hz  of the sensor.
  ControlUnit(const TrackOptions& options, double line_ahead_m, double rate_hz);

  /// The head's pose at a control step; times ascend by kControlPeriod_s from 0.
  void Record(const HeadState& head) { poses_.push_back(head); }
  /// The pose at a time, interpolated between recorded ones.
  HeadState PoseAt(double time_s) const;
  /// Takes a packet.
  /// @return its edge point in frame M, with its time in time_s; none if the packet is not used.
  std::optional<TrackPoint> Receive(const Correction& correction);
  /// The command for the head from its last recorded pose on.
  HeadCommand Command();
  /// Why the head stops, once the last command was to stop.
  std::optional<TrackEnd> end() const { return end_; }

 private:
  void TakeStop(const Correction& correction);
  bool IsJump(const Point& edge, double time_s) const;
  std::vector<Point> EdgeFrom(double from_y);
  void PlanRoute();
  double PathX(const std::vector<Point>& edge, double y_m) const;

  TrackOptions options_;
  double ahead_m_;
  double window_s_;   // time over which a stop is decided
  double speed_m_s_;  // from which the head can stop for hazards that the line sees
  std::vector<HeadState> poses_;
  std::vector<Point> edge_;         // as sensed, ascending in y
  std::vector<TrackPoint> last_;    // the last points that were accepted
  double sure_to_y_m_;              // where the edge was last seen beyond doubt
  double known_to_y_m_;             // up to where the needle can go with what is known
  std::optional<double> join_y_m_;  // where the needle begins to leave the CAD track
  std::optional<double> mat_end_y_m_;
  bool obstacle_ = false;
  Route route_;
  std::optional<TrackEnd> end_;
};

}  // namespace rangegrasp::seam
