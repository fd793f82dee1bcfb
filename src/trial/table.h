#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiment/record.h"
#include "experiment/report.h"
#include "experiment/statistics.h"

namespace rangegrasp::trial {

/// One rate of a row, next to the published one.
struct RowRate {
  experiment::Count count;     ///< of this run
  std::optional<double> rate;  ///< k / n; in the overall row the mean of the rows
  /// Wilson's of the counts; in the overall row that of the mean (experiment::MeanRateInterval).
  std::optional<std::pair<double, double>> interval;
  std::optional<double> published;
  experiment::Count published_count;  ///< zero where Row::published_trials is absent
  /// Fisher's exact test, one-sided: how likely so low a count is if the rate is the published one.
  std::optional<double> p_below;
};

/// Counts and rates of one object (or of all). The published figures stand next to the verdict of
/// the dissertation's text (TextVerdict), which they were counted by; the other two are stricter.
struct Row {
  std::string object;
  std::string title;
  RowRate detection;       ///< detected of trials
  RowRate grasping;        ///< delivered of detected
  RowRate text_detection;  ///< the same by the text's verdict
  RowRate text_grasping;
  std::map<std::string, int> outcomes;  ///< only those that occurred
  /// By outcome: how often each reason was given, without its figures.
  std::map<std::string, std::map<std::string, int>> reasons;
  /// Trials of the published row, where the published table states them: its counts are its rates
  /// times these.
  std::optional<int> published_trials;
};

/// A table as the dissertation prints it (e.g. 5.2), next to its published figures.
struct Table {
  std::vector<Row> rows;
  Row overall;                         ///< rates: mean of the rows, as in the dissertation
  std::map<std::string, int> redraws;  ///< of arrangements, by reason
  /// Of overall.outcomes["delivered"]: those that moved other objects, pushed one off the table,
  /// brought one along.
  int moved_others = 0, pushed_off = 0, brought_others = 0;
  std::vector<experiment::StageTime> stage_seconds;
  std::map<std::string, double> audit_max;  ///< largest figure over all executed trials
  /// A row with a lower p-value is significantly below the published one: 0.05 over the number of
  /// rows that are compared (Bonferroni). 0 where none is.
  double p_threshold = 0.0;
};

/// Whether a p-value of the row is below the table's threshold.
bool IsBelowPublished(const Table& table, const Row& row);

/// The stamp's data hold "title.<object>" and the published table (columns object, name,
/// detection_rate, grasping_rate in per cent and, if rows are to be compared by Fisher's test,
/// trials; a row "overall").
/// @throws base::InputError if the reference in the stamp is no published table.
Table BuildTable(const experiment::Stamp& stamp, const std::vector<experiment::Record>& records);

/// The same table as it is printed.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

/// {"scan": {"median": s, "p95": s}, ...}
nlohmann::ordered_json JsonOf(const std::vector<experiment::StageTime>& times);

/// Width of a bin of the coefficient; a bin's number is its lower end over the width.
inline constexpr double kFrictionBin = 0.05;
/// By bin of the static friction: delivered of detected.
using FrictionBins = std::map<int, experiment::Count>;
/// By object. Trials in which the target was not detected are left out: the hand never touched it.
using FrictionCurve = std::map<std::string, FrictionBins>;

FrictionCurve FrictionCurveOf(const std::vector<experiment::Record>& records);

/// A row for each object in the given order and one for all; without rows if the trials of each
/// object are in one bin (friction was not drawn).
experiment::Grid GridOf(const FrictionCurve& curve, const std::vector<std::string>& objects);

/// JSON array of {"object", "bins": [{"low", "high", "detected", "delivered"}]}.
nlohmann::ordered_json JsonOf(const FrictionCurve& curve, const std::vector<std::string>& objects);

/// The rates by object next to the published ones, then what they depend on: resting pose, kind of
/// grasp, friction, slip and tilt in the hand. A chart without figures is left out.
/// @throws base::InputError as BuildTable.
std::vector<experiment::Chart> ChartsOf(const experiment::Stamp& stamp,
                                        const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::trial
