#include "parts/task/parts_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/draw/plot.h"
#include "base/file.h"
#include "base/words.h"

namespace rangegrasp::parts {
namespace {

using experiment::Column;
using experiment::Fixed;
using experiment::kLeft;
using experiment::Mean;
using experiment::MeanOf;
using experiment::Section;
using nlohmann::json;
using Rows = std::vector<PartsRow>;

constexpr int kDigits = 4;  ///< of metrics and seconds: as the chapter's figures can be read

/// Names of the methods in table 6.1; empty if a method is not in it.
constexpr std::array<std::string_view, 5> kNamesInTable61 = {"Proposed Method", "", "K-Means",
                                                             "SDF", "Core Extraction"};

/// Mean over the classes that have a mean, with equal weights.
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

std::string MethodWord(Method method) { return std::string(base::Word(method)); }

std::string CellOf(const std::optional<double>& value, int digits = kDigits) {
  return value ? Fixed(*value, digits) : "-";
}

/// E.g. "0.1107 +- 0.0190"; without the error if there is none.
std::string CellOf(const Mean& mean, int digits = kDigits) {
  return CellOf(mean.mean, digits) +
         (mean.standard_error ? " +- " + Fixed(*mean.standard_error, digits) : "");
}

/// A table without rows, whose first column contains words.
Section TableOf(const std::string& title, const std::vector<std::string>& header) {
  std::vector<bool> left(header.size(), false);
  left[0] = true;
  return {title, {header, left, {}, false}};
}

/// E.g. "20 models without the tuning models".
std::string ModelsText(const PartsSetup& setup, std::optional<Split> split) {
  std::size_t models = 0;
  for (const ModelClass& one : setup.classes) {
    models += one.report.size() + (split ? 0 : one.tune.size());
  }
  return fmt::format("{}{}", base::Counted(models, "model"),
                     split ? " without the tuning models" : ", including the tuning models");
}

Section SummarySection(const PartsSetup& setup, const Rows& rows, std::optional<Split> split) {
  Section section = TableOf(
      "Mean over models and its standard error, lower is better, " + ModelsText(setup, split),
      {"method", "models", "1 - Rand index", "SE (Rand)", "models with cuts", "cut discrepancy",
       "SE (cut)"});
  const auto rand = MeansOf(setup, rows, Metric::kRandError, split);
  const auto cut = MeansOf(setup, rows, Metric::kCutDiscrepancy, split);
  for (std::size_t m = 0; m < rand.size(); ++m) {
    std::vector<std::string> row = {MethodWord(rand[m].method)};
    for (const Mean& mean : {rand[m].over_models, cut[m].over_models}) {
      row.insert(row.end(),
                 {std::to_string(mean.count), CellOf(mean.mean), CellOf(mean.standard_error)});
    }
    section.grid.rows.push_back(row);
  }
  return section;
}

std::string TitleOf(Metric metric) {
  return metric == Metric::kRandError ? "1 - Rand index" : "Cut discrepancy";
}

Section MetricSection(const PartsSetup& setup, const std::vector<MethodMeans>& means, Metric metric,
                      std::optional<Split> split) {
  const std::string where = metric == Metric::kRandError ? "" : "only models with cuts, ";
  Section section = TableOf(TitleOf(metric) + ", mean and standard error, lower is better, " +
                                where + ModelsText(setup, split),
                            {"class"});
  auto& [header, left, rows, total] = section.grid;
  total = true;
  for (const ModelClass& one : setup.classes) rows.push_back({one.name});
  rows.push_back({"mean of the classes"});
  for (const MethodMeans& of : means) {
    header.push_back(MethodWord(of.method));
    left.push_back(false);
    for (std::size_t c = 0; c < of.by_class.size(); ++c) rows[c].push_back(CellOf(of.by_class[c]));
    rows.back().push_back(CellOf(of.overall));
  }
  return section;
}

/// Results of some rows.
struct Totals {
  std::vector<double> rand_errors, parts, seconds;
  std::vector<double> more;  ///< Rand error of clouds minus that of the same models as meshes
  int failed = 0;
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
    if (!row.cloud) continue;
    const auto mesh = std::ranges::find_if(rows, [&](const PartsRow& other) {
      return !other.cloud && !other.failed && other.method == row.method && other.id == row.id;
    });
    if (mesh != rows.end()) totals.more.push_back(row.rand_error - mesh->rand_error);
  }
  return totals;
}

Totals TotalsOf(const Rows& rows, Method method) {
  return TotalsOf(rows, [&](const PartsRow& row) { return row.method == method; });
}

Section TimesSection(const PartsSetup& setup, const Rows& rows) {
  const auto published = PublishedSeconds(setup.published, "published table 6.1");
  Section section = TableOf(
      "Computation time of one core, all models; mean and standard error; published: table 6.1",
      {"method", "models", "parts", "failed", "mean s", "published mean s"});
  for (const Method method : setup.methods) {
    const Totals totals = TotalsOf(rows, method);
    const Mean seconds = MeanOf(totals.seconds);
    std::optional<double> known;
    if (published.contains(method)) known = published.at(method);
    section.grid.rows.push_back({MethodWord(method), std::to_string(seconds.count),
                                 CellOf(MeanOf(totals.parts), 1), std::to_string(totals.failed),
                                 CellOf(seconds), CellOf(known, 1)});
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
      const Totals totals = TotalsOf(rows, [&](const PartsRow& row) {
        return row.method == method && row.cloud == grade && (!split || row.split == *split);
      });
      section.grid.rows.push_back(
          {MethodWord(method), std::to_string(grade.points), fmt::format("{}", grade.noise_percent),
           std::to_string(totals.rand_errors.size()), CellOf(MeanOf(totals.rand_errors)),
           CellOf(MeanOf(totals.more)), CellOf(MeanOf(totals.parts), 1),
           CellOf(MeanOf(totals.seconds), 2), std::to_string(totals.failed)});
    }
  }
  return section;
}

Section FailuresSection(Rows rows) {
  std::erase_if(rows, [](const PartsRow& row) { return !row.failed; });
  const auto name = [](const PartsRow& row) {
    return !row.cloud ? MethodWord(row.method)
                      : fmt::format("{}, {} points, {} % noise", base::Word(row.method),
                                    row.cloud->points, row.cloud->noise_percent);
  };
  const std::vector<Column<PartsRow>> columns = {{"class", "", &PartsRow::class_name, kLeft},
                                                 {"model", "", &PartsRow::id},
                                                 {"method", "", name, kLeft},
                                                 {"why", "", &PartsRow::note, kLeft}};
  return {"Failed", GridOf(columns, rows)};
}

/// Published times, from table 6.1.
std::vector<experiment::PublishedFigure> PublishedTimes(const PartsSetup& setup, const Rows& rows) {
  std::vector<experiment::PublishedFigure> figures;
  for (const auto& [method, published] : PublishedSeconds(setup.published, "published table 6.1")) {
    if (std::ranges::find(setup.methods, method) == setup.methods.end()) continue;
    const Totals totals = TotalsOf(rows, method);
    figures.push_back(
        {.row = fmt::format("{}, mean", base::Word(method)),
         .unit = "s",
         .digits = kDigits,
         .lower_is_better = true,
         .published = published,
         .own = MeanOf(totals.seconds).mean,
         .evidence = experiment::TimesEvidence{static_cast<int>(totals.seconds.size())},
         .key = "runtimes"});
  }
  return figures;
}

std::string RowsCsv(const Rows& rows) {
  const auto of_cloud = [](auto member) {
    return [=](const PartsRow& row) {
      return row.cloud ? std::optional((*row.cloud).*member) : std::nullopt;
    };
  };
  const std::vector<Column<PartsRow>> columns = {
      {"class", "", &PartsRow::class_name},
      {"id", "", &PartsRow::id},
      {"split", "", [](const PartsRow& row) { return base::Word(row.split); }},
      {"method", "", [](const PartsRow& row) { return base::Word(row.method); }},
      {"parts", "", &PartsRow::parts},
      {"rand_error", "", &PartsRow::rand_error},
      {"cut_discrepancy", "", &PartsRow::cut_discrepancy},
      {"seconds", "", &PartsRow::seconds},
      {"failed", "d", &PartsRow::failed},
      {"note", "", &PartsRow::note},
      {"points", "", of_cloud(&CloudGrade::points)},
      {"noise_percent", "", of_cloud(&CloudGrade::noise_percent)}};
  return CsvOf(GridOf(columns, rows, ""));
}

/// Adds bar charts of the means, by class and overall, as SVG files.
void AddFigures(const PartsSetup& setup, const std::vector<MethodMeans>& means, Metric metric,
                const std::string& name, experiment::Report& report) {
  constexpr int kClassesWidth_px = 1100;  // ten classes of five bars
  constexpr int kOverallWidth_px = 600;
  const std::string title = TitleOf(metric);
  draw::BarChart classes{title + " by class", "lower is better", {}, {}, {}};
  draw::BarChart overall{title + ", mean of the classes", "lower is better", {}, {""}, {{}}};
  const auto number = [](const Mean& mean) {
    return mean.mean.value_or(std::numeric_limits<double>::quiet_NaN());
  };
  for (const ModelClass& one : setup.classes) classes.groups.push_back(one.name);
  for (const MethodMeans& of : means) {
    classes.series.push_back(MethodWord(of.method));
    auto& bars = classes.values.emplace_back();
    for (const Mean& one : of.by_class) bars.push_back(number(one));
    overall.groups.push_back(MethodWord(of.method));
    overall.values[0].push_back(number(of.overall));
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

std::vector<MethodMeans> MeansOf(const PartsSetup& setup, const std::vector<PartsRow>& rows,
                                 Metric metric, std::optional<Split> split) {
  std::vector<MethodMeans> means;
  for (const Method method : setup.methods) {
    MethodMeans& of = means.emplace_back(MethodMeans{method, {}, {}, {}});
    std::vector<double> of_models;
    for (const ModelClass& one : setup.classes) {
      std::vector<double> values;
      for (const PartsRow& row : rows) {
        if (row.method != method || row.class_name != one.name || row.failed) continue;
        if (split && row.split != *split) continue;
        const auto value =
            metric == Metric::kRandError ? std::optional(row.rand_error) : row.cut_discrepancy;
        if (value) values.push_back(*value);
      }
      of_models.insert(of_models.end(), values.begin(), values.end());
      of.by_class.push_back(MeanOf(values));
    }
    of.overall = MeanOfClasses(of.by_class);
    of.over_models = MeanOf(of_models);
  }
  return means;
}

std::map<Method, double> PublishedSeconds(const std::string& csv, const std::string& name) {
  std::map<Method, double> seconds;
  if (csv.empty()) return seconds;
  const auto table = base::CsvTable::Parse(csv, name);
  const std::size_t names = table.Column("method"), averages = table.Column("average_s");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double value = table.Number(row, averages);
    const auto known = std::ranges::find(kNamesInTable61, table.Cell(row, names));
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
  Rows rows = all;  // of meshes only
  std::erase_if(rows, [](const PartsRow& row) { return row.cloud.has_value(); });
  // Without the tuning models, and also all models if there are tuning models.
  std::vector<std::optional<Split>> splits;
  const auto has_models = [&](std::vector<int> ModelClass::*ids) {
    return std::ranges::any_of(setup.classes, [&](const auto& one) { return !(one.*ids).empty(); });
  };
  if (has_models(&ModelClass::report)) splits.emplace_back(Split::kReport);
  if (has_models(&ModelClass::tune)) splits.emplace_back(std::nullopt);

  experiment::Report report;
  for (const auto split : splits) report.sections.push_back(SummarySection(setup, rows, split));
  for (const auto split : splits) {
    if (!setup.clouds.empty()) report.sections.push_back(CloudSection(setup, all, split));
  }
  report.files.emplace_back("rows.csv", RowsCsv(all));
  for (const Metric metric : base::ValuesOf<Metric>()) {
    for (const auto split : splits) {
      const auto means = MeansOf(setup, rows, metric, split);
      report.sections.push_back(MetricSection(setup, means, metric, split));
      const std::string name = std::string(base::Word(metric)) + (split ? "" : "_all_models");
      AddFigures(setup, means, metric, name, report);
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
