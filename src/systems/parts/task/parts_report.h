#pragma once

#include <map>
#include <optional>
#include <string>

#include "experiment/report.h"
#include "experiment/statistics.h"
#include "experiment/task.h"
#include "parts/task/parts_setup.h"

namespace rangegrasp::parts {

/// Result of one method on one model, compared with all of its human segmentations.
struct PartsRow {
  std::string class_name;
  int id = 0;
  Split split = Split::kReport;
  Method method = Method::kMirror;
  std::optional<CloudGrade> cloud;  ///< sampled from the model and segmented in place of it
  int parts = 0;
  double rand_error = 0.0;                ///< mean over the human segmentations
  std::optional<double> cut_discrepancy;  ///< mean over those where it is defined
  double seconds = 0.0;                   ///< processor time of the method alone [s]
  std::string note;                       ///< error message, or the method's note
  bool failed = false;                    ///< if true, all numbers are 0
};
/// A case that ended without a result (crashed, timed out) becomes a failed row.
PartsRow RowOf(const experiment::Record& record);

/// Distance of a segmentation from those of people; lower is better for both metrics.
enum class Metric { kRandError, kCutDiscrepancy };
constexpr std::array<std::string_view, 2> WordsOf(Metric) {
  return {"rand_index", "cut_discrepancy"};
}

/// Means of a metric over models. Models that failed or for which it is undefined do not count.
/// Classes without other models do not count in the overall mean. Its standard error is sqrt(sum
/// SE_c^2) / classes, absent if a class has none.
struct MethodMeans {
  Method method;
  std::vector<experiment::Mean> by_class;  ///< in the order of the setup's classes
  experiment::Mean overall;                ///< mean of the classes' means
  experiment::Mean over_models;            ///< mean over all models of any class
};
/// One entry per method.
/// @param split  use only its models; all models if absent
std::vector<MethodMeans> MeansOf(const PartsSetup& setup, const std::vector<PartsRow>& rows,
                                 Metric metric, std::optional<Split> split);

/// Both metrics by class and overall, without the tuning models and for all models; computation
/// times next to published table 6.1; failures. Files: the rows, figures 6.19 to 6.22 as SVG.
experiment::Report PartsReport(const experiment::Stamp& stamp,
                               const std::vector<experiment::Record>& records);

/// Reads published table 6.1 from CSV text "method,average_s"; empty text gives no entries.
/// @throws base::InputError naming `name` and the line.
std::map<Method, double> PublishedSeconds(const std::string& csv, const std::string& name);

}  // namespace rangegrasp::parts
