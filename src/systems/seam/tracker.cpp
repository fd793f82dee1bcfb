#include "seam/tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <span>

#include "base/error.h"
#include "base/quantile.h"
#include "seam/step_test.h"

namespace rangegrasp::seam {
namespace {

// Steps that may bear out the next one: as many as there are profiles in a period at 30 Hz (section
// 3.4). A slower sensor's are older than a period.
constexpr std::size_t kRecent = 3;
// Readings in a row that draw an edge that is followed away from its place: two periods at 50 Hz.
constexpr int kStrays = 10;
// A sampling time that falls on a period's end by rounding belongs to it.
constexpr double kTimeSlack_s = 1e-9;

// Columns on each side of the edge whose median height tells how far the edge is from the sensor:
// half a millimetre, over which the top of a mould of r = 30 mm falls by less than 0.01 mm.
constexpr int kHeightHalf = 6;

// Leaves out what a detector found at the borders; its position becomes the best of the others.
void IgnoreBorders(std::size_t columns, DetectorResult& result) {
  auto& weight = result.weight;
  const std::size_t border = std::min(columns, weight.size() / 2);
  std::fill_n(weight.begin(), border, 0.0F);
  std::fill_n(weight.rbegin(), border, 0.0F);
  if (!result.column) return;
  const auto column = static_cast<std::size_t>(*result.column);
  if (column >= border && column + border < weight.size()) return;
  const auto best = std::max_element(weight.begin(), weight.end());
  result.column.reset();
  if (*best > 0.0F) result.column = static_cast<int>(best - weight.begin());
}

// Runs the detectors on the columns that were measured: what lies outside of the first and the last
// of them is no part of the profile (a hole within it is filled). Columns and weights are those of
// the whole line.
std::array<DetectorResult, kDetectors> DetectWithin(const PreparedProfile& prepared,
                                                    const TrackerOptions& options) {
  const auto first = static_cast<std::size_t>(prepared.first_column);
  const auto count = static_cast<std::size_t>(prepared.last_column - prepared.first_column + 1);
  auto results = DetectEdges(std::span(prepared.height_m).subspan(first, count), options.detectors);
  for (DetectorResult& result : results) {
    IgnoreBorders(static_cast<std::size_t>(options.border_columns), result);
    if (result.column) *result.column += prepared.first_column;
    result.weight.insert(result.weight.begin(), first, 0.0F);
    result.weight.resize(prepared.height_m.size(), 0.0F);
  }
  return results;
}

double HeightAround(std::span<const float> height_m, double column) {
  std::vector<float> heights;
  const int middle = static_cast<int>(std::lround(column));
  const int last = static_cast<int>(height_m.size()) - 1;
  for (int c = std::max(0, middle - kHeightHalf); c <= std::min(last, middle + kHeightHalf); ++c) {
    const float height = height_m[static_cast<std::size_t>(c)];
    if (std::isfinite(height)) heights.push_back(height);
  }
  if (heights.empty()) return 0.0;
  return base::UpperMedianOf(std::move(heights));
}

int MaximumAt(const std::vector<float>& weight) {
  return static_cast<int>(std::max_element(weight.begin(), weight.end()) - weight.begin());
}

}  // namespace

struct EdgeTracker::Impl {
  Impl(const TrackerOptions& o, const std::optional<Calibration>& c)
      : options(o),
        calibration(c),
        step_track(o.step_track),
        step_test(o.line, {.period_s = o.step.period_s}) {}

  TrackerOptions options;
  std::optional<Calibration> calibration;
  StepTrack step_track;
  PreparedProfile prepared;
  std::optional<double> at_once;  // method steps: what is sent of this profile
  double moved_columns = 0.0;     // of the line since the profile before, along the prepared one
  std::array<DetectorResult, kDetectors> results;
  StepTest step_test;
  std::vector<float> weight;
  std::optional<double> last_time_s;
  std::deque<double> times;         // of the last profiles
  std::deque<TimedColumn> votes;    // of the last packet period
  std::optional<TimedColumn> sent;  // the last position transmitted
  std::optional<double> place;      // where the edge has been followed to
  bool followed = false;            // in this period
  int strays = 0;                   // readings in a row that were elsewhere
  std::vector<double> recent;       // positions of the last steps, decided or not, oldest first
  std::vector<float> accumulated;
  std::vector<float> average;
  std::vector<double> history;  // decided positions, oldest first
  // The period that the next packet tells of.
  std::optional<double> period_begin_s;
  std::optional<TimedColumn> candidate;
  double candidate_x_m = 0.0;
  float candidate_weight = 0.0F;
  std::optional<bool> candidate_sure;
  std::optional<EdgePacket> packet;

  void CheckProfile(const Profile& profile) const;
  std::vector<float> Accumulate();
  const std::vector<float>& Average();
  // These return the weight with which the reading is offered for the next packet.
  float Decide(Reading& reading);
  float DecideByVoting(Reading& reading);
  float DecideByWeights(Reading& reading);
  float DecideBySteps(Reading& reading);
  double StepAt(double column, const std::vector<float>& height_m);
  double HighestStep(const Reading& reading);
  void ForgetOldVotes(double time_s);
  double OfLine(double column) const;
  double LateralAt(double column) const;
  void Offer(const Reading& reading, float its_weight);
  void Refine();
  void Follow(Reading& reading);
  void OfferFollowed();
  void EndPeriod(double time_s);
  std::optional<double> PredictFromVotes(double time_s);
  bool IsStep(double step_m, bool goes_on) const;
  bool FitsAt(double column);
  EdgePacket PacketAt(double time_s) const;
};

void EdgeTracker::Impl::CheckProfile(const Profile& profile) const {
  if (static_cast<int>(profile.height_m.size()) != options.line.columns) {
    throw base::InputError(fmt::format("the profile has {} columns, the sensor's line has {}",
                                       profile.height_m.size(), options.line.columns));
  }
  if (!std::isfinite(profile.time_s) || (last_time_s && profile.time_s < *last_time_s)) {
    throw base::InputError(
        fmt::format("the profile's time {} s must be finite and not before that of the last one",
                    profile.time_s));
  }
}

// By the rule that the options name; by their range where there is not enough of the line for a
// fit.
double EdgeTracker::Impl::StepAt(double column, const std::vector<float>& height_m) {
  const auto fitted =
      options.step.rule == StepRule::kFit ? step_test.HeightAt(column) : std::nullopt;
  if (fitted) return *fitted;
  return StepHeight(height_m, static_cast<int>(std::lround(column)), options.step);
}

bool EdgeTracker::Impl::IsStep(double step_m, bool goes_on) const {
  const bool fit = options.step.rule == StepRule::kFit;
  const double first = fit ? options.step.fitted_first : 1.0;
  const double next = fit ? options.step.fitted : options.step.continued;
  return step_m >= (goes_on ? next : first) * options.step.min_step_m;
}

// Whether the last profiles have a step where it is predicted; the rule of ranges cannot tell.
bool EdgeTracker::Impl::FitsAt(double column) {
  return options.step.rule != StepRule::kFit || IsStep(StepAt(column, prepared.height_m), true);
}

// The step where any detector sees its edge.
double EdgeTracker::Impl::HighestStep(const Reading& reading) {
  double highest = 0.0;
  for (const auto& column : reading.detected) {
    if (column) highest = std::max(highest, StepAt(*column, prepared.height_m));
  }
  return highest;
}

void EdgeTracker::Impl::ForgetOldVotes(double time_s) {
  times.push_back(time_s);
  if (times.size() > kRecent) times.pop_front();
  const double oldest_s = std::min(times.front(), time_s - options.packet_period_s);
  while (!votes.empty() && votes.front().time_s < oldest_s) votes.pop_front();
}

// The column as the sensor counts it.
double EdgeTracker::Impl::OfLine(double column) const {
  return options.positive_edge ? column : options.line.columns - 1 - column;
}

// x of an edge in a column of the prepared profile.
double EdgeTracker::Impl::LateralAt(double column) const {
  if (!calibration) return options.line.ToMeters(OfLine(column));
  return calibration->LateralAt(OfLine(column), HeightAround(prepared.original_m, column));
}

std::optional<double> EdgeTracker::Impl::PredictFromVotes(double time_s) {
  if (votes.empty()) return std::nullopt;  // what was sent long ago tells nothing alone
  std::vector<TimedColumn> found;
  if (sent) found.push_back(*sent);
  found.insert(found.end(), votes.begin(), votes.end());
  // One position alone may be a disturbance: two must bear each other out.
  const auto prediction = PredictByLine(found, time_s, options.line_prediction);
  if (!prediction || (options.confirm && prediction->inliers < 2)) return std::nullopt;
  return prediction->column;
}

// Section 3.4: two of three, then a line through the votes of a period and what was sent last.
float EdgeTracker::Impl::DecideByVoting(Reading& reading) {
  const double tolerance = options.vote_tolerance_m * options.line.columns_per_m;
  const auto vote = VoteTwoOfThree(reading.detected, tolerance);
  reading.step_m = vote ? StepAt(*vote, prepared.height_m) : HighestStep(reading);
  // A profile whose step is too small gives no vote; the others of the period still tell where the
  // edge is.
  const auto expected = PredictFromVotes(reading.time_s);
  const bool goes_on = vote && expected && std::abs(*vote - *expected) <= tolerance;
  const bool step = IsStep(reading.step_m, goes_on);
  if (vote && step) votes.push_back({reading.time_s, *vote});
  reading.column = PredictFromVotes(reading.time_s);
  if (reading.column && !step && !FitsAt(*reading.column)) reading.column.reset();
  if (reading.column) {
    reading.status = ProfileStatus::kEdge;
    if (!vote) reading.step_m = StepAt(*reading.column, prepared.height_m);
  } else {
    // A step that no other profile of the period bears out is a disturbance.
    const bool several = vote && step && votes.size() >= 2;
    reading.status = several ? ProfileStatus::kAmbiguous : ProfileStatus::kNoEdge;
  }
  return 0.0F;
}

std::vector<float> EdgeTracker::Impl::Accumulate() {
  auto spread = results;
  auto& candidates = spread[static_cast<std::size_t>(Detector::kLocalWeightedVoting)].weight;
  candidates = SpreadWeights(candidates, options.accumulation.spread_columns);
  accumulated.resize(candidates.size(), 0.0F);
  const auto memory = static_cast<float>(options.accumulation.memory);
  const std::vector<float> sum = SumOfWeights(spread);
  for (std::size_t i = 0; i < sum.size(); ++i) accumulated[i] = memory * accumulated[i] + sum[i];
  return accumulated;
}

// The prepared heights, averaged with those of earlier profiles that fade out as the weights do.
const std::vector<float>& EdgeTracker::Impl::Average() {
  if (average.empty()) average = prepared.height_m;
  const auto memory = static_cast<float>(options.accumulation.memory);
  for (std::size_t i = 0; i < average.size(); ++i) {
    average[i] = memory * average[i] + (1.0F - memory) * prepared.height_m[i];
  }
  return average;
}

// Section 3.5: the largest of the summed weights, of which those near earlier edges count more.
float EdgeTracker::Impl::DecideByWeights(Reading& reading) {
  weight = options.method == DecisionMethod::kAccumulated ? Accumulate() : SumOfWeights(results);
  WeightByHistory(weight, history, options.history.sigma_columns);
  const int column = MaximumAt(weight);
  const bool averaged = options.method == DecisionMethod::kAccumulated;
  reading.step_m = StepAt(column, averaged ? Average() : prepared.height_m);
  const double tolerance = options.vote_tolerance_m * options.line.columns_per_m;
  const bool goes_on = std::ranges::any_of(
      recent, [&](double earlier) { return std::abs(column - earlier) <= tolerance; });
  // A step that none of the last profiles bears out is a disturbance.
  const bool step = IsStep(reading.step_m, goes_on);
  if (step) recent.push_back(column);
  if (recent.size() > kRecent) recent.erase(recent.begin());
  if (!step || (options.confirm && !goes_on)) {
    reading.status = ProfileStatus::kNoEdge;
    return 0.0F;
  }
  reading.status = ProfileStatus::kEdge;
  reading.column = column;
  history.push_back(column);
  if (static_cast<int>(history.size()) > options.history.length) history.erase(history.begin());
  return weight[static_cast<std::size_t>(column)];
}

// The fourth detector works on heights as measured, of which it needs few.
float EdgeTracker::Impl::DecideBySteps(Reading& reading) {
  const auto points =
      std::ranges::count_if(prepared.original_m, [](float z) { return std::isfinite(z); });
  const StepTrack::Estimate found =
      step_track.Update(prepared.original_m, reading.time_s, moved_columns);
  at_once.reset();
  if (points < kMinColumns) return 0.0F;
  reading.local_step = found.strongest;
  reading.column = found.column;
  at_once = found.at_once;
  // As of the other methods: a line through several profiles is sharper where it is near enough.
  const double keep = options.keep_m * options.line.columns_per_m;
  if (at_once && found.column && std::abs(*at_once - *found.column) <= keep) at_once = found.column;
  reading.step_m = found.step_m;
  reading.goes_on = found.goes_on;
  reading.sure = found.sure;
  reading.followed_step_m = found.followed_step_m;
  reading.status = found.column ? ProfileStatus::kEdge : ProfileStatus::kNoEdge;
  return 0.0F;
}

float EdgeTracker::Impl::Decide(Reading& reading) {
  results = {};
  if (options.method == DecisionMethod::kSteps) return DecideBySteps(reading);
  step_test.Take(prepared);
  if (!prepared.Usable()) return 0.0F;
  results = DetectWithin(prepared, options);
  for (std::size_t d = 0; d < kDetectors; ++d) reading.detected[d] = results[d].column;
  const float its_weight = options.method == DecisionMethod::kVoting ? DecideByVoting(reading)
                                                                     : DecideByWeights(reading);
  Follow(reading);
  return its_weight;
}

// With weights the strongest position of a period is sent (eq. 3.17), else the latest.
void EdgeTracker::Impl::Offer(const Reading& reading, float its_weight) {
  const auto column = options.method == DecisionMethod::kSteps ? at_once : reading.column;
  if (!column || (candidate && its_weight < candidate_weight)) return;
  candidate = TimedColumn{reading.time_s, *column};
  candidate_x_m = LateralAt(*column);
  candidate_weight = its_weight;
  candidate_sure = reading.sure;
}

EdgePacket EdgeTracker::Impl::PacketAt(double time_s) const {
  EdgePacket made;
  made.time_s = time_s;
  if (!candidate) return made;
  made.time_s = candidate->time_s;
  made.column = OfLine(candidate->column);
  made.x_m = candidate_x_m;
  made.sure = candidate_sure;
  return made;
}

// What was decided is sent unless a step fits the period's profiles best elsewhere near by.
void EdgeTracker::Impl::Refine() {
  const auto column =
      step_test.Locate(candidate->column, options.refine_m * options.line.columns_per_m);
  const double apart = column ? std::abs(*column - candidate->column) : 0.0;
  if (apart <= options.keep_m * options.line.columns_per_m) return;
  candidate = TimedColumn{step_test.MiddleTime(), *column};
  candidate_x_m = LateralAt(*column);
}

// An edge moves little from one profile to the next: as long as a step fits where it was, it is
// there, whatever the detectors see elsewhere. Many readings elsewhere with a higher step are
// right.
void EdgeTracker::Impl::Follow(Reading& reading) {
  if (options.step.rule != StepRule::kFit) return;
  const double reach = options.refine_m * options.line.columns_per_m;
  const bool decided = reading.column && IsStep(reading.step_m, true);
  const auto found = place ? step_test.Locate(*place, reach) : std::nullopt;
  const double step_m = found ? step_test.HeightAt(*found).value_or(0.0) : 0.0;
  const bool goes_on = IsStep(step_m, true);
  const bool stray = decided && place && std::abs(*reading.column - *place) > reach;
  strays = stray && reading.step_m > step_m ? strays + 1 : 0;
  if (decided && (!goes_on || !stray || strays >= kStrays)) {
    place = *reading.column;
    strays = 0;
    reading.followed_step_m = reading.step_m;
  } else if (goes_on) {
    place = *found;
    reading.followed_step_m = step_m;
  }
  followed = followed || decided || goes_on;
}

// Where nothing was decided in a period the place is sent to which the edge was followed in it.
void EdgeTracker::Impl::OfferFollowed() {
  if (candidate || !followed) return;
  candidate = TimedColumn{step_test.MiddleTime(), *place};
  candidate_x_m = LateralAt(*place);
}

void EdgeTracker::Impl::EndPeriod(double time_s) {
  if (!period_begin_s) period_begin_s = time_s;
  if (time_s < *period_begin_s + options.packet_period_s - kTimeSlack_s) return;
  // Steps that are tracked have been fitted already.
  if (options.refine_m > 0.0 && options.method != DecisionMethod::kSteps) {
    if (candidate) Refine();
    OfferFollowed();
  }
  packet = PacketAt(time_s);
  if (candidate) sent = candidate;
  candidate.reset();
  followed = false;
  candidate_weight = 0.0F;
  // Packets keep their period, whatever the profiles' times are.
  *period_begin_s +=
      options.packet_period_s *
      std::floor((time_s + kTimeSlack_s - *period_begin_s) / options.packet_period_s);
}

EdgeTracker::EdgeTracker(const TrackerOptions& options,
                         const std::optional<Calibration>& calibration) {
  CheckOptions(options);
  impl_ = std::make_unique<Impl>(WithWindowsOfLine(options), calibration);
}
EdgeTracker::~EdgeTracker() = default;
EdgeTracker::EdgeTracker(EdgeTracker&&) noexcept = default;

Reading EdgeTracker::Update(const Profile& profile) {
  Impl& t = *impl_;
  t.CheckProfile(profile);
  t.last_time_s = profile.time_s;
  Profile mirrored;
  if (!t.options.positive_edge) {
    mirrored = profile;
    std::reverse(mirrored.height_m.begin(), mirrored.height_m.end());
    mirrored.moved_m = -profile.moved_m;
  }
  t.prepared = Prepare(t.options.positive_edge ? profile : mirrored, t.options.preprocess);
  t.moved_columns = t.prepared.moved_m * t.options.line.columns_per_m;
  t.weight.clear();
  Reading reading;
  reading.time_s = profile.time_s;
  t.ForgetOldVotes(profile.time_s);
  const float weight = t.Decide(reading);
  if (reading.column) reading.x_m = t.LateralAt(*reading.column);
  t.Offer(reading, weight);
  t.EndPeriod(profile.time_s);
  if (reading.column) reading.column = t.OfLine(*reading.column);
  for (auto& column : reading.detected) {
    if (column) column = static_cast<int>(t.OfLine(*column));
  }
  if (reading.local_step) reading.local_step = static_cast<int>(t.OfLine(*reading.local_step));
  return reading;
}

std::optional<EdgePacket> EdgeTracker::TakePacket() {
  std::optional<EdgePacket> packet;
  std::swap(packet, impl_->packet);
  return packet;
}

const PreparedProfile& EdgeTracker::prepared() const { return impl_->prepared; }
const std::array<DetectorResult, kDetectors>& EdgeTracker::results() const {
  return impl_->results;
}
const std::vector<float>& EdgeTracker::weight() const { return impl_->weight; }
void EdgeTracker::Reset() { impl_ = std::make_unique<Impl>(impl_->options, impl_->calibration); }

}  // namespace rangegrasp::seam
