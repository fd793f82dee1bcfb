#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "base/yaml_map.h"
#include "seam/calibration.h"
#include "seam/detectors.h"
#include "seam/profile.h"
#include "seam/step_track.h"

namespace rangegrasp::seam {

/// How the edge position in a profile is decided.
enum class DecisionMethod {
  kVoting,   ///< two of three, then a line through the last profiles (section 3.4)
  kWeights,  ///< sum of weights with historic edge positions, highest of a period (section 3.5)
  kSteps,    ///< our own: track-before-detect with the fourth detector (seam/step_track.h)
};
constexpr std::array<std::string_view, 3> WordsOf(DecisionMethod) {
  return {"voting", "weights", "steps"};
}

/// The thinnest mat (section 3.5.3): with kWeights, a lower step is no edge. Section 3.4 demands no
/// height of votes.
constexpr double kThinnestMat_m = 0.3e-3;

/// The keys in ReadTrackerOptions describe each option.
struct TrackerOptions {
  LineGeometry line;
  FilterOptions filter;
  DecisionMethod method = DecisionMethod::kSteps;  ///< misses the fewest edges (docs/seam.md)
  double packet_period_s = 0.1;
  /// > 0, of PredictByLine; half a millimetre with the base sensor. A larger value accepts fibres
  /// next to the edge, a smaller one rejects votes for a frayed edge.
  double inlier_columns = 6.0;
  /// > 0; sigma of the bell curve (eq. 3.18 does not specify it). A larger value holds an edge less
  /// firmly, a smaller one loses an edge that moves along the line while the head turns.
  double history_sigma_columns = 20.0;
  StepTrackOptions step_track;
  bool positive_edge = true;  ///< false: high at small columns; profiles are mirrored
};

/// Scales all windows above from columns of the base sensor (12 per mm) to the line's own. Those of
/// the three detectors and of the step height stay: the dissertation states them in px.
TrackerOptions WithWindowsOfLine(const TrackerOptions& options);

/// Reads the keys of TrackerOptions; absent keys keep their defaults. The caller must call Finish.
/// @throws base::InputError naming file, line and key.
void ReadTrackerOptions(base::YamlMap& map, TrackerOptions& options);

enum class ProfileStatus {
  kEdge,       ///< an edge position
  kNoEdge,     ///< no step of the minimum height, or too little evidence; kVoting: no vote
  kAmbiguous,  ///< kVoting: votes in several profiles of a period, whose line leaves the profile
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
  /// kSteps: step height at the place of the known edge, even if none is reported.
  double followed_step_m = 0.0;
  /// With kEdge: whether the last profiles confirm the step (kWeights: whether this profile has
  /// one). If false, the edge may have ended, and the reported values come from earlier profiles.
  bool goes_on = true;
  /// Whether each of the last profiles shows the edge beyond doubt. None: the method cannot tell.
  std::optional<bool> sure;
  /// Each detector's own position in this profile; with kSteps only that of the fourth.
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

/// Finds the edge in a sequence of profiles.
class EdgeTracker {
 public:
  /// @param calibration  none: columns have the same width at any height.
  /// @throws std::invalid_argument if the line has too few columns per mm for kSteps.
  explicit EdgeTracker(const TrackerOptions& options,
                       const std::optional<Calibration>& calibration = std::nullopt);
  ~EdgeTracker();
  EdgeTracker(EdgeTracker&&) noexcept;

  /// @throws base::InputError if the profile has another number of columns than the sensor, or its
  /// time is before that of the last one.
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
