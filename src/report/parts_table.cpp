#include "report/parts_table.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/error.h"
#include "report/grid.h"
#include "report/sections.h"

namespace rangegrasp::report {
namespace {

using parts::BenchmarkOptions;
using parts::BenchmarkRow;
using parts::Method;
using parts::Split;
using Rows = std::vector<BenchmarkRow>;

constexpr int kDigits = 4;

const char* NameInTable61(Method method) {
  switch (method) {
    case Method::kMirror:
      return "Proposed Method";
    case Method::kKMeans:
      return "K-Means";
    case Method::kSdf:
      return "SDF";
    case Method::kCore:
      return "Core Extraction";
    case Method::kImproved:
      break;
  }
  return "";
}

/// Table 6.1: method, seconds.
std::map<std::string, double> ReadRuntimes(const std::filesystem::path& file) {
  std::map<std::string, double> seconds;
  if (file.empty()) return seconds;
  for (const auto& [method, numbers] : ReadNamedNumbers(file)) {
    if (numbers.size() != 1 || !(numbers[0] >= 0.0)) {
      throw core::InputError(file.string() + ": the row of '" + method +
                             "' must be 'method,seconds'");
    }
    seconds[method] = numbers[0];
  }
  return seconds;
}

std::optional<double> Mean(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

std::optional<double> Value(const BenchmarkRow& row, PartsMetric metric) {
  if (row.failed) return std::nullopt;
  return metric == PartsMetric::kRandError ? std::optional(row.rand_error) : row.cut_discrepancy;
}

std::string Cell(const std::optional<double>& value) {
  return value ? Fixed(*value, kDigits) : "-";
}

Grid MeansGrid(const PartsMeans& means) {
  Grid grid{{"class"}, {true}, {}, true};
  for (const Method method : means.methods) {
    grid.header.emplace_back(Name(method));
    grid.left.push_back(false);
  }
  for (std::size_t c = 0; c <= means.classes.size(); ++c) {
    const bool total = c == means.classes.size();
    std::vector<std::string> row = {total ? "mean of the classes" : means.classes[c]};
    for (std::size_t m = 0; m < means.methods.size(); ++m) {
      row.push_back(Cell(total ? means.overall[m] : means.by_class[m][c]));
    }
    grid.rows.push_back(std::move(row));
  }
  return grid;
}

Section MetricSection(const BenchmarkOptions& options, const Rows& rows, PartsMetric metric,
                      std::optional<Split> split) {
  std::size_t models = 0;
  for (const auto& one : options.classes) {
    models += one.report.size() + (split ? 0 : one.tune.size());
  }
  const std::string of = std::to_string(models) + (split ? " models that nothing was tuned on"
                                                         : " models, those for tuning too");
  const bool rand = metric == PartsMetric::kRandError;
  return {(rand ? "1 - Rand index, lower is better, "
                : "Cut discrepancy, lower is better, where there are cuts, ") +
              of,
          MeansGrid(MeansOf(options, rows, metric, split))};
}

struct Times {
  std::vector<double> seconds;
  std::vector<double> parts;
  int uncut = 0;
  int failed = 0;
};

Times TimesOf(const Rows& rows, Method method) {
  Times times;
  for (const BenchmarkRow& row : rows) {
    if (row.method != method) continue;
    times.failed += row.failed ? 1 : 0;
    if (row.failed) continue;
    times.seconds.push_back(row.seconds);
    times.parts.push_back(row.parts);
    times.uncut += row.cut_discrepancy ? 0 : 1;
  }
  std::sort(times.seconds.begin(), times.seconds.end());
  return times;
}

Section TimesSection(const BenchmarkOptions& options, const Rows& rows) {
  const auto published = ReadRuntimes(options.runtimes);
  Section section{"Computation time of one core, all models; published: table 6.1",
                  {{"method", "models", "parts", "without a cut", "failed", "mean s", "median s",
                    "max s", "published mean s", "times faster"},
                   std::vector<bool>(10, false),
                   {},
                   false}};
  section.grid.left[0] = true;
  for (const Method method : options.methods) {
    const Times times = TimesOf(rows, method);
    const auto mean = Mean(times.seconds);
    const auto parts = Mean(times.parts);
    std::vector<std::string> row = {Name(method), std::to_string(times.seconds.size()),
                                    parts ? Fixed(*parts, 1) : "-", std::to_string(times.uncut),
                                    std::to_string(times.failed)};
    const auto known = published.find(NameInTable61(method));
    const std::size_t n = times.seconds.size();
    row.push_back(Cell(mean));
    row.push_back(n > 0 ? Fixed(times.seconds[n / 2], kDigits) : "-");
    row.push_back(n > 0 ? Fixed(times.seconds.back(), kDigits) : "-");
    const bool compare = known != published.end();
    row.push_back(compare ? Fixed(known->second, 1) : "-");
    row.push_back(compare && mean && *mean > 0.0 ? Fixed(known->second / *mean, 0) : "-");
    section.grid.rows.push_back(std::move(row));
  }
  return section;
}

Section FailuresSection(const Rows& rows) {
  Section section{"Failed",
                  {{"class", "model", "method", "why"}, {true, false, true, true}, {}, false}};
  for (const BenchmarkRow& row : rows) {
    if (!row.failed) continue;
    section.grid.rows.push_back(
        {row.class_name, std::to_string(row.id), Name(row.method), row.note});
  }
  return section;
}

std::vector<Section> SectionsOf(const BenchmarkOptions& options, const Rows& rows) {
  std::vector<Section> sections;
  const bool report = std::any_of(options.classes.begin(), options.classes.end(),
                                  [](const auto& one) { return !one.report.empty(); });
  const bool tune = std::any_of(options.classes.begin(), options.classes.end(),
                                [](const auto& one) { return !one.tune.empty(); });
  for (const auto metric : {PartsMetric::kRandError, PartsMetric::kCutDiscrepancy}) {
    if (report) sections.push_back(MetricSection(options, rows, metric, Split::kReport));
    if (tune) sections.push_back(MetricSection(options, rows, metric, std::nullopt));
  }
  sections.push_back(TimesSection(options, rows));
  Section failures = FailuresSection(rows);
  if (!failures.grid.rows.empty()) sections.push_back(std::move(failures));
  return sections;
}

}  // namespace

PartsMeans MeansOf(const BenchmarkOptions& options, const Rows& rows, PartsMetric metric,
                   std::optional<Split> split) {
  PartsMeans means;
  means.methods = options.methods;
  for (const auto& one : options.classes) means.classes.push_back(one.name);
  for (const Method method : options.methods) {
    auto& by_class = means.by_class.emplace_back();
    std::vector<double> classes;
    for (const std::string& name : means.classes) {
      std::vector<double> values;
      for (const BenchmarkRow& row : rows) {
        if (row.method != method || row.class_name != name || (split && row.split != *split)) {
          continue;
        }
        if (const auto value = Value(row, metric)) values.push_back(*value);
      }
      by_class.push_back(Mean(values));
      if (by_class.back()) classes.push_back(*by_class.back());
    }
    means.overall.push_back(Mean(classes));
  }
  return means;
}

std::string PartsMeansCsv(const PartsMeans& means, PartsMetric metric) {
  Grid grid{{"class", "method",
             metric == PartsMetric::kRandError ? "one_minus_rand_index" : "cut_discrepancy"},
            {true, true, false},
            {},
            false};
  for (std::size_t c = 0; c <= means.classes.size(); ++c) {
    const bool total = c == means.classes.size();
    for (std::size_t m = 0; m < means.methods.size(); ++m) {
      const auto& value = total ? means.overall[m] : means.by_class[m][c];
      grid.rows.push_back({total ? "overall" : means.classes[c], Name(means.methods[m]),
                           value ? Fixed(*value, 6) : ""});
    }
  }
  return CsvOf(grid);
}

std::string FormatParts(const BenchmarkOptions& options, const Rows& rows, TableFormat format) {
  return Format(SectionsOf(options, rows), Stamp(options.name, options.file), format);
}

}  // namespace rangegrasp::report
