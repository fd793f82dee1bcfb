#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/yaml_map.h"
#include "seam/decision.h"
#include "seam/detectors.h"
#include "seam/preprocess.h"
#include "seam/profile.h"

namespace rangegrasp::seam {

/// How a profile's position is decided.
enum class DecisionMethod {
  kVoting,   ///< two of three, then a line through the last profiles (section 3.4)
  kWeights,  ///< sum of weights with historic edge positions (section 3.5)
  /// Our own: as kWeights, but the sums of earlier profiles fade out instead of being forgotten,
  /// and a candidate of local weighted-voting counts for the columns around it too.
  kAccumulated,
};

/// Of kAccumulated.
struct AccumulationOptions {
  double memory = 0.8;          ///< in [0, 1): share of the last sum that each profile keeps
  double spread_columns = 6.0;  ///< > 0: standard deviation of a candidate's position
};

struct TrackerOptions {
  LineGeometry line;
  PreprocessOptions preprocess;
  DetectorOptions detectors;
  DecisionMethod method = DecisionMethod::kVoting;
  double vote_tolerance_m = 1e-3;  ///< > 0
  double packet_period_s = 0.1;    ///< > 0; the robot asks for a position this often
  LinePredictionOptions line_prediction;
  HistoryOptions history;
  StepOptions step;
  AccumulationOptions accumulation;
  bool positive_edge = true;  ///< false: high at small columns; profiles are mirrored
};

enum class ProfileStatus {
  kEdge,       ///< a position
  kNoEdge,     ///< no step of the minimal height
  kAmbiguous,  ///< steps, but no two detectors agree and nothing can be predicted
  kUnusable,   ///< too few points
};
const char* Name(ProfileStatus status);  ///< "edge", "no_edge", "ambiguous", "unusable"

/// What one profile told.
struct Reading {
  double time_s = 0.0;
  ProfileStatus status = ProfileStatus::kUnusable;
  std::optional<double> column;  ///< with kEdge
  double x_m = 0.0;              ///< of the column, in the line's frame L
  double step_m = 0.0;           ///< step height where the edge was looked for
  std::array<std::optional<int>, kDetectors> detected;  ///< each detector's own position
};

/// What is sent to the robot control unit every packet_period_s.
struct EdgePacket {
  double time_s = 0.0;
  std::optional<double> column;  ///< none: no valid position in this period
  double x_m = 0.0;
};

/// Finds the edge in a sequence of profiles. Holds the history that prediction needs.
class EdgeTracker {
 public:
  /// @throws std::invalid_argument if an option is out of range.
  explicit EdgeTracker(const TrackerOptions& options);
  ~EdgeTracker();
  EdgeTracker(EdgeTracker&&) noexcept;

  /// Takes the next profile; times must not fall.
  /// @throws core::InputError if it has another number of columns than the sensor.
  Reading Update(const Profile& profile);
  /// The packet due since the last call, if a period has passed.
  std::optional<EdgePacket> TakePacket();
  /// The profile and detectors' results of the last Update, for pictures and monitors.
  const PreparedProfile& prepared() const;
  const std::array<DetectorResult, kDetectors>& results() const;
  /// W or W_h of the last Update (eq. 3.16, 3.20); empty with kVoting.
  const std::vector<float>& weight() const;
  /// Forgets the history (a new seam).
  void Reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// YAML: keys of TrackerOptions under `line`, `filter`, ... Values that are absent keep their
/// defaults. @throws core::InputError naming file, line and key.
TrackerOptions ReadTrackerOptions(const std::filesystem::path& file);
/// The same keys in a mapping of another file; leaves Finish to the caller.
void ReadTrackerOptions(core::YamlMap& map, TrackerOptions& options);

}  // namespace rangegrasp::seam
