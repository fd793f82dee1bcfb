#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiment/record.h"
#include "experiment/report.h"
#include "experiment/statistics.h"

namespace rangegrasp::trial {

/// One rate of a row, with the published one.
struct RowRate {
  experiment::Count count;     ///< of this run
  std::optional<double> rate;  ///< k / n; in the overall row the mean of the rows
  /// Wilson interval of the counts; overall row: of the mean (experiment::MeanRateInterval).
  std::optional<std::pair<double, double>> interval;
  std::optional<double> published;
  /// The published rate times the trials of the published row; zero if it does not state them.
  experiment::Count published_count;
  /// One-sided p-value of Fisher's exact test: probability of a count this low or lower if the true
  /// rate is the published one.
  std::optional<double> p_below;
};

/// How often the same thing failed.
struct Reason {
  int count = 0;
  /// The first trial's reason with its numbers, up to a parenthesis that others do not share.
  std::string example;
};

/// Counts and rates of one object (or of all). The published rates are compared with the verdict by
/// the dissertation's text (TextVerdict), by which they were counted; the other two are stricter.
struct Row {
  std::string object;
  std::string title;
  RowRate detection;       ///< detected / trials
  RowRate grasping;        ///< delivered / detected
  RowRate text_detection;  ///< the same by the text's verdict
  RowRate text_grasping;
  std::map<std::string, int> outcomes;  ///< only those that occurred
  /// For each outcome: its reasons, by their text without numbers.
  std::map<std::string, std::map<std::string, Reason>> reasons;
};

/// A table in the dissertation's form (e.g. 5.2), with the published rates.
struct Table {
  std::vector<Row> rows;
  Row overall;                         ///< rates: mean of the rows, as in the dissertation
  std::map<std::string, int> redraws;  ///< redrawn arrangements, by reason
  /// Delivered trials that moved other objects, pushed one off the table, or brought one along.
  int moved_others = 0, pushed_off = 0, brought_others = 0;
  std::vector<experiment::StageTime> stage_seconds;
  std::map<std::string, double> audit_max;  ///< maximum of each value over all executed trials
  /// A row with a lower p-value is significantly below the published one. The threshold is 0.05
  /// divided by the number of compared rows (Bonferroni for each kind of rate, detection and
  /// grasping, without the overall row); 0 if no row is compared.
  double p_threshold = 0.0;
};

/// Whether a p-value of the row is below the table's threshold.
bool IsBelowPublished(const Table& table, const Row& row);

/// Builds the table. The stamp's data hold "title.<object>" and the published table: columns
/// object, name, detection_rate, grasping_rate in per cent and, for a comparison of the rows by
/// Fisher's test, trials; and a row "overall".
/// @throws base::InputError if the reference in the stamp is not a published table.
Table BuildTable(const experiment::Stamp& stamp, const std::vector<experiment::Record>& records);

/// The same table, ready to print.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

/// Charts of the rates of each object with the published ones, then of the rates by resting pose,
/// kind of grasp, friction, slip and tilt in the hand. Charts without data are left out.
/// @throws base::InputError like BuildTable.
std::vector<experiment::Chart> ChartsOf(const experiment::Stamp& stamp,
                                        const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::trial
