#pragma once

#include <optional>
#include <string>
#include <vector>

#include "parts/benchmark.h"
#include "report/table.h"

namespace rangegrasp::report {

/// How far a segmentation is from those of people; lower is better in both.
enum class PartsMetric { kRandError, kCutDiscrepancy };

/// Mean of a metric over the models of every class, one number a method. Models that failed or
/// where the metric is undefined do not count; a class without any has no mean, and the overall
/// mean is that of the classes that have one.
struct PartsMeans {
  std::vector<std::string> classes;
  std::vector<parts::Method> methods;
  std::vector<std::vector<std::optional<double>>> by_class;  ///< [method][class]
  std::vector<std::optional<double>> overall;                ///< [method]
};
/// @param split  only its models; all where absent.
PartsMeans MeansOf(const parts::BenchmarkOptions& options,
                   const std::vector<parts::BenchmarkRow>& rows, PartsMetric metric,
                   std::optional<parts::Split> split);

/// The means as CSV: a line a class and method, then the overall ones (figures 6.19 to 6.22).
std::string PartsMeansCsv(const PartsMeans& means, PartsMetric metric);

/// The tables of a benchmark of parts: both metrics by class and overall for the models that
/// nothing was tuned on and for all, computation times beside published table 6.1, and what failed.
/// @throws core::InputError naming file and line if the published table cannot be read.
std::string FormatParts(const parts::BenchmarkOptions& options,
                        const std::vector<parts::BenchmarkRow>& rows, TableFormat format);

}  // namespace rangegrasp::report
