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

void Check(bool good, const char* what) {
  if (!good) throw std::invalid_argument(std::string("step track: ") + what);
}

}  // namespace

StepTrack::StepTrack(const StepTrackOptions& options) : options_(options) {
  Check(options.memory >= 0.0 && options.memory < 1.0, "memory must be at least 0 and below 1");
  Check(options.most_evidence > 0.0, "most_evidence must be above 0");
  Check(options.uneven > 0.0, "uneven must be above 0");
  Check(options.speed_columns_per_s > 0.0, "speed_columns_per_s must be above 0");
  Check(options.max_speed_columns_per_s > 0.0, "max_speed_columns_per_s must be above 0");
  Check(options.min_step_m >= 0.0, "min_step_m must not be negative");
  Check(options.continued >= 0.0 && options.continued <= 1.0, "continued must be from 0 to 1");
  Check(options.line_profiles >= 2, "line_profiles must be at least 2");
  Check(options.forget_s > 0.0, "forget_s must be above 0");
}

// Log-likelihood ratio of no step to that of the way, by the window that knows the step best.
double StepTrack::Absence(const Way& way, const LocalStep& step) const {
  if (!(step.surest_precision_m2 > 0.0)) return 0.0;
  const double height = way.Height();
  const double lower = std::max(0.0, height - step.surest_height_m);
  const double varies = options_.uneven * height;
  return std::min(options_.most_evidence,
                  0.5 * lower * lower / (1.0 / step.surest_precision_m2 + varies * varies));
}

// Each place goes on with the way that leads to it best: what a way has, less what its motion
// costs.
std::vector<StepTrack::Way> StepTrack::Moved(const std::vector<Way>& ways, double period_s) const {
  const double stride = options_.steps.stride;
  const auto places = static_cast<int>(ways.size());
  const int reach = std::clamp(
      static_cast<int>(std::ceil(options_.max_speed_columns_per_s * period_s / stride)), 1, places);
  const double spread = std::max(options_.speed_columns_per_s * period_s / stride, kMinSpread);
  std::vector<double> best(ways.size(), 0.0);
  std::vector<int> from(ways.size());
  for (int place = 0; place < places; ++place) from[static_cast<std::size_t>(place)] = place;
  for (int d = -reach; d <= reach; ++d) {
    const double cost = d * d / (2.0 * spread * spread);
    for (int place = std::max(0, -d); place < std::min(places, places - d); ++place) {
      const auto here = static_cast<std::size_t>(place);
      const double evidence = ways[static_cast<std::size_t>(place + d)].evidence - cost;
      if (evidence <= best[here]) continue;
      best[here] = evidence;
      from[here] = place + d;
    }
  }
  std::vector<Way> moved(ways.size());
  for (std::size_t place = 0; place < moved.size(); ++place) {
    const Way& before = ways[static_cast<std::size_t>(from[place])];
    moved[place] = {options_.memory * best[place], options_.memory * before.height,
                    options_.memory * before.precision};
  }
  return moved;
}

void StepTrack::Continue(const std::vector<LocalStep>& steps, double strongest, double period_s) {
  const double share = std::min(1.0, options_.most_evidence / std::max(strongest, 1e-9));
  ways_.to = Moved(ways_.to, period_s);
  strict_.to = Moved(strict_.to, period_s);
  for (std::size_t place = 0; place < steps.size(); ++place) {
    const LocalStep& step = steps[place];
    // A way that nothing speaks for any more begins anew.
    Way& strict = strict_.to[place];
    strict.evidence -= Absence(strict, step);
    if (strict.evidence <= 0.0) strict = {};
    for (Way* way : {&ways_.to[place], &strict}) {
      way->evidence += share * step.evidence;
      way->height += step.precision_m2 * step.height_m;
      way->precision += step.precision_m2;
    }
  }
  weight_ = options_.memory * weight_ + 1.0;
}

// The best way, and whether it is an edge.
const StepTrack::Way& StepTrack::Judge(Ways& ways) const {
  const Way& best = *std::ranges::max_element(ways.to, {}, &Way::evidence);
  const double wanted = (options_.evidence + options_.first_evidence / weight_) *
                        (ways.edge ? options_.continued : 1.0);
  ways.edge = best.evidence / weight_ >= wanted && best.Height() >= options_.min_step_m;
  return best;
}

// Column of the summit of the parabola through a place's evidence and its neighbors'.
double StepTrack::Peak(std::size_t place) const {
  const double stride = options_.steps.stride;
  const std::vector<Way>& ways = ways_.to;
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

StepTrack::Estimate StepTrack::Update(std::span<const float> height_m, double time_s) {
  const std::vector<LocalStep> steps = FitLocalSteps(height_m, options_.steps);
  if (!last_time_s_ || time_s - *last_time_s_ > options_.forget_s ||
      ways_.to.size() != steps.size()) {
    *this = StepTrack(options_);
    ways_.to.resize(steps.size());
    strict_.to.resize(steps.size());
  }
  Estimate estimate;
  if (steps.empty()) return estimate;
  const auto strongest = std::ranges::max_element(steps, {}, &LocalStep::evidence);
  Continue(steps, strongest->evidence, last_time_s_ ? time_s - *last_time_s_ : 0.0);
  last_time_s_ = time_s;
  if (strongest->evidence > 0.0) {
    estimate.strongest = static_cast<int>(strongest - steps.begin()) * options_.steps.stride;
  }
  const Way& way = Judge(ways_);
  estimate.evidence = way.evidence / weight_;
  estimate.step_m = way.Height();
  const auto place = static_cast<std::size_t>(&way - ways_.to.data());
  const double position = OnLine(Peak(place), time_s);
  Judge(strict_);
  estimate.goes_on = ways_.edge && strict_.edge;
  if (ways_.edge) {
    estimate.column = std::clamp(position, 0.0, static_cast<double>(height_m.size() - 1));
  }
  return estimate;
}

}  // namespace rangegrasp::seam
