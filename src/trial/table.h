#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiment/record.h"
#include "experiment/report.h"
#include "experiment/statistics.h"

namespace rangegrasp::trial {

/// Counts and rates of one object (or of all).
struct Row {
  std::string object;
  std::string title;
  int trials = 0;
  int detected = 0;
  int delivered = 0;
  std::map<std::string, int> outcomes;  ///< only those that occurred
  /// detected / trials; of the overall row: the mean of the rows.
  std::optional<double> detection_rate;
  std::optional<double> grasp_rate;  ///< delivered / detected; likewise
  std::optional<double> published_detection_rate;
  std::optional<double> published_grasp_rate;
  /// Of the published table, where it says how many trials a row has: its rates times these.
  std::optional<int> published_trials;
  int published_detected = 0;
  int published_delivered = 0;
  /// Fisher's exact test, one-sided: how likely so low a count is if the rate is the published one.
  std::optional<double> detection_p_below;
  std::optional<double> grasp_p_below;
};

/// A table as the dissertation prints it (e.g. 5.2), beside its published figures.
struct Table {
  std::vector<Row> rows;
  Row overall;  ///< rates: mean of the rows, as in the dissertation
  std::optional<double> pooled_detection_rate;
  std::optional<double> pooled_grasp_rate;
  std::vector<experiment::StageTime> stage_seconds;
  std::map<std::string, double> audit_max;  ///< largest figure over all executed trials
  /// Below this a row is significantly below its published one: 0.05 over the number of rows that
  /// are compared (Bonferroni). 0 where none is.
  double p_threshold = 0.0;
};

/// Whether a p-value of the row is below the table's threshold.
bool IsBelowPublished(const Table& table, const Row& row);

/// Stamp::data of a grasping run: "title.<object>", and the text of the published table (columns
/// object, name, detection_rate, grasping_rate in per cent, and, if rows are to be compared by
/// Fisher's test, trials; a row "overall").
using experiment::kTitlePrefix;
inline constexpr const char* kReference = "reference";

/// @throws base::InputError if the reference in the stamp is no published table.
Table BuildTable(const experiment::Stamp& stamp, const std::vector<experiment::Record>& records);

/// The same as it is printed.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

/// {"scan": {"median": s, "p95": s}, ...}
nlohmann::ordered_json JsonOf(const std::vector<experiment::StageTime>& times);

/// Width of a bin of the coefficient; a bin's number is its lower end over the width.
inline constexpr double kFrictionBin = 0.05;
/// By object, then by bin of its static friction: delivered of detected. Trials in which the target
/// was not detected are left out: the hand never touched it.
using FrictionCurve = std::map<std::string, std::map<int, experiment::Count>>;

FrictionCurve FrictionCurveOf(const std::vector<experiment::Record>& records);

/// Delivered of detected by bins, a row an object in the given order and one for all; without rows
/// if all trials are in one bin each (friction was not drawn).
experiment::Grid GridOf(const FrictionCurve& curve, const std::vector<std::string>& objects);

/// JSON array of {"object", "bins": [{"low", "high", "detected", "delivered"}]}.
nlohmann::ordered_json JsonOf(const FrictionCurve& curve, const std::vector<std::string>& objects);

/// The rates of the table by object, beside the published ones; then what they depend on: how the
/// object lies, the kind of grasp, friction, and how far the object slid and turned in the hand.
/// Without such figures in any record a chart is left out.
/// @throws base::InputError as BuildTable.
std::vector<experiment::Chart> ChartsOf(const experiment::Stamp& stamp,
                                        const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::trial
