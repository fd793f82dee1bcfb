#pragma once

#include <Eigen/Core>
#include <array>
#include <deque>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/yaml_map.h"
#include "seam/profile.h"
#include "seam/tracker.h"

namespace rangegrasp::seam {

/// Why the head must stop.
enum class StopReason {
  kMatEnd,
  kObstacle,
  kOutage,  ///< the sensor sees nothing; ends when it sees again
};
constexpr std::array<std::string_view, 3> WordsOf(StopReason) {
  return {"mat_end", "obstacle", "outage"};
}

/// The keys in ReadMonitorOptions describe each option.
struct MonitorOptions {
  double obstacle_height_m = 3e-3;  ///< > 0 (dissertation, section 3.7)
  /// In (0, 1]. The surface fit lies between both mats, so an obstacle on the low mat rises half a
  /// mat less above it; its border also slopes. Filaments and bundles are at most 1.4 mm high.
  double obstacle_share = 0.7;
  /// > 0. An obstacle of twice this width is certain to be seen over this width, because its
  /// borders slope. Lower this for a sensor without outliers.
  double obstacle_width_m = 1e-3;
  int obstacle_profiles = 3;    ///< >= 1: fewer cause stops at outliers, more need a slower head
  double min_step_m = 0.18e-3;  ///< > 0: 0.6 of the thinnest mat
  /// In [0, 1]. A step below this share of the edge's usual height is no longer the edge: the fit
  /// of a double or frayed edge gives at least half of its height.
  double usual_share = 0.4;
  /// >= 1; 80 % of the window, so that random edges do not hide a mat end and gaps in a low edge do
  /// not look like one.
  int mat_end_profiles = 24;
  int outage_profiles = 10;  ///< >= 1
  /// >= obstacle_profiles and mat_end_profiles. At 62 profiles per second and 30 mm/s it spans 15
  /// mm of the 80 mm by which the sensor is ahead.
  int window = 30;
};

/// Reads the keys below `monitor` in a file; absent keys keep their defaults.
/// @throws base::InputError naming file, line and key.
void ReadMonitorOptions(base::YamlMap map, MonitorOptions& options);

/// As published, mats end where there is "no possible edge with a minimum size of 0.3mm" (section
/// 3.7). The counts of profiles and the test for obstacles are ours with every method.
MonitorOptions MonitorFor(MonitorOptions options, DecisionMethod method);

/// Height of each column above the surface [m]; NaN for columns without a point. The surface is the
/// parabola with the most columns within 1 mm, so that neither an obstacle on a third of the line
/// nor points off the surface bend it.
std::vector<float> HeightAboveSurface(const PreparedProfile& profile);

/// Marks the columns of each run of `width` columns that rises by at least `height` everywhere. A
/// sixth of a run may be missing (NaN); if more is missing, the rest may be phantoms.
std::vector<bool> RisingColumns(std::span<const float> above, std::size_t width, double height);

/// Monitors a line for the end of the mats and for obstacles.
class SurfaceMonitor {
 public:
  SurfaceMonitor(const LineGeometry& line, const MonitorOptions& options);
  /// The reason to stop, if any. It persists, except for an outage, and for a mat end if the edge
  /// is soon seen beyond doubt again (Reading::sure).
  std::optional<StopReason> Update(const PreparedProfile& profile, const Reading& reading);
  /// True if most of the last usable profiles showed the edge.
  bool SeesEdge() const;

 private:
  bool SeesObstacle(const PreparedProfile& profile);

  std::size_t width_;  // columns of the narrowest obstacle
  double columns_per_m_;
  MonitorOptions options_;
  struct Seen {
    Eigen::Vector3d surface;   // a parabola, the line mapped to [-1, 1]; NaN: none
    double moved_m;            // lateral motion of the line up to then
    std::vector<bool> rising;  // per column
  };
  std::deque<Seen> seen_;  // of the last profiles, oldest first
  std::deque<bool> no_edge_;
  int ended_ = 0;     // usable profiles since the mat end was reported
  int unusable_ = 0;  // consecutive unusable profiles
  bool edge_seen_ = false;
  double usual_step_m_ = 0.0;  // mean step height of the edge
  std::optional<StopReason> stop_;
};

}  // namespace rangegrasp::seam
