#include "seam/step_track.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "seam/internal/summit.h"

namespace rangegrasp::seam {
namespace {

// Positions off the track by more than it can have moved, and this [columns], are of another one.
constexpr double kSameTrack_columns = 12.0;
// A standard deviation of motion is no less than this [places], so that a way may turn.
constexpr double kMinSpread = 0.25;

// What one profile says of a known edge (log-likelihood ratio) counts for this at most, so that a
// filament or a hole is not an end, ...
constexpr double kMaxRatio = 3.0;
// ... and the log-odds stay within this: four profiles that surely have no step turn them.
constexpr double kMaxOdds = 12.0;
// An edge is beyond doubt while they are no less than this, and the best way leads to it with this
// share of the evidence that makes an edge, in so many profiles in a row that tell anything of it.
// What noise, or a mat's end that a turned line sees along it, makes of an edge that is gone is
// not. All of the evidence would be too much: that of a low edge on a mould wavers about it.
constexpr double kSureOdds = 9.0;
constexpr double kSureShare = 0.75;
constexpr int kSure = 10;
// Once nothing was left of one that was sure: a mould's flank or a tow may look like an edge for a
// while.
constexpr int kSureAgain = 15;
// A known edge moves no faster than this share of speed_columns_per_s (10 mm/s) besides the line's
// own motion, so that noise does not lead it away; ...
constexpr double kKnownSpeed = 0.5;
// ... but where there is so many times the evidence that is asked for, which noise never has.
constexpr double kCertain = 2.0;
// Two profiles that have an edge alone have the same one if it is this near [places: 2 mm].
constexpr double kAlone = 8.0;
// A step is the known edge's if its height differs by this share of it at most.
constexpr double kSameHeight = 0.5;
// An edge further off than this [places: 3 mm] is another one, ...
constexpr double kAway = 12.0;
// ... which becomes the known one after so many profiles in a row: a sixth of a second.
constexpr int kElsewhere = 10;
// The known height is the mean over its profiles, later over about the last half second. That of a
// young edge is the highest of all places' by chance, so that it is corrected whatever the odds.
constexpr double kHeightGain = 0.03;
constexpr int kYoung = 20;

void CheckTrack(bool good, const char* what) {
  if (!good) throw std::invalid_argument(std::string("step track: ") + what);
}

}  // namespace

StepTrack::StepTrack(const StepTrackOptions& options) : options_(options) {
  CheckTrack(options.memory >= 0.0 && options.memory < 1.0,
             "memory must be at least 0 and below 1");
  CheckTrack(options.most_evidence > 0.0, "most_evidence must be above 0");
  CheckTrack(options.uneven > 0.0, "uneven must be above 0");
  CheckTrack(options.speed_columns_per_s > 0.0, "speed_columns_per_s must be above 0");
  CheckTrack(options.max_speed_columns_per_s > 0.0, "max_speed_columns_per_s must be above 0");
  CheckTrack(options.min_step_m >= 0.0, "min_step_m must not be negative");
  CheckTrack(options.continued >= 0.0 && options.continued <= 1.0, "continued must be from 0 to 1");
  CheckTrack(options.line_profiles >= 2, "line_profiles must be at least 2");
  CheckTrack(options.forget_s > 0.0, "forget_s must be above 0");
}

// Each place goes on with the way that leads to it best: what a way has, less what its motion
// costs. A line that moves by `shift` places has an edge that stays where it is that much earlier.
std::vector<StepTrack::Way> StepTrack::Moved(int shift, double period_s) const {
  const double stride = options_.steps.stride;
  const auto places = static_cast<int>(ways_.size());
  const int reach = std::clamp(
      static_cast<int>(std::ceil(options_.max_speed_columns_per_s * period_s / stride)), 1, places);
  const double spread = std::max(options_.speed_columns_per_s * period_s / stride, kMinSpread);
  std::vector<double> best(ways_.size(), 0.0);
  std::vector<int> from(ways_.size());
  for (int place = 0; place < places; ++place) {
    from[static_cast<std::size_t>(place)] = std::clamp(place + shift, 0, places - 1);
  }
  for (int d = -reach; d <= reach; ++d) {
    const double cost = d * d / (2.0 * spread * spread);
    const int to = d + shift;
    for (int place = std::max(0, -to); place < std::min(places, places - to); ++place) {
      const auto here = static_cast<std::size_t>(place);
      const double evidence = ways_[static_cast<std::size_t>(place + to)].evidence - cost;
      if (evidence <= best[here]) continue;
      best[here] = evidence;
      from[here] = place + to;
    }
  }
  std::vector<Way> moved(ways_.size());
  for (std::size_t place = 0; place < moved.size(); ++place) {
    const Way& before = ways_[static_cast<std::size_t>(from[place])];
    moved[place] = {options_.memory * best[place], options_.memory * before.height,
                    options_.memory * before.precision};
  }
  return moved;
}

void StepTrack::Continue(const std::vector<LocalStep>& steps, double strongest, double period_s) {
  const double share = std::min(1.0, options_.most_evidence / std::max(strongest, 1e-9));
  const int shift = static_cast<int>(std::lround(moved_places_));
  moved_places_ -= shift;
  ways_ = Moved(shift, period_s);
  for (std::size_t place = 0; place < steps.size(); ++place) {
    const LocalStep& step = steps[place];
    ways_[place].evidence += share * step.evidence;
    ways_[place].height += step.precision_m2 * step.height_m;
    ways_[place].precision += step.precision_m2;
  }
  weight_ = options_.memory * weight_ + 1.0;
}

// Whether a way is an edge by a share of the evidence that is asked for.
bool StepTrack::Suffices(const Way& way, double share) const {
  const double wanted = options_.evidence + options_.first_evidence / weight_;
  return way.evidence / weight_ >= share * wanted && way.Height() >= options_.min_step_m;
}

// Where the known edge is now, by the best way.
void StepTrack::Follow(double column, const Way& way, double period_s) {
  const bool sure = Suffices(way, 1.0);
  if (!known_) {
    if (sure) known_ = Known{column, way.Height(), kMaxOdds};
    return;
  }
  const double apart = column - known_->column;
  const double speed = Suffices(way, kCertain) ? options_.max_speed_columns_per_s
                                               : kKnownSpeed * options_.speed_columns_per_s;
  const double reach = speed * period_s;
  if (std::abs(apart) <= kAway * options_.steps.stride) {
    known_->column += std::clamp(apart, -reach, reach);
    known_->elsewhere = 0;
  } else if (sure && ++known_->elsewhere >= kElsewhere) {
    known_ = Known{column, way.Height(), std::min(known_->log_odds, 0.0)};
  }
}

const LocalStep& StepTrack::AtKnown(const std::vector<LocalStep>& steps) const {
  const long place = std::lround(known_->column / options_.steps.stride);
  return steps[static_cast<std::size_t>(std::clamp(place, 0L, std::ssize(steps) - 1L))];
}

// What this profile says of the known edge: log-likelihood ratio of a step of its height to none,
// by the window that knows the step best.
void StepTrack::Weigh(const LocalStep& step) {
  if (!(step.surest_precision_m2 > 0.0)) return;
  const double h = known_->height_m;
  const double varies = options_.uneven * h;
  const double variance = 1.0 / step.surest_precision_m2 + varies * varies;
  const double ratio = 0.5 * h * (2.0 * step.surest_height_m - h) / variance;
  known_->log_odds =
      std::clamp(known_->log_odds + std::clamp(ratio, -kMaxRatio, kMaxRatio), -kMaxOdds, kMaxOdds);
  ++known_->profiles;
  if (known_->log_odds <= 0.0 && known_->profiles > kYoung) return;
  const double now = std::clamp(step.surest_height_m, 0.0, 2.0 * h);
  const double gain = std::max(kHeightGain, 1.0 / known_->profiles);
  known_->height_m = std::max(options_.min_step_m, h + gain * (now - h));
}

// Whether the last profiles left no doubt of the known edge, `there` being what this one has at its
// place.
bool StepTrack::IsSure(double column, const Way& way, const LocalStep& there) {
  gone_ = gone_ || (was_sure_ && known_->log_odds <= 0.0);
  const bool near = std::abs(column - known_->column) <= kAway * options_.steps.stride;
  if (!near || !Suffices(way, kSureShare) || known_->log_odds < kSureOdds) {
    known_->sure = 0;
  } else if (there.surest_precision_m2 > 0.0) {
    ++known_->sure;
  }
  if (known_->sure < (gone_ ? kSureAgain : kSure)) return false;
  was_sure_ = true;
  gone_ = false;
  return true;
}

// Column of the summit of the parabola through a place's evidence and its neighbors'.
double StepTrack::Peak(std::size_t place) const {
  const double stride = options_.steps.stride;
  const std::vector<Way>& ways = ways_;
  if (place == 0 || place + 1 >= ways.size()) return stride * static_cast<double>(place);
  const double offset = internal::SummitOffset(ways[place - 1].evidence, ways[place].evidence,
                                               ways[place + 1].evidence);
  return stride * (static_cast<double>(place) + offset);
}

// Where the line through the last positions of this track stands now.
double StepTrack::OnLine(double column, double time_s) {
  positions_.push_back({time_s, column});
  if (static_cast<int>(positions_.size()) > options_.line_profiles) positions_.pop_front();
  std::erase_if(positions_, [&](const TimedColumn& earlier) {
    return std::abs(earlier.column - column) >
           kSameTrack_columns + options_.max_speed_columns_per_s * (time_s - earlier.time_s);
  });
  const std::vector<TimedColumn> track(positions_.begin(), positions_.end());
  return track.size() < 3 ? column : FitLine(track).At(time_s);
}

std::optional<double> StepTrack::AtOnce(std::optional<double> column, const LocalStep& strongest,
                                        double place) {
  const std::optional<double> before = alone_;
  alone_.reset();
  if (!known_ || strongest.evidence < options_.evidence + options_.first_evidence) return column;
  const double apart_m = std::abs(strongest.height_m - known_->height_m);
  if (apart_m > kSameHeight * known_->height_m) return column;
  alone_ = place;
  const double reach = kAlone * options_.steps.stride;
  if (column && std::abs(*column - place) <= reach) return column;
  return before && std::abs(*before - place) <= reach ? alone_ : std::nullopt;
}

// What is known is of places on the mats: a line that moves sees them elsewhere.
void StepTrack::MoveLine(double columns) {
  moved_places_ += columns / options_.steps.stride;
  for (TimedColumn& position : positions_) position.column -= columns;
  if (known_) known_->column -= columns;
  if (alone_) *alone_ -= columns;
}

StepTrack::Estimate StepTrack::Update(std::span<const float> height_m, double time_s,
                                      double moved_columns) {
  const std::vector<LocalStep> steps = FitLocalSteps(height_m, options_.steps);
  if (!last_time_s_ || time_s - *last_time_s_ > options_.forget_s || ways_.size() != steps.size()) {
    *this = StepTrack(options_);
    ways_.resize(steps.size());
  }
  Estimate estimate;
  if (steps.empty()) return estimate;
  const auto strongest = std::ranges::max_element(steps, {}, &LocalStep::evidence);
  const double period_s = last_time_s_ ? time_s - *last_time_s_ : 0.0;
  MoveLine(moved_columns);
  Continue(steps, strongest->evidence, period_s);
  last_time_s_ = time_s;
  if (strongest->evidence > 0.0) {
    estimate.strongest = static_cast<int>(strongest - steps.begin()) * options_.steps.stride;
  }
  const Way& way = *std::ranges::max_element(ways_, {}, &Way::evidence);
  edge_ = Suffices(way, edge_ ? options_.continued : 1.0);
  estimate.evidence = way.evidence / weight_;
  estimate.step_m = way.Height();
  const double peak = Peak(static_cast<std::size_t>(&way - ways_.data()));
  const double position = OnLine(peak, time_s);
  if (edge_) {
    Follow(peak, way, period_s);
    estimate.column = std::clamp(position, 0.0, static_cast<double>(height_m.size() - 1));
  }
  if (known_) {
    const LocalStep& there = AtKnown(steps);
    Weigh(there);
    estimate.sure = IsSure(peak, way, there);
  }
  estimate.at_once =
      AtOnce(edge_ && Suffices(way, kCertain) ? peak : estimate.column, *strongest,
             static_cast<double>((strongest - steps.begin()) * options_.steps.stride));
  estimate.goes_on = known_ && known_->log_odds > 0.0;
  if (estimate.goes_on) estimate.followed_step_m = std::max(known_->height_m, way.Height());
  return estimate;
}

}  // namespace rangegrasp::seam
