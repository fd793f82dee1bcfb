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
  kOutage,  ///< the sensor sees nothing; over once it sees again
};
constexpr std::array<std::string_view, 3> WordsOf(StopReason) {
  return {"mat_end", "obstacle", "outage"};
}

/// The texts of the keys (ReadMonitorOptions) say what each is.
struct MonitorOptions {
  double obstacle_height_m = 3e-3;  ///< > 0 (dissertation, section 3.7)
  /// In (0, 1]: an obstacle on the low mat rises less above the surface between both, by half a
  /// mat, and its border slopes. Filaments and bundles are 1.4 mm at most.
  double obstacle_share = 0.7;
  /// > 0. An obstacle of twice this width shows a stretch of it for certain, since its borders
  /// slope. Lower for a sensor without outliers.
  double obstacle_width_m = 1e-3;
  int obstacle_profiles = 3;    ///< >= 1: fewer stop for outliers, more ask for a slower head
  double min_step_m = 0.18e-3;  ///< > 0: 0.6 of the thinnest mat's, as in the tracker
  /// >= 1: 80 % of the window, so that chance edges do not hide an end and gaps of a low edge do
  /// not make one.
  int mat_end_profiles = 24;
  int outage_profiles = 10;  ///< >= 1
  /// >= both; at 62 profiles a second and 30 mm/s it spans 15 of the 80 mm that the sensor is
  /// ahead.
  int window = 30;
};

/// Reads what stands below `monitor` in a file; what is absent keeps its default.
/// @throws base::InputError naming file, line and key.
void ReadMonitorOptions(base::YamlMap map, MonitorOptions& options);

/// How far each column rises above the surface of its line [m]: the parabola that most columns lie
/// within 1 mm of, so that neither an obstacle of a third of the line nor points that are no
/// surface bend it. Columns without a point: NaN.
std::vector<float> HeightAboveSurface(const PreparedProfile& profile);

/// Columns of a stretch of `width` columns that rises by at least `height` throughout; a sixth of
/// it may be missing (NaN): where more is, phantoms may make up the rest.
std::vector<bool> RisingColumns(std::span<const float> above, std::size_t width, double height);

/// Watches a line for the end of the mats and for obstacles. A line that is only watched (the
/// second of the three-lines sensor) has a tracker of its own.
class SurfaceMonitor {
 public:
  /// @throws std::invalid_argument if an option is out of range.
  SurfaceMonitor(const LineGeometry& line, const MonitorOptions& options);
  /// The reason to stop, if the profiles so far give one; it stays until Reset, but for an outage
  /// and for a mat end soon after which the edge is there beyond doubt (Reading::sure).
  std::optional<StopReason> Update(const PreparedProfile& profile, const Reading& reading);
  /// Whether most of the last usable profiles showed the edge.
  bool SeesEdge() const;

 private:
  bool SeesObstacle(const PreparedProfile& profile);

  std::size_t width_;  // columns of the narrowest obstacle
  double columns_per_m_;
  MonitorOptions options_;
  struct Seen {
    Eigen::Vector3d surface;   // a parabola over a line from -1 to 1; NaN: none
    double moved_m;            // by how much the line had moved along itself by then
    std::vector<bool> rising;  // columns
  };
  std::deque<Seen> seen_;  // of the last profiles, oldest first
  std::deque<bool> no_edge_;
  int ended_ = 0;     // usable profiles since the mat end was reported
  int unusable_ = 0;  // one after the other, up to now
  bool edge_seen_ = false;
  double usual_step_m_ = 0.0;  // of the edge
  std::optional<StopReason> stop_;
};

}  // namespace rangegrasp::seam
