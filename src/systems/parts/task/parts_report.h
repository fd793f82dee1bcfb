#pragma once

#include <map>
#include <optional>
#include <string>

#include "experiment/report.h"
#include "experiment/statistics.h"
#include "experiment/task.h"
#include "parts/task/parts_setup.h"

namespace rangegrasp::parts {

/// One method on one model, against all of its human segmentations.
struct PartsRow {
  std::string class_name;
  int id = 0;
  Split split = Split::kReport;
  Method method = Method::kMirror;
  std::optional<CloudGrade> cloud;  ///< of the model, in place of it
  int parts = 0;
  double rand_error = 0.0;                ///< mean over the humans
  std::optional<double> cut_discrepancy;  ///< mean over those where it is defined
  double seconds = 0.0;                   ///< processor time of the method alone [s]
  std::string note;                       ///< a failure's text, or the method's
  bool failed = false;                    ///< then all numbers are 0
};
/// The row of a case: what it is from its params, what it gave from its result. A case that ended
/// without a result (crashed, timed out) is a row that failed.
PartsRow RowOf(const experiment::Record& record);

/// How far a segmentation is from those of people; lower is better in both.
enum class Metric { kRandError, kCutDiscrepancy };
constexpr std::array<std::string_view, 2> WordsOf(Metric) {
  return {"rand_index", "cut_discrepancy"};
}

/// Mean of a metric over the models of every class, one number a method. Models that failed or
/// where the metric is undefined do not count; a class without any has no mean, and the overall
/// mean is that of the classes that have one. Its standard error is sqrt(sum SE_c^2) / classes,
/// absent where a class has none.
struct MetricMeans {
  std::vector<std::string> classes;
  std::vector<Method> methods;
  std::vector<std::vector<experiment::Mean>> by_class;  ///< [method][class]
  std::vector<experiment::Mean> overall;                ///< [method], mean of the classes
  std::vector<experiment::Mean> over_models;            ///< [method], whatever their class
};
/// @param split  only its models; all where absent.
MetricMeans MeansOf(const PartsSetup& setup, const std::vector<PartsRow>& rows, Metric metric,
                    std::optional<Split> split);

/// The means as CSV: a line a class and method, then the overall ones (figures 6.19 to 6.22).
/// Standard error and number of the overall lines are those over all models.
std::string MeansCsv(const MetricMeans& means, Metric metric);

/// The tables of an experiment with parts: both metrics with their standard errors, by class and
/// overall, for the models apart from those of tuning and for all; computation times next to
/// published table 6.1; what failed. Files: the rows, figures 6.19 to 6.22 as CSV and SVG.
experiment::Report PartsReport(const experiment::Stamp& stamp,
                               const std::vector<experiment::Record>& records);

/// Published table 6.1 from CSV text "method,seconds"; empty text has none.
/// @throws base::InputError naming `name` and the line.
std::map<Method, double> PublishedSeconds(const std::string& csv, const std::string& name);

}  // namespace rangegrasp::parts
