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
/// A case that ended without a result (crashed, timed out) is a row that failed.
PartsRow RowOf(const experiment::Record& record);

/// How far a segmentation is from those of people; lower is better in both.
enum class Metric { kRandError, kCutDiscrepancy };
constexpr std::array<std::string_view, 2> WordsOf(Metric) {
  return {"rand_index", "cut_discrepancy"};
}

/// Means of a metric over models. Models that failed or where it is undefined do not count, nor do
/// classes without any in the overall mean, whose standard error is sqrt(sum SE_c^2) / classes,
/// absent where a class has none.
struct MethodMeans {
  Method method;
  std::vector<experiment::Mean> by_class;  ///< in the order of the setup's classes
  experiment::Mean overall;                ///< of the classes' means
  experiment::Mean over_models;            ///< whatever their class
};
/// One a method.
/// @param split  only its models; all where absent.
std::vector<MethodMeans> MeansOf(const PartsSetup& setup, const std::vector<PartsRow>& rows,
                                 Metric metric, std::optional<Split> split);

/// The means as CSV: a line for each class and method, then the overall ones (figures 6.19-6.22),
/// whose standard error and number are those over all models.
std::string MeansCsv(const PartsSetup& setup, const std::vector<MethodMeans>& means, Metric metric);

/// Both metrics by class and overall, for the models apart from those of tuning and for all;
/// computation times next to published table 6.1; what failed. Files: the rows, figures 6.19 to
/// 6.22 as CSV and SVG.
experiment::Report PartsReport(const experiment::Stamp& stamp,
                               const std::vector<experiment::Record>& records);

/// Published table 6.1 from CSV text "method,seconds"; empty text has none.
/// @throws base::InputError naming `name` and the line.
std::map<Method, double> PublishedSeconds(const std::string& csv, const std::string& name);

}  // namespace rangegrasp::parts
