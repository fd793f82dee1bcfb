#include "seam/task/seam_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "base/units.h"
#include "seam/task/seam_pictures.h"

namespace rangegrasp::seam_task {
namespace {

using draw::Panel;
using draw::Series;
using experiment::View;

constexpr double kNoEdge = std::numeric_limits<double>::quiet_NaN();
// Pages of a view: so many from end to end, and so many that went most wrong. Their number is the
// view's size, 25 kB a page.
constexpr std::size_t kEvenPages = 8;
constexpr std::size_t kWorstPages = 8;
// The decision that pages tell of: unlike voting it has a weight function to look at.
constexpr auto kShown = static_cast<std::size_t>(seam::DecisionMethod::kWeights);
constexpr const char* kTruthColor = "#444444";
constexpr std::array<const char*, kDecisions.size()> kDecisionColors = {"#9467bd", "#e08000",
                                                                        "#8c564b", "#d62728"};
constexpr const char* kLocalStepColor = "#17becf";

const char* ColorOf(std::size_t method) {
  if (method >= kAlone) return kDecisionColors[method - kAlone];
  return method == kLocalStep ? kLocalStepColor : kDetectorColors[method];
}

double Value(const std::optional<double>& column) { return column.value_or(kNoEdge); }
double Value(const std::optional<int>& column) {
  return column ? static_cast<double>(*column) : kNoEdge;
}

// What all methods told of a seam's profiles.
struct Told {
  std::vector<double> along_mm, truth;                // [column]
  std::array<std::vector<double>, kMethods> columns;  // of each method
  std::vector<double> wrong;                          // of the shown decision; not found: most
};

Told Read(const SeamExperiment& experiment, const seam::Calibration& calibration,
          const stitching::Recording& recording) {
  Told told;
  told.truth = recording.label_column;
  for (const seam::RawProfile& raw : recording.raw) {
    told.along_mm.push_back((raw.time_s - recording.raw.front().time_s) *
                            experiment.record.speed_m_s * base::kMmPerM);
  }
  ReadSeam(experiment, calibration, recording,
           [&](std::size_t i, const auto& readings, const auto&) {
             for (std::size_t k = 0; k < seam::kDetectors; ++k) {
               told.columns[k].push_back(Value(readings.front().detected[k]));
             }
             for (std::size_t d = 0; d < readings.size(); ++d) {
               told.columns[kAlone + d].push_back(Value(readings[d].column));
               if (kDecisions[d] != seam::DecisionMethod::kSteps) continue;
               told.columns[kLocalStep].push_back(Value(readings[d].local_step));
             }
             const double error = std::abs(Value(readings[kShown].column) - told.truth[i]);
             const bool none = std::isnan(told.truth[i]) && !readings[kShown].column;
             told.wrong.push_back(none ? 0.0 : std::isnan(error) ? INFINITY : error);
           });
  return told;
}

Panel PathPanel(const SeamExperiment& experiment, const Told& told) {
  const auto line = [&](const std::string& name, const std::vector<double>& columns,
                        const char* color, bool dots) {
    Series series{name, told.along_mm, {}, color, dots};
    for (const double column : columns) {
      series.y.push_back(experiment.sensor.line.ToMeters(column) * base::kMmPerM);
    }
    return series;
  };
  Panel panel{"The edge along the seam: the truth and what was found",
              "along the seam [mm]",
              "across, on the line [mm]",
              {line("truth", told.truth, kTruthColor, false)},
              {},
              {}};
  for (std::size_t m = 0; m < kMethods; ++m) {
    panel.series.push_back(line(MethodTitle(m), told.columns[m], ColorOf(m), m < kAlone));
  }
  return panel;
}

Panel ErrorPanel(const SeamExperiment& experiment, const Told& told) {
  Panel panel{"How far each decision is off the truth", "along the seam [mm]", "[mm]", {}, {}, {}};
  for (std::size_t d = 0; d < kDecisions.size(); ++d) {
    Series series{TitleOf(kDecisions[d]), told.along_mm, {}, kDecisionColors[d]};
    for (std::size_t i = 0; i < told.truth.size(); ++i) {
      const double columns = told.columns[kAlone + d][i] - told.truth[i];
      series.y.push_back(columns / experiment.sensor.line.columns_per_m * base::kMmPerM);
    }
    panel.series.push_back(std::move(series));
  }
  return panel;
}

// Positions of the profiles that pages show.
std::set<std::size_t> Shown(const std::vector<double>& wrong) {
  std::vector<std::size_t> order(wrong.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return wrong[a] > wrong[b]; });
  order.resize(std::min(order.size(), kWorstPages));
  std::set<std::size_t> shown(order.begin(), order.end());
  const std::size_t even = std::min(kEvenPages, wrong.size());
  for (std::size_t i = 0; i < even; ++i) shown.insert(i * wrong.size() / even);
  return shown;
}

View::Page PageOf(const SeamExperiment& experiment, const Told& told, std::size_t i,
                  const seam::Reading& reading, const seam::EdgeTracker& tracker) {
  View::Page page;
  const double error_mm = (Value(reading.column) - told.truth[i]) /
                          experiment.sensor.line.columns_per_m * base::kMmPerM;
  page.name = fmt::format("profile {} of {}, {:.1f} mm along the seam: {}", i + 1,
                          told.truth.size(), told.along_mm[i], base::Word(reading.status));
  if (std::isfinite(error_mm)) page.name += fmt::format(", {:.2f} mm off the truth", error_mm);
  page.panels = ProfilePanels(tracker, reading, experiment.sensor.line);
  for (Panel& panel : page.panels) {
    if (std::isfinite(told.truth[i])) {
      panel.markers.insert(panel.markers.begin(), {told.truth[i], "truth", kTruthColor});
    }
  }
  return page;
}

}  // namespace

View SeamView(const SeamExperiment& experiment, const seam::Calibration& calibration,
              const stitching::Recording& recording) {
  const Told told = Read(experiment, calibration, recording);
  View view;
  view.panels = {PathPanel(experiment, told), ErrorPanel(experiment, told)};
  const auto shown = Shown(told.wrong);
  ReadSeam(experiment, calibration, recording,
           [&](std::size_t i, const auto& readings, const auto& trackers) {
             if (!shown.contains(i)) return;
             view.pages.push_back(PageOf(experiment, told, i, readings[kShown], trackers[kShown]));
           });
  return view;
}

View TrackView(const SeamExperiment& experiment, const TrackedRun& tracked) {
  View view;
  view.panels = TrackPanels(tracked.result, tracked.mats, experiment.track.wanted_distance_m);
  Panel told{"What each detector told, on the sensor's line",
             "time [s]",
             "across, on the line [mm]",
             {},
             {},
             {}};
  for (std::size_t k = 0; k < seam::kDetectors; ++k) {
    Series series{MethodTitle(k), {}, {}, kDetectorColors[k], true};
    for (const seam::Reading& reading : tracked.result.readings) {
      series.x.push_back(reading.time_s);
      series.y.push_back(experiment.sensor.line.ToMeters(Value(reading.detected[k])) *
                         base::kMmPerM);
    }
    told.series.push_back(std::move(series));
  }
  Series decided{"decided", {}, {}, kTruthColor};
  for (const seam::Reading& reading : tracked.result.readings) {
    decided.x.push_back(reading.time_s);
    decided.y.push_back(experiment.sensor.line.ToMeters(Value(reading.column)) * base::kMmPerM);
  }
  told.series.push_back(std::move(decided));
  view.panels.push_back(std::move(told));
  return view;
}

}  // namespace rangegrasp::seam_task
