#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiment/compare.h"
#include "experiment/record.h"
#include "experiment/report.h"
#include "experiment/stamp.h"

namespace rangegrasp::tasks::grasping {

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
};

/// A table as the dissertation prints it (e.g. 5.2), beside its published figures.
struct Table {
  std::vector<Row> rows;
  Row overall;  ///< rates: mean of the rows, as in the dissertation
  std::optional<double> pooled_detection_rate;
  std::optional<double> pooled_grasp_rate;
  std::vector<experiment::StageTime> stage_seconds;
  std::map<std::string, double> audit_max;  ///< largest figure over all executed trials
};

/// Stamp::data of a grasping run: "title.<object>", and the text of the published table (columns
/// object, name, detection_rate, grasping_rate in per cent; a row "overall").
inline constexpr const char* kTitlePrefix = "title.";
inline constexpr const char* kReference = "reference";

/// @throws core::InputError if the reference in the stamp is no published table.
Table BuildTable(const experiment::Stamp& stamp, const std::vector<experiment::Record>& records);

/// The same as it is printed.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::tasks::grasping
