#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiment/result.h"
#include "experiment/store.h"

namespace rangegrasp::report {

/// Counts and rates of one object (or of all).
struct Row {
  std::string object;
  std::string title;
  int trials = 0;
  int detected = 0;
  int delivered = 0;
  std::map<std::string, int> outcomes;  ///< only those that occurred
  std::optional<double>
      detection_rate;  ///< detected / trials; of the overall row: the mean of the rows
  std::optional<double> grasp_rate;  ///< delivered / detected; likewise
  std::optional<double> published_detection_rate;
  std::optional<double> published_grasp_rate;
};

struct StageTime {
  std::string stage;
  double median_s = 0.0;
  double p95_s = 0.0;
};

/// A table as the dissertation prints it (e.g. 5.2), beside its published figures.
struct Table {
  std::map<std::string, std::string> stamp;
  std::vector<Row> rows;
  Row overall;  ///< rates: mean of the rows, as in the dissertation
  std::optional<double> pooled_detection_rate;
  std::optional<double> pooled_grasp_rate;
  std::vector<StageTime> stage_seconds;
  std::map<std::string, double> audit_worst;  ///< largest figure over all executed trials
};

/// Builds the table of a store. @throws core::InputError if the reference in the stamp is no
/// published table.
Table BuildTable(const experiment::Store& store);
Table BuildTable(const std::map<std::string, std::string>& stamp,
                 const std::vector<experiment::TrialResult>& results);

enum class TableFormat { kText, kMarkdown, kCsv, kJson };
std::string Format(const Table& table, TableFormat format);

/// Trials of the same id in two runs, compared pairwise: how many only one of them delivered, and
/// McNemar's exact p.
struct Comparison {
  int pairs = 0;
  int both = 0;
  int only_first = 0;
  int only_second = 0;
  int same_outcome = 0;
  double p_value = 1.0;
};
Comparison Compare(const std::vector<experiment::TrialResult>& first,
                   const std::vector<experiment::TrialResult>& second);

}  // namespace rangegrasp::report
