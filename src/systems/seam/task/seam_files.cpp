#include "seam/task/seam_files.h"

#include <fmt/format.h>

#include <cmath>

#include "base/units.h"

namespace rangegrasp::seam_task {

std::string LabelsCsv(const stitching::Recording& recording) {
  std::string text = "profile,column\n";
  for (std::size_t i = 0; i < recording.label_column.size(); ++i) {
    const double label = recording.label_column[i];
    text += fmt::format("{},{}\n", i + 1, std::isfinite(label) ? fmt::format("{:.2f}", label) : "");
  }
  return text;
}

std::string PathCsv(const stitching::TrackResult& track) {
  std::string text = "time_s,x_mm,y_mm,heading_deg,distance_mm\n";
  for (const stitching::TrackPoint& p : track.path) {
    text += fmt::format("{:.3f},{:.4f},{:.4f},{:.4f},{:.4f}\n", p.time_s, p.x_m * base::kMmPerM,
                        p.y_m * base::kMmPerM, base::ToDeg(p.heading_rad),
                        p.distance_m * base::kMmPerM);
  }
  return text;
}

std::string PacketsXml(const stitching::TrackResult& track) {
  std::string text;
  for (const std::string& packet : track.packets) text += packet;
  return text;
}

}  // namespace rangegrasp::seam_task
