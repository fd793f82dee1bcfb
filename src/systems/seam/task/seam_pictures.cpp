#include "seam/task/seam_pictures.h"

#include <fmt/format.h>

#include <cmath>

#include "base/units.h"
#include "base/words.h"

namespace rangegrasp::seam_task {
namespace {

using draw::Panel;
using draw::Series;

Series ColumnSeries(const std::vector<float>& values, double unit, const std::string& label,
                    const std::string& color) {
  Series series{label, {}, {}, color};
  for (std::size_t i = 0; i < values.size(); ++i) {
    series.x.push_back(static_cast<double>(i));
    series.y.push_back(static_cast<double>(values[i]) * unit);
  }
  return series;
}

}  // namespace

std::vector<Panel> ProfilePanels(const seam::EdgeTracker& tracker, const seam::Reading& reading,
                                 const seam::LineGeometry& line) {
  const auto& prepared = tracker.prepared();
  Panel measured{"Profile as measured", "", "height [mm]", {}, {}, {}};
  measured.series.push_back(ColumnSeries(prepared.original_m, base::kMmPerM, "", "#444444"));
  Panel flat{
      fmt::format("Prepared: {}", base::Word(reading.status)), "", "height [mm]", {}, {}, {}};
  flat.series.push_back(ColumnSeries(prepared.height_m, base::kMmPerM, "", "#444444"));
  if (reading.column) flat.markers.push_back({*reading.column, "edge", "#d62728"});
  Panel weights{"Weight functions and positions of the three detectors",
                fmt::format("column ({} a mm)", std::lround(line.columns_per_m / base::kMmPerM)),
                "weight",
                {},
                {},
                {}};
  for (std::size_t d = 0; d < seam::kDetectors; ++d) {
    const std::string name(base::Word(static_cast<seam::Detector>(d)));
    weights.series.push_back(
        ColumnSeries(tracker.results()[d].weight, 1.0, name, kDetectorColors[d]));
    if (reading.detected[d]) {
      weights.markers.push_back(
          {static_cast<double>(*reading.detected[d]), "", kDetectorColors[d]});
    }
  }
  if (!tracker.weight().empty()) {
    weights.series.push_back(
        ColumnSeries(tracker.weight(), 1.0, "sum, weighted by history", "#7f7f7f"));
  }
  return {measured, flat, weights};
}

std::vector<Panel> TrackPanels(const stitching::TrackResult& track, const stitching::Mats& mats,
                               double wanted_distance_m) {
  Panel map{"Closed loop, seen from above", "along the track [mm]", "across [mm]", {}, {}, {}};
  map.equal_axes = true;
  Series edge{"edge", {}, {}, "#444444"};
  Series needle{"needle", {}, {}, "#d62728", false, 1.8};
  Series sensed{"positions sent", {}, {}, "#1f77b4", true};
  Panel errors{
      "Error of the distance between seam and edge", "along the track [mm]", "[mm]", {}, {}, {}};
  Series error{"", {}, {}, "#d62728"};
  for (const auto& point : track.path) {
    needle.x.push_back(point.y_m * base::kMmPerM);
    needle.y.push_back(-point.x_m * base::kMmPerM);
    error.x.push_back(point.y_m * base::kMmPerM);
    error.y.push_back((point.distance_m - wanted_distance_m) * base::kMmPerM);
    edge.x.push_back(point.y_m * base::kMmPerM);
    edge.y.push_back(-mats.EdgeX(point.y_m) * base::kMmPerM);
  }
  for (const auto& point : track.sensed) {
    sensed.x.push_back(point.y_m * base::kMmPerM);
    sensed.y.push_back(-point.x_m * base::kMmPerM);
  }
  // The line runs ahead of the needle: what it tells of the last stretch has its truth, too.
  constexpr double kStep_m = 1e-3;
  const double end_m = track.sensed.empty() ? 0.0 : track.sensed.back().y_m;
  for (double y_m = track.path.back().y_m; y_m < end_m; y_m += kStep_m) {
    edge.x.push_back(y_m * base::kMmPerM);
    edge.y.push_back(-mats.EdgeX(y_m) * base::kMmPerM);
  }
  map.series = {edge, sensed, needle};
  errors.series = {error};
  return {map, errors};
}

}  // namespace rangegrasp::seam_task
