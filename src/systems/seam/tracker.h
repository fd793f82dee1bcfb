#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "base/yaml_map.h"
#include "seam/calibration.h"
#include "seam/decision.h"
#include "seam/detectors.h"
#include "seam/profile.h"
#include "seam/step_track.h"

namespace rangegrasp::seam {

/// How the edge position in a profile is decided.
enum class DecisionMethod {
  kVotingAsPublished,  ///< two of three, then a line through the last profiles (section 3.4)
  /// Sum of weights with historic edge positions, the highest of a period (section 3.5).
  kWeightsAsPublished,
  kVoting,   ///< voting with our own rules (listed at the key `method`)
  kWeights,  ///< weights with our own rules
  /// Our own: like kWeights, but the sums of earlier profiles decay instead of being forgotten, and
  /// a candidate of local weighted-voting also counts for the columns around it.
  kAccumulated,
  kSteps,  ///< our own: track-before-detect with the fourth detector (seam/step_track.h)
};
constexpr std::array<std::string_view, 6> WordsOf(DecisionMethod) {
  return {
      "voting_as_published", "weights_as_published", "voting", "weights", "accumulated", "steps"};
}

/// Whether a method is as published, without our own rules.
constexpr bool IsAsPublished(DecisionMethod method) {
  return method == DecisionMethod::kVotingAsPublished ||
         method == DecisionMethod::kWeightsAsPublished;
}

/// Options of kAccumulated.
struct AccumulationOptions {
  double memory = 0.8;  ///< share of the sum of weights that is kept from profile to profile
  double spread_columns = 6.0;
};

/// The keys in ReadTrackerOptions describe each option.
struct TrackerOptions {
  LineGeometry line;
  /// Margin at both ends, because the windows of the geometric filter (+-12) and of the step height
  /// (+-10 of medians of +-6) are truncated at the ends of the measured part.
  int border_columns = 20;
  PreprocessOptions preprocess;
  DetectorOptions detectors;
  DecisionMethod method = DecisionMethod::kVoting;
  double vote_tolerance_m = 1e-3;
  double packet_period_s = 0.1;
  double refine_m = 2e-3;  ///< 0: as published
  double keep_m = 0.5e-3;  ///< a decision this close to the best fit is more precise than the fit
  /// false: a step counts at once, as published and as needed for a single profile. kSteps instead
  /// requires more evidence of a single profile.
  bool confirm = true;
  LinePredictionOptions line_prediction;
  HistoryOptions history;
  StepOptions step;
  AccumulationOptions accumulation;
  StepTrackOptions step_track;
  bool positive_edge = true;  ///< false: high at small columns; profiles are mirrored
};

/// Scales all windows above, which are in columns of the base sensor (12 per mm), to the same
/// lengths in the line's own columns. Methods as published keep the windows of the detectors and of
/// the step height, because the dissertation states them in px, for both sensors.
TrackerOptions WithWindowsOfLine(const TrackerOptions& options);

/// Reads the keys of TrackerOptions; absent keys keep their defaults. The caller must call Finish.
/// @throws base::InputError naming file, line and key.
void ReadTrackerOptions(base::YamlMap& map, TrackerOptions& options);

enum class ProfileStatus {
  kEdge,       ///< an edge position
  kNoEdge,     ///< no step of the minimum height, or none that counts; voting as published: no vote
  kAmbiguous,  ///< kVoting: steps in several profiles of a period, but not along one line
  kUnusable,   ///< too few points
};
constexpr std::array<std::string_view, 4> WordsOf(ProfileStatus) {
  return {"edge", "no_edge", "ambiguous", "unusable"};
}

struct Reading {
  double time_s = 0.0;
  ProfileStatus status = ProfileStatus::kUnusable;
  std::optional<double> column;  ///< with kEdge
  double x_m = 0.0;              ///< of the edge, in the line's frame L
  double step_m = 0.0;           ///< step height where the edge was looked for
  /// Step height at the place to which the edge was followed, even if no detector sees it.
  double followed_step_m = 0.0;
  /// With kEdge: whether the last profiles confirm the step (weights as published: whether this
  /// profile has one). If false, the edge may have ended, and the reported values come from earlier
  /// profiles.
  bool goes_on = true;
  /// Whether each of the last profiles shows the edge beyond doubt. If not, the reported edge may
  /// be the rest of one that has ended. None: the method cannot tell.
  std::optional<bool> sure;
  /// Each detector's own position in this profile; with method steps only that of the fourth.
  std::array<std::optional<int>, kDetectors> detected;
  std::optional<int> local_step;
};

/// Packet sent to the robot control unit every packet_period_s.
struct EdgePacket {
  double time_s = 0.0;
  std::optional<double> column = {};  ///< none: no valid position in this period
  double x_m = 0.0;
  std::optional<bool> sure = {};  ///< Reading::sure
};

/// Finds the edge in a sequence of profiles. Keeps the history needed for prediction.
class EdgeTracker {
 public:
  /// @param calibration  gives x of an edge from its column and the height of the surface there;
  /// none: columns have the same width at any height.
  /// @throws std::invalid_argument if the line has too few columns per mm for kSteps.
  explicit EdgeTracker(const TrackerOptions& options,
                       const std::optional<Calibration>& calibration = std::nullopt);
  ~EdgeTracker();
  EdgeTracker(EdgeTracker&&) noexcept;

  /// Takes the next profile.
  /// @throws base::InputError if it has another number of columns than the sensor, or its time is
  /// before that of the last one.
  Reading Update(const Profile& profile);
  /// The packet due since the last call, if a period has passed.
  std::optional<EdgePacket> TakePacket();
  /// Of the last Update, for plots and monitors. results() is empty with method steps.
  const PreparedProfile& prepared() const;
  const std::array<DetectorResult, kDetectors>& results() const;
  /// W or W_h of the last Update (eq. 3.16, 3.20); empty with kVoting and kSteps.
  const std::vector<float>& weight() const;
  /// Whether these three count columns from the other end of the line: the edge falls.
  bool mirrored() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::seam
