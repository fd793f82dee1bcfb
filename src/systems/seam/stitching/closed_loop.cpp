#include "seam/stitching/closed_loop.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "base/words.h"
#include "seam/stitching/internal/control_unit.h"
#include "seam/stitching/internal/seam_path.h"

namespace rangegrasp::seam {
namespace {

// ---- the loop ----

// A head that takes this many times as long as its track at full speed, plus the delay, is stuck.
constexpr double kMaxSlowness = 20.0;
constexpr double kMaxDelay_s = 60.0;
// Number of profiles whose poses are kept: more than a packet depends on at 100 Hz.
constexpr std::size_t kPlaces = 64;

// Motion of the line's middle along the line.
double MovedAlong(const LinePose& before, const LinePose& now) {
  return (now.x_m - before.x_m) * std::cos(now.heading_rad) +
         (now.y_m - before.y_m) * std::sin(now.heading_rad);
}

/// A line of the sensor with its tracker and monitor.
struct Line {
  Reading Take(const Profile& profile) {
    const Reading reading = tracker.Update(profile);
    stop = monitor.Update(tracker.prepared(), reading);
    return reading;
  }

  double ahead_m;
  EdgeTracker tracker;
  SurfaceMonitor monitor;
  std::optional<LinePose> pose = {};  // of the last profile
  std::optional<StopReason> stop = {};
};

/// The sensor on the head with its evaluation: profiles in, packets out. The first line measures
/// the edge; the others only monitor, and one of them at a time is lit besides the first.
class SensorUnit {
 public:
  SensorUnit(const Mats& mats, const StripeSensor& sensor, const Calibration& calibration,
             const TrackOptions& options, std::uint64_t seed)
      : mats_(mats),
        sensor_(sensor),
        calibration_(calibration),
        period_s_(1.0 / sensor.Rate(mats.options().texture)),
        rng_(base::DeriveSeed(seed, "scan")) {
    TrackerOptions tracker = options.tracker;
    tracker.line = sensor.options().line;
    for (const double ahead : sensor.options().lines_ahead_m) {
      lines_.push_back({ahead, EdgeTracker(tracker, calibration),
                        SurfaceMonitor(tracker.line, MonitorFor(options.monitor, tracker.method))});
    }
  }

  double NextTime() const { return period_s_ * count_; }

  /// Measures at NextTime() from a pose. @return the first line's reading.
  Reading Measure(const HeadState& head) {
    const double time_s = NextTime();
    const std::size_t others = lines_.size() - 1;
    const std::size_t number = static_cast<std::size_t>(count_++);
    const Reading reading = lines_.front().Take(Scan(head, lines_.front(), time_s));
    if (others > 0) {
      Line& other = lines_[1 + number % others];
      other.Take(Scan(head, other, time_s));
      other.tracker.TakePacket();
    }
    places_.push_back({time_s, head.Line(lines_.front().ahead_m)});
    if (places_.size() > kPlaces) places_.pop_front();
    return reading;
  }

  /// The correction, if one is due.
  std::optional<Correction> TakeCorrection() {
    const auto packet = lines_.front().tracker.TakePacket();
    if (!packet) return std::nullopt;
    Correction correction;
    correction.time_s = packet->time_s;
    const auto place = std::ranges::find(places_, packet->time_s, &Place::time_s);
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

  // If the first line still sees the edge, the mats have not ended behind it.
  std::optional<StopReason> StopOf(const Line& line) const {
    const bool end = line.stop == StopReason::kMatEnd;
    return end && lines_.front().monitor.SeesEdge() ? std::nullopt : line.stop;
  }

  Profile Scan(const HeadState& head, Line& line, double time_s) {
    const RawProfile* previous = previous_.row_px.empty() ? nullptr : &previous_;
    const LinePose pose = head.Line(line.ahead_m);
    previous_ = sensor_.Scan(mats_, pose, time_s, previous, rng_);
    Profile profile = Calibrate(previous_, calibration_);
    if (line.pose) profile.moved_m = MovedAlong(*line.pose, pose);
    line.pose = pose;
    return profile;
  }

  const Mats& mats_;
  const StripeSensor& sensor_;
  const Calibration& calibration_;
  double period_s_;
  base::Rng rng_;
  int count_ = 0;
  std::vector<Line> lines_;
  std::deque<Place> places_;  // of the last profiles
  RawProfile previous_;
};

// ---- the score ----

constexpr double kNoDistance = std::numeric_limits<double>::quiet_NaN();
// Spacing of the true edge's polyline: its fray varies over millimetres, so the error between
// points is micrometres.
constexpr double kEdgeSpacing_m = 0.1e-3;
// Search range along y, beyond the wanted distance, for the nearest point of an edge.
constexpr double kReach_m = 20e-3;

double ToSegment(const Point& p, const Point& a, const Point& b) {
  const Point along = b - a;
  const double square = along.squaredNorm();
  const double t = square > 0.0 ? std::clamp((p - a).dot(along) / square, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

// The true edge as a polyline that covers a path, ascending in y.
std::vector<Point> TrueEdge(const Mats& mats, double from_y, double to_y) {
  std::vector<Point> edge;
  const int n = static_cast<int>(std::ceil((to_y - from_y) / kEdgeSpacing_m));
  for (int i = 0; i <= n; ++i) {
    const double y = from_y + i * kEdgeSpacing_m;
    const double x = mats.EdgeX(y);
    if (std::isfinite(x)) edge.emplace_back(x, y);
  }
  return edge;
}

// Positive on the low side.
double Distance(const Mats& mats, const std::vector<Point>& edge, const Point& needle,
                double reach) {
  const double x = mats.EdgeX(needle.y());
  if (!std::isfinite(x)) return kNoDistance;
  const auto first =
      std::ranges::lower_bound(edge, needle.y() - reach, {}, [](const Point& p) { return p.y(); });
  double nearest = std::numeric_limits<double>::infinity();
  for (auto p = first; p != edge.end() && p + 1 != edge.end(); ++p) {
    if (p->y() > needle.y() + reach) break;
    nearest = std::min(nearest, ToSegment(needle, *p, *(p + 1)));
  }
  return needle.x() > x ? -nearest : nearest;
}

bool Hits(const Mats& mats, const TrackPoint& p) {
  if (p.y_m > mats.options().end_y_m) return true;
  return std::ranges::any_of(mats.options().obstacles, [&](const MatOptions::Obstacle& o) {
    return std::abs(p.x_m - o.x_m) <= 0.5 * o.size_x_m &&
           std::abs(p.y_m - o.y_m) <= 0.5 * o.size_y_m;
  });
}

struct Piece {
  double error_m, length_m;
};

std::vector<Piece> SettledPieces(const std::vector<TrackPoint>& path, double wanted_distance_m) {
  std::vector<Piece> pieces;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double length = std::hypot(path[i].x_m - path[i - 1].x_m, path[i].y_m - path[i - 1].y_m);
    const double error = std::abs(path[i].distance_m - wanted_distance_m);
    if (path[i].y_m >= path.front().y_m + kSettle_m && std::isfinite(error) && length > 0.0) {
      pieces.push_back({error, length});
    }
  }
  return pieces;
}

void Summarise(std::vector<Piece> pieces, TrackResult& result) {
  std::ranges::stable_sort(pieces, {}, &Piece::error_m);
  double total = 0.0;
  for (const Piece& piece : pieces) total += piece.length_m;
  if (total <= 0.0) return;
  double sum = 0.0, good = 0.0;
  for (const Piece& piece : pieces) {
    sum += piece.error_m * piece.length_m;
    if (piece.error_m <= kGood_m) good += piece.length_m;
  }
  result.mean_error_m = sum / total;
  result.max_error_m = pieces.back().error_m;
  result.share_within_1mm = good / total;
}

}  // namespace

std::string ToXml(const Correction& correction) {
  std::string elements = fmt::format(
      "<time_s>{}</time_s><valid>{}</valid><edge_x_m>{}</edge_x_m><deviation_m>{}</deviation_m>",
      correction.time_s, correction.valid, correction.edge_x_m, correction.deviation_m);
  if (correction.sure) elements += fmt::format("<sure>{}</sure>", *correction.sure);
  if (correction.stop) elements += fmt::format("<stop>{}</stop>", base::Word(*correction.stop));
  return "<correction>" + elements + "</correction>\n";
}

TrackResult Track(const Mats& mats, const StripeSensor& sensor, const Calibration& calibration,
                  const TrackOptions& options, std::uint64_t seed) {
  SensorUnit unit(mats, sensor, calibration, options, seed);
  ControlUnit control(options, sensor.options().lines_ahead_m.front(),
                      sensor.Rate(mats.options().texture));
  TrackResult result;
  HeadState head;
  head.needle.x() = -options.wanted_distance_m;
  // A head that is stuck counts as lost, whatever the reason.
  const double max_s = kMaxDelay_s + kMaxSlowness * options.length_m / options.head.speed_m_s;
  for (int step = 0;; ++step) {
    const double time_s = step * kControlPeriod_s;
    control.Record(head);
    result.path.push_back({time_s, head.needle.x(), head.needle.y(), head.heading_rad, 0.0});
    // The profiles since the last control step, with interpolated head poses.
    while (unit.NextTime() < time_s) {
      result.readings.push_back(unit.Measure(control.PoseAt(unit.NextTime())));
      const auto packet = unit.TakeCorrection();
      if (!packet) continue;
      if (const auto edge = control.Receive(*packet)) result.sensed.push_back(*edge);
      result.packets.push_back(ToXml(*packet));
    }
    const HeadCommand command = control.Command();
    const bool at_rest = head.velocity.isZero(0.0) && head.rotation_rad_s == 0.0;
    if ((control.end() && at_rest) || time_s > max_s) break;
    head = Move(head, command, options.head);
  }
  result.end = control.end().value_or(TrackEnd::kLost);
  ScoreTrack(mats, options.wanted_distance_m, result);
  return result;
}

void ScoreTrack(const Mats& mats, double wanted_distance_m, TrackResult& result) {
  const double reach = wanted_distance_m + kReach_m;
  const auto [low, high] = std::ranges::minmax_element(result.path, {}, &TrackPoint::y_m);
  const auto edge = TrueEdge(mats, low->y_m - reach, high->y_m + reach);
  for (TrackPoint& p : result.path) {
    p.distance_m = Distance(mats, edge, {p.x_m, p.y_m}, reach);
    result.reached_hazard = result.reached_hazard || Hits(mats, p);
  }
  Summarise(SettledPieces(result.path, wanted_distance_m), result);
}

}  // namespace rangegrasp::seam
