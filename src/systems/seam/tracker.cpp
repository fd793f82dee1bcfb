#include "seam/tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/statistics.h"
#include "base/units.h"
#include "seam/decision.h"

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

void ReadStepTrack(YamlMap map, StepTrackOptions& options) {
  map.ReadScaled("min_step_mm", options.min_step_m, kMm, 0.0, 100.0, "minimum height of an edge");
  map.Read("evidence", options.evidence, 0.0, 1e6,
           "mean log-likelihood ratio over many profiles that is required for an edge");
  map.Finish();
}

// ---- tracking ----

// Maximum distance between the positions of two detectors that agree: 1 mm.
constexpr double kVoteTolerance_m = 1e-3;
// n of eq. 3.19: number of profiles in 100 ms at 100 Hz.
constexpr std::size_t kHistory = 10;
// Number of last profiles whose votes count: as many as in a period at 30 Hz (section 3.4). With a
// slower sensor, they are older than a period.
constexpr std::size_t kRecent = 3;
// A line through several profiles this close to the best place is more precise than the place.
constexpr double kKeep_m = 0.5e-3;
// A sampling time that equals a period's end up to rounding belongs to it.
constexpr double kTimeSlack_s = 1e-9;

// Columns on each side of the edge whose median height gives the edge's distance from the sensor:
// half a millimetre, over which the top of a mould of r = 30 mm falls by less than 0.01 mm.
constexpr int kHeightHalf = 6;

// Runs the detectors on the part of the profile from the first to the last measured column, where
// holes are filled. Resulting columns and weights are those of the whole line.
std::array<DetectorResult, kDetectors> DetectWithin(const PreparedProfile& prepared) {
  const auto first = static_cast<std::size_t>(prepared.first_column);
  const auto count = static_cast<std::size_t>(prepared.last_column - prepared.first_column + 1);
  auto results = DetectEdges(std::span(prepared.height_m).subspan(first, count));
  for (DetectorResult& result : results) {
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
  whole(scaled.filter.half_width_columns, 1);
  whole(scaled.filter.min_neighbors, 0);
  whole(track.steps.stride, 1);
  for (int& half : track.steps.half_windows) whole(half, 0);
  for (double* columns : {&scaled.inlier_columns, &scaled.history_sigma_columns,
                          &track.speed_columns_per_s, &track.max_speed_columns_per_s}) {
    *columns *= scale;
  }
  return scaled;
}

void ReadTrackerOptions(YamlMap& map, TrackerOptions& options) {
  map.Read("method", options.method,
           "decision method of seam detect for the position of a profile's edge; experiments use "
           "all methods or those of decisions");
  map.ReadScaled("columns_per_mm", options.line.columns_per_m, 1.0 / kMm, 0.1, 1000.0,
                 "columns per millimetre of the line; a simulated sensor's own value has priority");
  map.ReadScaled("packet_period_ms", options.packet_period_s, kMs, 1.0, 10'000.0,
                 "time between two packets to the robot");
  ReadStepTrack(map.Child("step_track", "method steps"), options.step_track);
  map.Read("positive_edge", options.positive_edge,
           "whether the edge rises with the column number; false: it falls");
}

struct EdgeTracker::Impl {
  Impl(const TrackerOptions& o, const std::optional<Calibration>& c)
      : options(o), calibration(c), step_track(o.step_track) {}

  TrackerOptions options;
  std::optional<Calibration> calibration;
  StepTrack step_track;
  PreparedProfile prepared;
  // Position to send for this profile; that of the reading may come from several.
  std::optional<double> at_once;
  std::array<DetectorResult, kDetectors> results;
  std::vector<float> weight;
  std::deque<double> times;         // of the last profiles
  std::deque<TimedColumn> votes;    // kVoting: of the last packet period
  std::optional<TimedColumn> sent;  // the last position transmitted
  std::vector<double> history;      // kWeights: decided positions, oldest first
  // kWeights: the positions of the last packet period with their weights.
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

  double StepAt(double column) const {
    return StepHeight(prepared.height_m, static_cast<int>(std::lround(column)));
  }

  // The highest step at the detectors' positions.
  double HighestStep(const Reading& reading) const {
    double highest = 0.0;
    for (const auto& column : reading.detected) {
      if (column) highest = std::max(highest, StepAt(*column));
    }
    return highest;
  }

  void ForgetOld(double time_s) {
    times.push_back(time_s);
    if (times.size() > kRecent) times.pop_front();
    const double oldest_s = std::min(times.front(), time_s - options.packet_period_s);
    while (!votes.empty() && votes.front().time_s < oldest_s) votes.pop_front();
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

  std::optional<double> PredictFromVotes(double time_s) const {
    if (votes.empty()) return std::nullopt;  // the last position sent is too old to be used alone
    std::vector<TimedColumn> found;
    if (sent) found.push_back(*sent);
    found.insert(found.end(), votes.begin(), votes.end());
    const auto column = PredictByLine(found, time_s, options.inlier_columns);
    // A steep line may leave the profile.
    const bool on_line = column && *column >= 0.0 && *column <= options.line.columns - 1;
    return on_line ? column : std::nullopt;
  }

  // Section 3.4: two of three, then a line through a period's votes and the last position sent.
  void DecideByVoting(Reading& reading) {
    const auto vote = VoteTwoOfThree(reading.detected, ToColumns(kVoteTolerance_m));
    if (vote) votes.push_back({reading.time_s, *vote});
    reading.column = at_once = PredictFromVotes(reading.time_s);
    const auto measured = vote ? vote : reading.column;
    reading.step_m = measured ? StepAt(*measured) : HighestStep(reading);
    if (reading.column) {
      reading.status = ProfileStatus::kEdge;
    } else {
      const bool several = vote && votes.size() >= 2;
      reading.status = several ? ProfileStatus::kAmbiguous : ProfileStatus::kNoEdge;
    }
  }

  // Section 3.5: the maximum of the summed weights, which are higher near earlier edges. The
  // reading has the position with the highest weight of those detected in a packet period
  // (eq. 3.17, 3.21), as a reading of voting covers the last period, too.
  void DecideByWeights(Reading& reading) {
    weight = SumOfWeights(results);
    WeightByHistory(weight, history, options.history_sigma_columns);
    const auto highest = std::ranges::max_element(weight);
    const auto column = static_cast<double>(highest - weight.begin());
    reading.step_m = StepAt(column);
    if (reading.step_m >= kThinnestMat_m) {
      at_once = column;
      history.push_back(column);
      if (history.size() > kHistory) history.erase(history.begin());
      detected.push_back({{reading.time_s, column}, *highest});
    }
    reading.status = detected.empty() ? ProfileStatus::kNoEdge : ProfileStatus::kEdge;
    if (detected.empty()) return;
    const auto best = std::max_element(  // the latest of several
        detected.rbegin(), detected.rend(),
        [](const Weighted& a, const Weighted& b) { return a.weight < b.weight; });
    reading.goes_on = at_once.has_value();
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
    if (at_once && found.column && std::abs(*at_once - *found.column) <= ToColumns(kKeep_m)) {
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
    if (!prepared.Usable()) return;
    results = DetectWithin(prepared);
    for (std::size_t d = 0; d < kDetectors; ++d) reading.detected[d] = results[d].column;
    options.method == DecisionMethod::kVoting ? DecideByVoting(reading) : DecideByWeights(reading);
  }

  double ToColumns(double length_m) const { return length_m * options.line.columns_per_m; }

  // With weights the strongest position of a period is sent (eq. 3.17), else the latest.
  void Offer(const Reading& reading) {
    if (!at_once) return;
    const float its_weight = weight.empty() ? 0.0F : weight[static_cast<std::size_t>(*at_once)];
    if (candidate && its_weight < candidate_weight) return;
    candidate = {reading.time_s, *at_once, LateralAt(*at_once), reading.sure};
    candidate_weight = its_weight;
  }

  void EndPeriod(double time_s) {
    if (!period_begin_s) period_begin_s = time_s;
    if (time_s < *period_begin_s + options.packet_period_s - kTimeSlack_s) return;
    packet = candidate.value_or(EdgePacket{.time_s = time_s});
    if (candidate) {
      sent = {candidate->time_s, *candidate->column};
      packet->column = OfLine(*candidate->column);
    }
    candidate.reset();
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
  impl_ = std::make_unique<Impl>(WithWindowsOfLine(options), calibration);
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
  t.prepared = Prepare(mirrored, t.options.filter);
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
