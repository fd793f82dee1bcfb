#include "seam/stitching/closed_loop.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <stdexcept>

#include "base/rng.h"
#include "seam/stitching/correction.h"
#include "seam/stitching/internal/control_unit.h"
#include "seam/stitching/internal/track_score.h"

namespace rangegrasp::stitching {
namespace {

using internal::ControlUnit;
using internal::HeadState;
using internal::kControlPeriod_s;
using internal::Point;

// A head that takes this much longer than its track would at full speed makes no way.
constexpr double kMaxSlowness = 20.0;
constexpr double kMaxDelay_s = 60.0;
// Profiles whose poses are remembered: more than a packet rests on at 100 Hz.
constexpr std::size_t kPlaces = 64;

void Check(bool good, const char* what) {
  if (!good) throw std::invalid_argument(std::string("track: ") + what);
}

void Check(const TrackOptions& options) {
  const HeadOptions& head = options.head;
  Check(head.speed_m_s > 0.0, "head.speed_m_s must be above 0");
  Check(head.max_lateral_speed_m_s > 0.0, "head.max_lateral_speed_m_s must be above 0");
  Check(head.max_acceleration_m_s2 > 0.0, "head.max_acceleration_m_s2 must be above 0");
  Check(head.max_rotation_rad_s > 0.0, "head.max_rotation_rad_s must be above 0");
  Check(head.max_rotation_acceleration_rad_s2 > 0.0,
        "head.max_rotation_acceleration_rad_s2 must be above 0");
  Check(head.max_jump_m > 0.0, "head.max_jump_m must be above 0");
  Check(head.correction_period_s >= kControlPeriod_s,
        "head.correction_period_s must not be below the control period of 0.01 s");
  Check(options.wanted_distance_m > 0.0, "wanted_distance_m must be above 0");
  Check(options.length_m > 0.0, "length_m must be above 0");
}

// How far the line's middle went along the line.
double MovedAlong(const LinePose& before, const LinePose& now) {
  return (now.x_m - before.x_m) * std::cos(now.heading_rad) +
         (now.y_m - before.y_m) * std::sin(now.heading_rad);
}

/// A line of the sensor with all that watches it.
struct Line {
  Line(double ahead, const seam::TrackerOptions& tracker_options,
       const seam::Calibration& calibration, const seam::MonitorOptions& monitor_options)
      : ahead_m(ahead),
        tracker(tracker_options, calibration),
        monitor(tracker_options.line, monitor_options) {}

  seam::Reading Take(const seam::Profile& profile) {
    const seam::Reading reading = tracker.Update(profile);
    stop = monitor.Update(tracker.prepared(), reading);
    return reading;
  }

  double ahead_m;
  std::optional<LinePose> pose;  // of the last profile
  seam::EdgeTracker tracker;
  seam::SurfaceMonitor monitor;
  std::optional<seam::StopReason> stop;
};

/// The sensor on the head with its evaluation: profiles in, packets out. The first line gives the
/// edge; the others, of which one at a time is lit besides the first, only watch.
class SensorUnit {
 public:
  SensorUnit(const Mats& mats, const StripeSensor& sensor, const seam::Calibration& calibration,
             const TrackOptions& options, std::uint64_t seed)
      : mats_(mats),
        sensor_(sensor),
        calibration_(calibration),
        period_s_(1.0 / sensor.Rate(mats.options().texture)),
        rng_(base::DeriveSeed(seed, "scan")) {
    seam::TrackerOptions tracker = options.tracker;
    tracker.line = sensor.options().line;
    tracker.packet_period_s = options.head.correction_period_s;
    for (const double ahead : sensor.options().lines_ahead_m) {
      lines_.emplace_back(ahead, tracker, calibration, options.monitor);
    }
  }

  double NextTime() const { return period_s_ * count_; }

  /// Measures at NextTime() from a pose. @return the first line's reading.
  seam::Reading Measure(const HeadState& head) {
    const double time_s = NextTime();
    const std::size_t others = lines_.size() - 1;
    const std::size_t number = static_cast<std::size_t>(count_++);
    const seam::Reading reading = lines_.front().Take(Scan(head, lines_.front(), time_s));
    if (others > 0) {
      Line& other = lines_[1 + number % others];
      other.Take(Scan(head, other, time_s));
      other.tracker.TakePacket();
    }
    places_.push_back({time_s, head.Line(lines_.front().ahead_m)});
    if (places_.size() > kPlaces) places_.pop_front();
    return reading;
  }

  /// The correction that is due, if one is.
  std::optional<Correction> TakeCorrection() {
    const auto packet = lines_.front().tracker.TakePacket();
    if (!packet) return std::nullopt;
    Correction correction;
    correction.time_s = packet->time_s;
    const auto place = std::find_if(places_.begin(), places_.end(),
                                    [&](const Place& p) { return p.time_s == packet->time_s; });
    if (packet->column && place != places_.end()) {
      correction.valid = true;
      correction.sure = packet->sure;
      correction.edge_x_m = packet->x_m;
      correction.deviation_m = place->line.x_m + packet->x_m * std::cos(place->line.heading_rad);
    }
    for (const Line& line : lines_) {
      if (!correction.stop) correction.stop = StopOf(line);
    }
    return correction;
  }

 private:
  struct Place {
    double time_s;
    LinePose line;
  };

  // Where the first line still sees the edge the mats have not ended further behind.
  std::optional<seam::StopReason> StopOf(const Line& line) const {
    const bool end = line.stop == seam::StopReason::kMatEnd;
    return end && lines_.front().monitor.SeesEdge() ? std::nullopt : line.stop;
  }

  seam::Profile Scan(const HeadState& head, Line& line, double time_s) {
    const seam::RawProfile* previous = previous_.row_px.empty() ? nullptr : &previous_;
    const LinePose pose = head.Line(line.ahead_m);
    previous_ = sensor_.Scan(mats_, pose, time_s, previous, rng_);
    seam::Profile profile = seam::Calibrate(previous_, calibration_);
    if (line.pose) profile.moved_m = MovedAlong(*line.pose, pose);
    line.pose = pose;
    return profile;
  }

  const Mats& mats_;
  const StripeSensor& sensor_;
  const seam::Calibration& calibration_;
  double period_s_;
  base::Rng rng_;
  int count_ = 0;
  std::vector<Line> lines_;
  std::deque<Place> places_;  // of the last profiles
  seam::RawProfile previous_;
};

TrackPoint PointOf(const HeadState& head, double time_s) {
  return {time_s, head.needle.x(), head.needle.y(), head.heading_rad, 0.0};
}

// Profiles between two control steps, the head's pose between theirs.
void MeasureUntil(double time_s, const ControlUnit& control, SensorUnit& unit,
                  std::vector<std::string>& packets, TrackResult& result) {
  while (unit.NextTime() < time_s) {
    const HeadState head = control.PoseAt(unit.NextTime());
    result.readings.push_back(unit.Measure(head));
    if (const auto correction = unit.TakeCorrection()) packets.push_back(ToXml(*correction));
  }
}

bool AtRest(const HeadState& head) {
  return head.velocity.isZero(0.0) && head.rotation_rad_s == 0.0;
}

}  // namespace

TrackResult Track(const Mats& mats, const StripeSensor& sensor,
                  const seam::Calibration& calibration, const TrackOptions& options,
                  std::uint64_t seed) {
  Check(options);
  SensorUnit unit(mats, sensor, calibration, options, seed);
  ControlUnit control(options, sensor.options().lines_ahead_m.front(),
                      sensor.Rate(mats.options().texture));
  TrackResult result;
  HeadState head;
  head.needle.x() = -options.wanted_distance_m;
  // A head that makes no way is lost, whatever the reason.
  const double max_s = kMaxDelay_s + kMaxSlowness * options.length_m / options.head.speed_m_s;
  for (int step = 0;; ++step) {
    const double time_s = step * kControlPeriod_s;
    control.Record(head);
    result.path.push_back(PointOf(head, time_s));
    std::vector<std::string> packets;
    MeasureUntil(time_s, control, unit, packets, result);
    for (std::string& xml : packets) {
      if (const auto edge = control.Receive(xml)) result.sensed.push_back(*edge);
      result.packets.push_back(std::move(xml));
    }
    const internal::HeadCommand command = control.Command();
    if ((control.end() && AtRest(head)) || time_s > max_s) break;
    head = internal::Move(head, command, options.head);
  }
  result.end = control.end().value_or(TrackEnd::kLost);
  internal::Score(mats, options.wanted_distance_m, result);
  return result;
}

}  // namespace rangegrasp::stitching
