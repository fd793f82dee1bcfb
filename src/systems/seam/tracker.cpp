#include "seam/tracker.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/statistics.h"
#include "base/units.h"

namespace rangegrasp::seam {
namespace {

using base::kMm;
using base::YamlMap;

// ---- options ----

// A millisecond [s].
constexpr double kMs = 1e-3;

constexpr double kBaseColumns_1_m = 12'000.0;

// The line may have too few columns for windows scaled from the base sensor's.
void CheckSteps(const TrackerOptions& options) {
  const LocalStepOptions& steps = options.step_track.steps;
  const double narrowest = std::ranges::min(steps.half_windows);
  const double least_1_m = kBaseColumns_1_m * kMinHalfWindow / narrowest;
  if (options.line.columns_per_m >= least_1_m) return;
  throw std::invalid_argument(
      fmt::format("edge tracker: tracked steps (method steps) need {:.2f} columns per mm, the line "
                  "has {:.2f}; use method voting or weights",
                  least_1_m * kMm, options.line.columns_per_m * kMm));
}

void ReadFilter(YamlMap map, FilterOptions& options) {
  map.Read("half_width_columns", options.half_width_columns, 1, 512,
           "half width of the neighborhood of a point, in columns");
  map.ReadScaled("half_height_mm", options.half_height_m, kMm, 0.001, 100.0,
                 "half height of the neighborhood of a point");
  map.Read("min_neighbors", options.min_neighbors, 0, 1024,
           "minimum number of other points in the neighborhood; lower for a profile with holes");
  map.Finish();
}

void ReadDetectors(YamlMap map, DetectorOptions& options) {
  map.Read("model_levels", options.model_levels, "the two heights of the step in model fitting");
  map.Read("half_window_columns", options.local_weighted_voting.half_window, 1, 4096,
           "number of columns on each side that vote for a candidate (n of eq. 3.6)");
  map.Read("step_columns", options.local_weighted_voting.step_columns, 1, 4096,
           "number of columns on each side that give a candidate's height (k of eq. 3.5)");
  map.Read("candidates", options.local_weighted_voting.candidates, 1, 4096,
           "number of candidate columns of local weighted voting");
  map.Read("kernel", options.kernel, 0.001, 0.5,
           "half length of the largest gradient of gradient accumulation, relative to the profile");
  map.Finish();
}

void ReadStep(YamlMap map, StepOptions& options) {
  map.Read("rule", options.rule,
           "method for measuring the height: fit is a least-squares fit over the millimetres "
           "beside the step, range is as published");
  map.Read("fitted", options.fitted, 0.0, 1.0,
           "rule fit: minimum height of an edge's step, relative to min_step_mm");
  map.ReadScaled("period_ms", options.period_s, kMs, 1.0, 10'000.0,
                 "rule fit: time over which profiles are averaged; an edge that moves by more than "
                 "a millimetre in this time is blurred");
  map.ReadScaled("min_step_mm", options.min_step_m, kMm, 0.001, 100.0, "minimum height of an edge");
  map.Finish();
}

void ReadStepTrack(YamlMap map, StepTrackOptions& options) {
  map.ReadScaled("min_step_mm", options.min_step_m, kMm, 0.0, 100.0, "minimum height of an edge");
  map.Read("evidence", options.evidence, 0.0, 1e6,
           "mean log-likelihood ratio over many profiles that is required for an edge");
  map.Finish();
}

// For a method as published, disables our own rules: a step needs no confirmation by a second
// profile and counts anywhere if its range of heights (section 3.5.3) is high enough; packets are
// not refined, and the line's ends are not excluded. Lines of votes may have any slope, and no
// height is demanded of a vote: section 3.5.3 is an improvement of the weights (section 3.6).
TrackerOptions WithRulesOfMethod(TrackerOptions options) {
  if (!IsAsPublished(options.method)) return options;
  options.step.rule = StepRule::kRange;
  options.confirm = false;
  options.refine_m = 0.0;
  options.border_columns = 0;
  options.line_prediction.max_slope_columns_per_s = std::numeric_limits<double>::infinity();
  if (options.method == DecisionMethod::kVotingAsPublished) options.step.min_step_m = 0.0;
  return options;
}

// ---- tracking ----

// Number of last steps that may confirm the next one: as many as profiles in a period at 30 Hz
// (section 3.4). With a slower sensor, they are older than a period.
constexpr std::size_t kRecent = 3;
// Consecutive readings elsewhere that move a followed edge from its place: two periods at 50 Hz.
constexpr int kStrays = 10;
// A sampling time that equals a period's end up to rounding belongs to it.
constexpr double kTimeSlack_s = 1e-9;

// Columns on each side of the edge whose median height gives the edge's distance from the sensor:
// half a millimetre, over which the top of a mould of r = 30 mm falls by less than 0.01 mm.
constexpr int kHeightHalf = 6;

// Discards a detector's weights at the borders; the best remaining one replaces a position there.
void IgnoreBorders(std::size_t columns, DetectorResult& result) {
  auto& weight = result.weight;
  const std::size_t border = std::min(columns, weight.size() / 2);
  std::fill_n(weight.begin(), border, 0.0F);
  std::fill_n(weight.rbegin(), border, 0.0F);
  if (!result.column) return;
  const auto column = static_cast<std::size_t>(*result.column);
  if (column >= border && column + border < weight.size()) return;
  const auto best = std::ranges::max_element(weight);
  result.column.reset();
  if (*best > 0.0F) result.column = static_cast<int>(best - weight.begin());
}

// Runs the detectors on the part of the profile from the first to the last measured column, where
// holes are filled. Resulting columns and weights are those of the whole line.
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
  const long middle = std::lround(column);
  std::vector<float> heights;
  for (const float height : Within(height_m, middle - kHeightHalf, middle + kHeightHalf + 1)) {
    if (std::isfinite(height)) heights.push_back(height);
  }
  return heights.empty() ? 0.0 : base::UpperMedianOf(std::move(heights));
}

}  // namespace

TrackerOptions WithWindowsOfLine(const TrackerOptions& options) {
  TrackerOptions scaled = options;
  StepTrackOptions& track = scaled.step_track;
  const double scale = options.line.columns_per_m / kBaseColumns_1_m;
  const auto whole = [scale](int& columns, int least) {
    columns = std::max(least, static_cast<int>(std::lround(scale * columns)));
  };
  whole(scaled.border_columns, 0);
  whole(scaled.preprocess.filter.half_width_columns, 1);
  whole(scaled.preprocess.filter.min_neighbors, 0);
  if (!IsAsPublished(options.method)) {
    whole(scaled.detectors.local_weighted_voting.half_window, 1);
    whole(scaled.detectors.local_weighted_voting.step_columns, 1);
    whole(scaled.step.half_window, 1);
    whole(scaled.step.median_half_width, 0);
  }
  whole(track.steps.stride, 1);
  for (int& half : track.steps.half_windows) whole(half, 0);
  for (double* columns :
       {&scaled.line_prediction.inlier_columns, &scaled.line_prediction.max_slope_columns_per_s,
        &scaled.history.sigma_columns, &scaled.accumulation.spread_columns,
        &track.speed_columns_per_s, &track.max_speed_columns_per_s}) {
    *columns *= scale;
  }
  return scaled;
}

void ReadTrackerOptions(YamlMap& map, TrackerOptions& options) {
  map.Read(
      "method", options.method,
      "decision method of seam detect for the position of a profile's edge (there steps, if "
      "not given); experiments use all methods or those of decisions; the methods as published "
      "ignore border_columns, confirm, refine_mm and step.rule, and voting_as_published does not "
      "test the step's height");
  map.ReadScaled("columns_per_mm", options.line.columns_per_m, 1.0 / kMm, 0.1, 1000.0,
                 "columns per millimetre of the line; a simulated sensor's own value has priority. "
                 "All windows in columns are stated for 12 and scaled to it");
  ReadFilter(map.Child("filter", "geometric filter that removes isolated points"),
             options.preprocess.filter);
  map.Read("border_columns", options.border_columns, 0, 4096,
           "minimum distance of a reported edge from the first and the last measured column");
  ReadDetectors(map.Child("detectors", "the three detectors"), options.detectors);
  map.ReadScaled("vote_tolerance_mm", options.vote_tolerance_m, kMm, 0.01, 100.0,
                 "maximum distance between the positions of two detectors that agree");
  map.ReadScaled("packet_period_ms", options.packet_period_s, kMs, 1.0, 10'000.0,
                 "time between two packets to the robot");
  map.ReadScaled("refine_mm", options.refine_m, kMm, 0.0, 100.0,
                 "a packet has the position of the best-fitting step within this distance of the "
                 "decision; 0: the decision itself");
  map.Read("confirm", options.confirm,
           "whether a step must be confirmed by another of the last profiles");
  ReadStep(map.Child("step", "test of a step's height: whether there is an edge"), options.step);
  ReadStepTrack(map.Child("step_track", "method steps"), options.step_track);
  map.Read("positive_edge", options.positive_edge,
           "whether the edge rises with the column number; false: it falls");
}

struct EdgeTracker::Impl {
  Impl(const TrackerOptions& o, const std::optional<Calibration>& c)
      : options(o), calibration(c), step_track(o.step_track), step_test(o.line, o.step.period_s) {}

  TrackerOptions options;
  std::optional<Calibration> calibration;
  StepTrack step_track;
  PreparedProfile prepared;
  // Position to send for this profile; that of the reading may come from several.
  std::optional<double> at_once;
  std::array<DetectorResult, kDetectors> results;
  StepTest step_test;
  std::vector<float> weight;
  std::deque<double> times;  // of the last profiles
  // Positions with a step in the last packet period, at most kRecent with weights. They confirm the
  // next ones and, with voting, are the votes for a line.
  std::deque<TimedColumn> steps;
  std::optional<TimedColumn> sent;   // the last position transmitted
  std::optional<double> place;       // where the edge was followed to
  std::optional<double> followed_s;  // when it was followed in this period
  int strays = 0;                    // consecutive readings elsewhere
  std::vector<float> accumulated;
  std::vector<float> average;
  std::vector<double> history;  // decided positions, oldest first
  // Weights as published: the positions of the last packet period with their weights.
  struct Weighted {
    TimedColumn position;
    float weight;
  };
  std::deque<Weighted> detected;
  // The period of the next packet, and its content so far, with the column in a prepared profile.
  std::optional<double> period_begin_s;
  std::optional<EdgePacket> candidate;
  float candidate_weight = 0.0F;
  std::optional<EdgePacket> packet;

  void CheckProfile(const Profile& profile) const {
    if (static_cast<int>(profile.height_m.size()) != options.line.columns) {
      throw base::InputError(fmt::format("the profile has {} columns, the sensor's line has {}",
                                         profile.height_m.size(), options.line.columns));
    }
    if (!std::isfinite(profile.time_s) || (!times.empty() && profile.time_s < times.back())) {
      throw base::InputError(
          fmt::format("the profile's time {} s must be finite and not before that of the last one",
                      profile.time_s));
    }
  }

  // By the rule in the options; by the range of heights if too little of the line is measured for a
  // fit.
  double StepAt(double column, const std::vector<float>& height_m) {
    std::optional<double> fitted;
    if (options.step.rule == StepRule::kFit) fitted = step_test.HeightAt(column);
    return fitted ? *fitted
                  : StepHeight(height_m, static_cast<int>(std::lround(column)), options.step);
  }

  bool IsStep(double step_m, bool goes_on) const {
    if (options.step.rule == StepRule::kRange) return step_m >= options.step.min_step_m;
    const double share = goes_on ? options.step.fitted : options.step.fitted_first;
    return step_m >= share * options.step.min_step_m;
  }

  // True if the last profiles have a step at the predicted place; kRange cannot tell.
  bool FitsAt(double column) {
    return options.step.rule != StepRule::kFit || IsStep(StepAt(column, prepared.height_m), true);
  }

  bool IsOnLine(const std::optional<double>& column) const {
    return column && *column >= 0.0 && *column <= options.line.columns - 1;
  }

  // The highest step at the detectors' positions.
  double HighestStep(const Reading& reading) {
    double highest = 0.0;
    for (const auto& column : reading.detected) {
      if (column) highest = std::max(highest, StepAt(*column, prepared.height_m));
    }
    return highest;
  }

  void ForgetOld(double time_s) {
    times.push_back(time_s);
    if (times.size() > kRecent) times.pop_front();
    const double oldest_s = std::min(times.front(), time_s - options.packet_period_s);
    while (!steps.empty() && steps.front().time_s < oldest_s) steps.pop_front();
    while (!detected.empty() && detected.front().position.time_s < oldest_s) detected.pop_front();
    // Section 3.4 assumes a straight edge between two packets, not over longer times.
    if (sent && sent->time_s < oldest_s - options.packet_period_s) sent.reset();
  }

  // The column as the sensor counts it.
  double OfLine(double column) const {
    return options.positive_edge ? column : options.line.columns - 1 - column;
  }

  // x of an edge in a column of the prepared profile.
  double LateralAt(double column) const {
    if (!calibration) return options.line.ToMeters(OfLine(column));
    return calibration->LateralAt(OfLine(column), HeightAround(prepared.original_m, column));
  }

  std::optional<double> PredictFromVotes(double time_s) {
    if (steps.empty()) return std::nullopt;  // the last position sent is too old to be used alone
    std::vector<TimedColumn> found;
    if (sent) found.push_back(*sent);
    found.insert(found.end(), steps.begin(), steps.end());
    // A single position may be a disturbance: two must confirm each other.
    const auto prediction = PredictByLine(found, time_s, options.line_prediction);
    if (!prediction || (options.confirm && prediction->inliers < 2)) return std::nullopt;
    return prediction->column;
  }

  // Section 3.4: two of three, then a line through a period's votes and the last position sent.
  void DecideByVoting(Reading& reading) {
    const double tolerance = ToColumns(options.vote_tolerance_m);
    const auto vote = VoteTwoOfThree(reading.detected, tolerance);
    reading.step_m = vote ? StepAt(*vote, prepared.height_m) : HighestStep(reading);
    // A profile whose step is too small gives no vote; the others of the period still give the
    // edge.
    const auto expected = PredictFromVotes(reading.time_s);
    const bool goes_on = vote && expected && std::abs(*vote - *expected) <= tolerance;
    const bool step = IsStep(reading.step_m, goes_on);
    if (vote && step) steps.push_back({reading.time_s, *vote});
    reading.column = PredictFromVotes(reading.time_s);
    if (reading.column && !step && !FitsAt(*reading.column)) reading.column.reset();
    // A steep line may leave the profile.
    if (IsAsPublished(options.method) && !IsOnLine(reading.column)) reading.column.reset();
    if (reading.column) {
      reading.status = ProfileStatus::kEdge;
      if (!vote) reading.step_m = StepAt(*reading.column, prepared.height_m);
    } else {
      // A step that no other profile of the period confirms is a disturbance.
      const bool several = vote && step && steps.size() >= 2;
      reading.status = several ? ProfileStatus::kAmbiguous : ProfileStatus::kNoEdge;
    }
  }

  std::vector<float> Accumulate() {
    auto spread = results;
    auto& candidates = spread[static_cast<std::size_t>(Detector::kLocalWeightedVoting)].weight;
    candidates = SpreadWeights(candidates, options.accumulation.spread_columns);
    accumulated.resize(candidates.size(), 0.0F);
    const auto memory = static_cast<float>(options.accumulation.memory);
    const std::vector<float> sum = SumOfWeights(spread);
    for (std::size_t i = 0; i < sum.size(); ++i) accumulated[i] = memory * accumulated[i] + sum[i];
    return accumulated;
  }

  // The prepared heights, averaged with those of earlier profiles, which decay like the weights.
  const std::vector<float>& Average() {
    if (average.empty()) average = prepared.height_m;
    const auto memory = static_cast<float>(options.accumulation.memory);
    for (std::size_t i = 0; i < average.size(); ++i) {
      average[i] = memory * average[i] + (1.0F - memory) * prepared.height_m[i];
    }
    return average;
  }

  // Section 3.5: the maximum of the summed weights, which are higher near earlier edges.
  void DecideByWeights(Reading& reading) {
    const bool averaged = options.method == DecisionMethod::kAccumulated;
    weight = averaged ? Accumulate() : SumOfWeights(results);
    WeightByHistory(weight, history, options.history.sigma_columns);
    const auto column = static_cast<int>(std::ranges::max_element(weight) - weight.begin());
    reading.step_m = StepAt(column, averaged ? Average() : prepared.height_m);
    const double tolerance = ToColumns(options.vote_tolerance_m);
    const bool goes_on = std::ranges::any_of(
        steps, [&](const auto& earlier) { return std::abs(column - earlier.column) <= tolerance; });
    // A step that none of the last profiles confirms is a disturbance.
    const bool step = IsStep(reading.step_m, goes_on);
    if (step) steps.push_back({reading.time_s, static_cast<double>(column)});
    if (steps.size() > kRecent) steps.pop_front();
    if (!step || (options.confirm && !goes_on)) {
      reading.status = ProfileStatus::kNoEdge;
      return;
    }
    reading.status = ProfileStatus::kEdge;
    reading.column = column;
    history.push_back(column);
    if (static_cast<int>(history.size()) > options.history.length) history.erase(history.begin());
  }

  // Eq. 3.17 and 3.21: of the positions detected in a packet period, the one with the highest
  // weight, as a reading of voting covers the last period, too.
  void TakeHighestOfPeriod(Reading& reading) {
    if (reading.column) {
      const float its_weight = weight[static_cast<std::size_t>(*reading.column)];
      detected.push_back({{reading.time_s, *reading.column}, its_weight});
    }
    if (detected.empty()) return;
    const auto best = std::max_element(  // the latest of several
        detected.rbegin(), detected.rend(),
        [](const Weighted& a, const Weighted& b) { return a.weight < b.weight; });
    reading.goes_on = reading.column.has_value();
    reading.status = ProfileStatus::kEdge;
    reading.column = best->position.column;
  }

  // The fourth detector uses the measured heights, of which it needs only a few.
  void DecideBySteps(Reading& reading) {
    const auto points =
        std::ranges::count_if(prepared.original_m, [](float z) { return std::isfinite(z); });
    const StepTrack::Estimate found =
        step_track.Update(prepared.original_m, reading.time_s, ToColumns(prepared.moved_m));
    if (points < kMinColumns) return;
    at_once = found.at_once;
    // As in the other methods: a line through several profiles is more precise, if close enough.
    if (at_once && found.column &&
        std::abs(*at_once - *found.column) <= ToColumns(options.keep_m)) {
      at_once = found.column;
    }
    reading.column = found.column;
    reading.local_step = found.strongest;
    reading.step_m = found.step_m;
    reading.goes_on = found.goes_on;
    reading.sure = found.sure;
    reading.followed_step_m = found.followed_step_m;
    reading.status = found.column ? ProfileStatus::kEdge : ProfileStatus::kNoEdge;
  }

  void Decide(Reading& reading) {
    results = {};
    weight.clear();
    at_once.reset();
    if (options.method == DecisionMethod::kSteps) return DecideBySteps(reading);
    step_test.Take(prepared);
    if (!prepared.Usable()) return;
    results = DetectWithin(prepared, options);
    for (std::size_t d = 0; d < kDetectors; ++d) reading.detected[d] = results[d].column;
    if (options.method == DecisionMethod::kVoting ||
        options.method == DecisionMethod::kVotingAsPublished) {
      DecideByVoting(reading);
    } else {
      DecideByWeights(reading);
    }
    at_once = reading.column;
    if (options.method == DecisionMethod::kWeightsAsPublished) TakeHighestOfPeriod(reading);
    Follow(reading);
  }

  double ToColumns(double length_m) const { return length_m * options.line.columns_per_m; }

  EdgePacket PacketOf(double time_s, double column, std::optional<bool> sure = {}) const {
    return {time_s, column, LateralAt(column), sure};
  }

  // With weights the strongest position of a period is sent (eq. 3.17), else the latest.
  void Offer(const Reading& reading) {
    if (!at_once) return;
    const float its_weight = weight.empty() ? 0.0F : weight[static_cast<std::size_t>(*at_once)];
    if (candidate && its_weight < candidate_weight) return;
    candidate = PacketOf(reading.time_s, *at_once, reading.sure);
    candidate_weight = its_weight;
  }

  // The decided position is sent unless a step nearby fits the period's profiles better.
  void Refine() {
    const auto column = step_test.Locate(*candidate->column, ToColumns(options.refine_m));
    if (!column || std::abs(*column - *candidate->column) <= ToColumns(options.keep_m)) return;
    candidate = PacketOf(step_test.MiddleTime(), *column, candidate->sure);
  }

  // An edge moves little from one profile to the next: while a step fits at its place, it stays
  // there, whatever the detectors find elsewhere. Only many consecutive readings elsewhere with a
  // higher step move it.
  void Follow(Reading& reading) {
    if (options.step.rule != StepRule::kFit) return;
    const double reach = ToColumns(options.refine_m);
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
    if (decided || goes_on) followed_s = step_test.MiddleTime();
  }

  void EndPeriod(double time_s) {
    if (!period_begin_s) period_begin_s = time_s;
    if (time_s < *period_begin_s + options.packet_period_s - kTimeSlack_s) return;
    // Tracked steps are already fitted.
    if (options.refine_m > 0.0 && options.method != DecisionMethod::kSteps) {
      if (candidate) Refine();
      // Without a decision: the place to which the edge was followed in the period.
      if (!candidate && followed_s) candidate = PacketOf(*followed_s, *place);
    }
    packet = candidate.value_or(EdgePacket{.time_s = time_s});
    if (candidate) {
      sent = {candidate->time_s, *candidate->column};
      packet->column = OfLine(*candidate->column);
    }
    candidate.reset();
    followed_s.reset();
    candidate_weight = 0.0F;
    // Packets keep their period, independent of the profiles' times.
    *period_begin_s +=
        options.packet_period_s *
        std::floor((time_s + kTimeSlack_s - *period_begin_s) / options.packet_period_s);
  }
};

EdgeTracker::EdgeTracker(const TrackerOptions& options,
                         const std::optional<Calibration>& calibration) {
  if (options.method == DecisionMethod::kSteps) CheckSteps(options);
  impl_ = std::make_unique<Impl>(WithWindowsOfLine(WithRulesOfMethod(options)), calibration);
}
EdgeTracker::~EdgeTracker() = default;
EdgeTracker::EdgeTracker(EdgeTracker&&) noexcept = default;

Reading EdgeTracker::Update(const Profile& profile) {
  Impl& t = *impl_;
  t.CheckProfile(profile);
  Profile mirrored = profile;
  if (!t.options.positive_edge) {
    std::ranges::reverse(mirrored.height_m);
    mirrored.moved_m = -profile.moved_m;
  }
  t.prepared = Prepare(mirrored, t.options.preprocess);
  Reading reading;
  reading.time_s = profile.time_s;
  t.ForgetOld(profile.time_s);
  t.Decide(reading);
  if (reading.column) reading.x_m = t.LateralAt(*reading.column);
  t.Offer(reading);
  t.EndPeriod(profile.time_s);
  if (reading.column) reading.column = t.OfLine(*reading.column);
  for (auto& column : reading.detected) {
    if (column) column = static_cast<int>(t.OfLine(*column));
  }
  if (reading.local_step) reading.local_step = static_cast<int>(t.OfLine(*reading.local_step));
  return reading;
}

std::optional<EdgePacket> EdgeTracker::TakePacket() {
  return std::exchange(impl_->packet, std::nullopt);
}

const PreparedProfile& EdgeTracker::prepared() const { return impl_->prepared; }
const std::array<DetectorResult, kDetectors>& EdgeTracker::results() const {
  return impl_->results;
}
const std::vector<float>& EdgeTracker::weight() const { return impl_->weight; }
bool EdgeTracker::mirrored() const { return !impl_->options.positive_edge; }

}  // namespace rangegrasp::seam
