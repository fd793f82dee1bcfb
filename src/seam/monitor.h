#pragma once

#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "seam/preprocess.h"
#include "seam/tracker.h"

namespace rangegrasp::seam {

/// Why the head must stop.
enum class StopReason { kMatEnd, kObstacle };
const char* Name(StopReason reason);  ///< "mat_end", "obstacle"

struct MonitorOptions {
  double obstacle_height_m = 3e-3;  ///< > 0 (dissertation, section 3.7): rises above the surface
  double obstacle_width_m = 1e-3;   ///< > 0; narrower ones are filaments
  int obstacle_profiles = 3;        ///< >= 1 of the last `window` must show it in one place
  double min_step_m = 0.3e-3;       ///< > 0; a lower step is no edge
  int mat_end_profiles = 24;  ///< >= 1 of the last `window` without an edge of the minimal step
  int window = 30;            ///< >= both; the sensor looks 80 mm ahead, so that there is time
};

/// What rises above the mats.
struct Protrusion {
  double height_m = 0.0;  ///< 0: nothing does
  double column = 0.0;    ///< its middle
};
/// The highest of what is wider than `width_m`, on the original heights against a parabola that
/// ignores what rises more than 1 mm (a trimmed fit); up to half of its columns may be missing.
Protrusion FindProtrusion(const PreparedProfile& profile, const LineGeometry& line, double width_m);

/// The same for what rises above an earlier profile of the same line.
Protrusion FindRise(const PreparedProfile& before, const PreparedProfile& now,
                    const LineGeometry& line, double width_m);

/// Watches a line for the end of the mats and for obstacles. A line that is only watched (the
/// second of the three-lines sensor) has a tracker of its own.
class SurfaceMonitor {
 public:
  /// @throws std::invalid_argument if an option is out of range.
  SurfaceMonitor(const LineGeometry& line, const MonitorOptions& options);
  /// The reason to stop, if the profiles so far give one; it stays until Reset.
  std::optional<StopReason> Update(const PreparedProfile& profile, const Reading& reading);
  void Reset();

 private:
  Protrusion HighestProtrusion(const PreparedProfile& profile);

  LineGeometry line_;
  MonitorOptions options_;
  std::deque<PreparedProfile> before_;    // of the window
  std::vector<double> obstacle_columns_;  // of the last profiles; NaN: none
  std::vector<bool> no_edge_;
  bool edge_seen_ = false;
  std::optional<StopReason> stop_;
};

}  // namespace rangegrasp::seam
