#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "seam/calibration.h"
#include "seam/detectors.h"
#include "seam/preprocess.h"
#include "seam/profile.h"
#include "seam/tracker_options.h"

namespace rangegrasp::seam {

enum class ProfileStatus {
  kEdge,       ///< a position
  kNoEdge,     ///< no step of the minimal height
  kAmbiguous,  ///< steps, but no two detectors agree and nothing can be predicted
  kUnusable,   ///< too few points
};
constexpr std::array<std::string_view, 4> WordsOf(ProfileStatus) {
  return {"edge", "no_edge", "ambiguous", "unusable"};
}

/// What one profile told.
struct Reading {
  double time_s = 0.0;
  ProfileStatus status = ProfileStatus::kUnusable;
  std::optional<double> column;  ///< with kEdge
  double x_m = 0.0;              ///< of the edge, in the line's frame L
  double step_m = 0.0;           ///< step height where the edge was looked for
  /// Step height where the edge has been followed to: it may be there although no detector sees it.
  double followed_step_m = 0.0;
  /// With kEdge: whether the last profiles bear the step out; false: the edge may have ended, and
  /// what is told of it rests on profiles before.
  bool goes_on = true;
  /// Whether each of the last profiles left no doubt of the edge; what is told without may be what
  /// is left of one that has ended. None: the method cannot tell.
  std::optional<bool> sure;
  /// Each detector's own position in this profile; with method steps that of the fourth alone.
  std::array<std::optional<int>, kDetectors> detected;
  std::optional<int> local_step;
};

/// What is sent to the robot control unit every packet_period_s.
struct EdgePacket {
  double time_s = 0.0;
  std::optional<double> column;  ///< none: no valid position in this period
  double x_m = 0.0;
  std::optional<bool> sure;  ///< Reading::sure
};

/// Finds the edge in a sequence of profiles. Holds the history that prediction needs.
class EdgeTracker {
 public:
  /// @param calibration  tells x of an edge by its column and the height of the surface there;
  /// none:
  ///                     the line's columns are as wide at any height.
  /// @throws std::invalid_argument if an option is out of range.
  explicit EdgeTracker(const TrackerOptions& options,
                       const std::optional<Calibration>& calibration = std::nullopt);
  ~EdgeTracker();
  EdgeTracker(EdgeTracker&&) noexcept;

  /// Takes the next profile; times must not fall.
  /// @throws base::InputError if it has another number of columns than the sensor.
  Reading Update(const Profile& profile);
  /// The packet due since the last call, if a period has passed.
  std::optional<EdgePacket> TakePacket();
  /// The profile and detectors' results of the last Update, for pictures and monitors. Results are
  /// empty with method steps, which runs none of the three.
  const PreparedProfile& prepared() const;
  const std::array<DetectorResult, kDetectors>& results() const;
  /// W or W_h of the last Update (eq. 3.16, 3.20); empty with kVoting and kSteps.
  const std::vector<float>& weight() const;
  /// Forgets the history (a new seam).
  void Reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::seam
