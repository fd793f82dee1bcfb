#include "parts/task/parts_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/draw/plot.h"
#include "base/error.h"
#include "base/file.h"
#include "base/statistics.h"

namespace rangegrasp::parts {
namespace {

using experiment::Fixed;
using experiment::Mean;
using experiment::MeanOf;
using experiment::Section;
using nlohmann::json;
using Rows = std::vector<PartsRow>;

constexpr int kDigits = 4;  ///< of metrics and seconds: as the chapter's figures can be read

/// What table 6.1 calls a method; empty where it does not have it.
constexpr std::array<std::string_view, 5> kNamesInTable61 = {"Proposed Method", "", "K-Means",
                                                             "SDF", "Core Extraction"};

/// Of the classes that have a mean, each as much as the others.
Mean MeanOfClasses(const std::vector<Mean>& classes) {
  std::vector<double> means;
  std::optional<double> variance = 0.0;
  for (const Mean& one : classes) {
    if (!one.mean) continue;
    means.push_back(*one.mean);
    if (!one.standard_error) variance.reset();
    if (variance) *variance += *one.standard_error * *one.standard_error;
  }
  Mean mean = MeanOf(means);
  mean.standard_error.reset();
  if (variance && !means.empty()) {
    mean.standard_error = std::sqrt(*variance) / static_cast<double>(means.size());
  }
  return mean;
}

template <class Enum>
std::string WordOf(Enum value) {
  return std::string(base::Word(value));
}

std::string CellOf(const std::optional<double>& value) {
  return value ? Fixed(*value, kDigits) : "-";
}

/// "0.1107 +- 0.0190"; without the error where there is none.
std::string CellOf(const Mean& mean, int digits = kDigits) {
  if (!mean.mean) return "-";
  std::string cell = Fixed(*mean.mean, digits);
  if (mean.standard_error) cell += " +- " + Fixed(*mean.standard_error, digits);
  return cell;
}

/// A table without rows yet, whose first column is one of words.
Section TableOf(const std::string& title, const std::vector<std::string>& header) {
  std::vector<bool> left(header.size(), false);
  left[0] = true;
  return {title, {header, left, {}, false}};
}

/// "20 models apart from those of tuning".
std::string ModelsText(const PartsSetup& setup, std::optional<Split> split) {
  std::size_t models = 0;
  for (const ModelClass& one : setup.classes) {
    models += one.report.size() + (split ? 0 : one.tune.size());
  }
  return fmt::format("{} models{}", models,
                     split ? " apart from those of tuning" : ", those for tuning too");
}

Section SummarySection(const PartsSetup& setup, const Rows& rows, std::optional<Split> split) {
  Section section = TableOf(
      "Mean over models and its standard error, lower is better, " + ModelsText(setup, split),
      {"method", "models", "1 - Rand index", "SE (Rand)", "models with cuts", "cut discrepancy",
       "SE (cut)"});
  const MetricMeans rand = MeansOf(setup, rows, Metric::kRandError, split);
  const MetricMeans cut = MeansOf(setup, rows, Metric::kCutDiscrepancy, split);
  for (std::size_t m = 0; m < setup.methods.size(); ++m) {
    std::vector<std::string>& row = section.grid.rows.emplace_back();
    row.push_back(WordOf(setup.methods[m]));
    for (const Mean* mean : {&rand.over_models[m], &cut.over_models[m]}) {
      row.push_back(std::to_string(mean->count));
      row.push_back(CellOf(mean->mean));
      row.push_back(CellOf(mean->standard_error));
    }
  }
  return section;
}

Section MetricSection(const PartsSetup& setup, const Rows& rows, Metric metric,
                      std::optional<Split> split) {
  std::vector<std::string> header = {"class"};
  for (const Method method : setup.methods) header.push_back(WordOf(method));
  Section section = TableOf(
      (metric == Metric::kRandError
           ? "1 - Rand index, mean and standard error, lower is better, "
           : "Cut discrepancy, mean and standard error, lower is better, where there are cuts, ") +
          ModelsText(setup, split),
      header);
  section.grid.total = true;
  const MetricMeans means = MeansOf(setup, rows, metric, split);
  for (std::size_t c = 0; c <= means.classes.size(); ++c) {
    const bool total = c == means.classes.size();
    std::vector<std::string>& row = section.grid.rows.emplace_back();
    row.push_back(total ? "mean of the classes" : means.classes[c]);
    for (std::size_t m = 0; m < means.methods.size(); ++m) {
      row.push_back(CellOf(total ? means.overall[m] : means.by_class[m][c]));
    }
  }
  return section;
}

/// What some rows gave.
struct Totals {
  std::vector<double> rand_errors, parts, seconds;
  int uncut = 0, failed = 0;
};

template <class IsWanted>
Totals TotalsOf(const Rows& rows, const IsWanted& is_wanted) {
  Totals totals;
  for (const PartsRow& row : rows) {
    if (!is_wanted(row)) continue;
    totals.failed += row.failed ? 1 : 0;
    if (row.failed) continue;
    totals.rand_errors.push_back(row.rand_error);
    totals.parts.push_back(row.parts);
    totals.seconds.push_back(row.seconds);
    totals.uncut += row.cut_discrepancy ? 0 : 1;
  }
  return totals;
}

/// Of a method, with ascending times.
Totals TimesOf(const Rows& rows, Method method) {
  Totals times = TotalsOf(rows, [&](const PartsRow& row) { return row.method == method; });
  std::ranges::sort(times.seconds);
  return times;
}

Section TimesSection(const PartsSetup& setup, const Rows& rows) {
  const auto published = PublishedSeconds(setup.published, "published table 6.1");
  Section section = TableOf(
      "Computation time of one core, all models; mean and standard error; published: table 6.1",
      {"method", "models", "parts", "without a cut", "failed", "mean s", "median s", "max s",
       "published mean s", "times faster"});
  for (const Method method : setup.methods) {
    const Totals times = TimesOf(rows, method);
    const Mean seconds = MeanOf(times.seconds);
    const auto mean = seconds.mean;
    const std::size_t n = times.seconds.size();
    const auto known = published.find(method);
    const bool compare = known != published.end();
    section.grid.rows.push_back(
        {WordOf(method), std::to_string(n), CellOf(MeanOf(times.parts), 1),
         std::to_string(times.uncut), std::to_string(times.failed), CellOf(seconds),
         n > 0 ? Fixed(base::UpperMedianOf(times.seconds), kDigits) : "-",
         n > 0 ? Fixed(times.seconds.back(), kDigits) : "-",
         compare ? Fixed(known->second, 1) : "-",
         compare && mean && *mean > 0.0 ? Fixed(known->second / *mean, 0) : "-"});
  }
  return section;
}

Section CloudSection(const PartsSetup& setup, const Rows& rows, std::optional<Split> split) {
  Section section =
      TableOf("Clouds sampled from the models, mean and standard error, " +
                  ModelsText(setup, split) + "; noise in % of the bounding box's diagonal",
              {"method", "points", "noise %", "models", "1 - Rand index", "more than of meshes",
               "parts", "mean [s]", "failed"});
  for (const Method method : setup.methods) {
    for (const CloudGrade& grade : setup.clouds) {
      const auto of_method = [&](const PartsRow& row) {
        return row.method == method && (!split || row.split == *split);
      };
      const auto of_grade = [&](const PartsRow& row) {
        return of_method(row) && row.cloud == grade;
      };
      const Totals totals = TotalsOf(rows, of_grade);
      std::vector<double> more;  // than of the same models as meshes
      for (const PartsRow& row : rows) {
        if (!of_grade(row) || row.failed) continue;
        const auto mesh = std::ranges::find_if(rows, [&](const PartsRow& other) {
          return of_method(other) && !other.cloud && !other.failed && other.id == row.id;
        });
        if (mesh != rows.end()) more.push_back(row.rand_error - mesh->rand_error);
      }
      section.grid.rows.push_back(
          {WordOf(method), std::to_string(grade.points), fmt::format("{}", grade.noise_percent),
           std::to_string(totals.rand_errors.size()), CellOf(MeanOf(totals.rand_errors)),
           CellOf(MeanOf(more)), CellOf(MeanOf(totals.parts), 1), CellOf(MeanOf(totals.seconds), 2),
           std::to_string(totals.failed)});
    }
  }
  return section;
}

Section FailuresSection(const Rows& rows) {
  Section section = TableOf("Failed", {"class", "model", "method", "why"});
  section.grid.left = {true, false, true, true};
  for (const PartsRow& row : rows) {
    if (!row.failed) continue;
    const std::string cloud = row.cloud ? fmt::format(", {} points, {} % noise", row.cloud->points,
                                                      row.cloud->noise_percent)
                                        : "";
    section.grid.rows.push_back(
        {row.class_name, std::to_string(row.id), WordOf(row.method) + cloud, row.note});
  }
  return section;
}

/// Those of table 6.1.
std::vector<experiment::PublishedFigure> PublishedTimes(const PartsSetup& setup, const Rows& rows) {
  std::vector<experiment::PublishedFigure> figures;
  for (const auto& [method, published] : PublishedSeconds(setup.published, "published table 6.1")) {
    if (std::ranges::find(setup.methods, method) == setup.methods.end()) continue;
    const Totals times = TimesOf(rows, method);
    figures.push_back(
        {.row = fmt::format("{}, mean", base::Word(method)),
         .unit = "s",
         .digits = kDigits,
         .lower_is_better = true,
         .published = published,
         .own = MeanOf(times.seconds).mean,
         .evidence = experiment::TimesEvidence{static_cast<int>(times.seconds.size())},
         .key = "runtimes"});
  }
  return figures;
}

std::string RowsCsv(const Rows& rows) {
  std::string text =
      base::CsvLine({"class", "id", "split", "method", "parts", "rand_error", "cut_discrepancy",
                     "seconds", "failed", "note", "points", "noise_percent"});
  const auto number = [](double value) { return fmt::format("{}", value); };
  for (const PartsRow& row : rows) {
    text += base::CsvLine({row.class_name, std::to_string(row.id), WordOf(row.split),
                           WordOf(row.method), std::to_string(row.parts), number(row.rand_error),
                           row.cut_discrepancy ? number(*row.cut_discrepancy) : "",
                           number(row.seconds), row.failed ? "1" : "0", row.note,
                           row.cloud ? std::to_string(row.cloud->points) : "",
                           row.cloud ? number(row.cloud->noise_percent) : ""});
  }
  return text;
}

/// The means drawn: bars by class and overall, as files' names and SVG.
void AddFigures(const MetricMeans& means, Metric metric, const std::string& name,
                experiment::Report& report) {
  constexpr int kClassesWidth_px = 1100;  // ten classes of five bars
  constexpr int kOverallWidth_px = 600;
  const std::string title = metric == Metric::kRandError ? "1 - Rand index" : "Cut discrepancy";
  draw::BarChart classes{title + " by class", "lower is better", means.classes, {}, {}};
  draw::BarChart overall{title + ", mean of the classes", "lower is better", {}, {""}, {{}}};
  const auto number = [](const Mean& mean) {
    return mean.mean.value_or(std::numeric_limits<double>::quiet_NaN());
  };
  for (std::size_t m = 0; m < means.methods.size(); ++m) {
    classes.series.push_back(WordOf(means.methods[m]));
    auto& bars = classes.values.emplace_back();
    for (const Mean& one : means.by_class[m]) bars.push_back(number(one));
    overall.groups.push_back(WordOf(means.methods[m]));
    overall.values[0].push_back(number(means.overall[m]));
  }
  report.files.emplace_back(name + "_by_class.svg", draw::PlotSvg(classes, kClassesWidth_px));
  report.files.emplace_back(name + "_overall.svg", draw::PlotSvg(overall, kOverallWidth_px));
}

}  // namespace

PartsRow RowOf(const experiment::Record& record) {
  const experiment::Params& params = record.which.params;
  const experiment::Result& result = record.result;
  PartsRow row;
  row.class_name = params.Text("class");
  row.id = params.Int("model");
  row.split = base::FromWord<Split>(params.Text("split"), "split");
  row.method = base::FromWord<Method>(params.Text("method"), "method");
  if (params.Has("points")) row.cloud = {params.Int("points"), params.Number("noise_percent")};
  row.note = result.detail;
  row.failed = result.outcome != "scored";
  if (row.failed && result.outcome != "failed") {
    row.note = result.outcome + (row.note.empty() ? "" : ": " + row.note);
  }
  if (row.failed) return row;
  const json data = json::parse(result.data);
  row.parts = data.at("parts");
  row.rand_error = data.at("rand_error");
  if (!data.at("cut_discrepancy").is_null()) row.cut_discrepancy = data.at("cut_discrepancy");
  for (const auto& [stage, seconds] : result.seconds) {
    if (stage == "method") row.seconds = seconds;
  }
  return row;
}

MetricMeans MeansOf(const PartsSetup& setup, const std::vector<PartsRow>& rows, Metric metric,
                    std::optional<Split> split) {
  MetricMeans means;
  means.methods = setup.methods;
  for (const ModelClass& one : setup.classes) means.classes.push_back(one.name);
  for (const Method method : setup.methods) {
    auto& by_class = means.by_class.emplace_back();
    std::vector<double> of_models;
    for (const std::string& name : means.classes) {
      std::vector<double> values;
      for (const PartsRow& row : rows) {
        if (row.method != method || row.class_name != name || row.failed) continue;
        if (split && row.split != *split) continue;
        const auto value =
            metric == Metric::kRandError ? std::optional(row.rand_error) : row.cut_discrepancy;
        if (value) values.push_back(*value);
      }
      of_models.insert(of_models.end(), values.begin(), values.end());
      by_class.push_back(MeanOf(values));
    }
    means.overall.push_back(MeanOfClasses(by_class));
    means.over_models.push_back(MeanOf(of_models));
  }
  return means;
}

std::string MeansCsv(const MetricMeans& means, Metric metric) {
  constexpr int kMeanDigits = 6;  // more than the number of models supports
  const auto cell = [](const std::optional<double>& value) {
    return value ? Fixed(*value, kMeanDigits) : std::string();
  };
  std::string text = base::CsvLine(
      {"class", "method", metric == Metric::kRandError ? "one_minus_rand_index" : "cut_discrepancy",
       "standard_error", "models"});
  for (std::size_t c = 0; c <= means.classes.size(); ++c) {
    const bool total = c == means.classes.size();
    for (std::size_t m = 0; m < means.methods.size(); ++m) {
      const Mean& mean = total ? means.overall[m] : means.by_class[m][c];
      const Mean& spread = total ? means.over_models[m] : mean;
      text += base::CsvLine({total ? "overall" : means.classes[c], WordOf(means.methods[m]),
                             cell(mean.mean), cell(spread.standard_error),
                             std::to_string(spread.count)});
    }
  }
  return text;
}

std::map<Method, double> PublishedSeconds(const std::string& csv, const std::string& name) {
  std::map<Method, double> seconds;
  if (csv.empty()) return seconds;
  const auto table = base::CsvTable::Parse(csv, name);
  if (table.header().size() != 2) {
    throw base::InputError(name + ": must have two columns, 'method,average_s'");
  }
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double value = table.Number(row, 1);
    if (value < 0.0) table.Fail(row, 1, "must not be negative");
    const auto known = std::ranges::find(kNamesInTable61, table.Cell(row, 0));
    if (known == kNamesInTable61.end()) continue;
    seconds[static_cast<Method>(known - kNamesInTable61.begin())] = value;
  }
  return seconds;
}

experiment::Report PartsReport(const experiment::Stamp& stamp,
                               const std::vector<experiment::Record>& records) {
  const PartsSetup setup = PartsSetupOf(stamp);
  Rows all;
  for (const experiment::Record& record : records) all.push_back(RowOf(record));
  Rows rows = all;  // of meshes
  std::erase_if(rows, [](const PartsRow& row) { return row.cloud.has_value(); });
  // The models apart from those of tuning, and all where there are others.
  std::vector<std::optional<Split>> splits;
  if (setup.HasModels(Split::kReport)) splits.emplace_back(Split::kReport);
  if (setup.HasModels(Split::kTune)) splits.emplace_back(std::nullopt);

  experiment::Report report;
  for (const auto split : splits) report.sections.push_back(SummarySection(setup, rows, split));
  for (const auto split : splits) {
    if (!setup.clouds.empty()) report.sections.push_back(CloudSection(setup, all, split));
  }
  report.files.emplace_back("rows.csv", RowsCsv(all));
  for (const Metric metric : base::ValuesOf<Metric>()) {
    for (const auto split : splits) {
      report.sections.push_back(MetricSection(setup, rows, metric, split));
      const MetricMeans means = MeansOf(setup, rows, metric, split);
      const std::string name = WordOf(metric) + (split ? "" : "_all_models");
      report.files.emplace_back(name + ".csv", MeansCsv(means, metric));
      AddFigures(means, metric, name, report);
    }
  }
  report.sections.push_back(TimesSection(setup, rows));
  Section failures = FailuresSection(all);
  if (!failures.grid.rows.empty()) report.sections.push_back(std::move(failures));
  report.notes = {"SE: standard error of the mean over models, s / sqrt(n)"};
  report.published = PublishedTimes(setup, rows);
  return report;
}

}  // namespace rangegrasp::parts
