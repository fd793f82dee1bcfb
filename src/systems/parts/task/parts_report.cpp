#include "parts/task/parts_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>

#include "base/csv.h"
#include "base/error.h"
#include "base/quantile.h"
#include "parts/task/parts_means.h"

namespace rangegrasp::parts_task {
namespace {

using experiment::Fixed;
using experiment::Grid;
using experiment::Mean;
using experiment::MeanOf;
using experiment::Section;
using parts::Method;
using Rows = std::vector<PartsRow>;

constexpr int kDigits = 4;  ///< of metrics and seconds: as the chapter's figures can be read

/// What table 6.1 calls a method; empty where it does not have it.
constexpr std::array<std::string_view, 5> kNamesInTable61 = {"Proposed Method", "", "K-Means",
                                                             "SDF", "Core Extraction"};

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
  Section section{
      "Mean over models and its standard error, lower is better, " + ModelsText(setup, split),
      {{"method", "models", "1 - Rand index", "SE (Rand)", "models with cuts", "cut discrepancy",
        "SE (cut)"},
       {true, false, false, false, false, false, false},
       {},
       false}};
  const MetricMeans rand = MeansOf(setup, rows, Metric::kRandError, split);
  const MetricMeans cut = MeansOf(setup, rows, Metric::kCutDiscrepancy, split);
  for (std::size_t m = 0; m < setup.methods.size(); ++m) {
    std::vector<std::string> row = {std::string(base::Word(setup.methods[m]))};
    for (const Mean* mean : {&rand.over_models[m], &cut.over_models[m]}) {
      row.push_back(fmt::format("{}", mean->count));
      row.push_back(CellOf(mean->mean));
      row.push_back(CellOf(mean->standard_error));
    }
    section.grid.rows.push_back(std::move(row));
  }
  return section;
}

Grid MeansGrid(const MetricMeans& means) {
  Grid grid{{"class"}, {true}, {}, true};
  for (const Method method : means.methods) {
    grid.header.emplace_back(base::Word(method));
    grid.left.push_back(false);
  }
  for (std::size_t c = 0; c <= means.classes.size(); ++c) {
    const bool total = c == means.classes.size();
    std::vector<std::string> row = {total ? "mean of the classes" : means.classes[c]};
    for (std::size_t m = 0; m < means.methods.size(); ++m) {
      row.push_back(CellOf(total ? means.overall[m] : means.by_class[m][c]));
    }
    grid.rows.push_back(std::move(row));
  }
  return grid;
}

Section MetricSection(const PartsSetup& setup, const Rows& rows, Metric metric,
                      std::optional<Split> split) {
  return {
      (metric == Metric::kRandError
           ? "1 - Rand index, mean and standard error, lower is better, "
           : "Cut discrepancy, mean and standard error, lower is better, where there are cuts, ") +
          ModelsText(setup, split),
      MeansGrid(MeansOf(setup, rows, metric, split))};
}

struct Times {
  std::vector<double> seconds;  ///< ascending
  std::vector<double> parts;
  int uncut = 0;
  int failed = 0;
};

Times TimesOf(const Rows& rows, Method method) {
  Times times;
  for (const PartsRow& row : rows) {
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

Section TimesSection(const PartsSetup& setup, const Rows& rows) {
  const auto published = PublishedSeconds(setup.published, "published table 6.1");
  Section section{
      "Computation time of one core, all models; mean and standard error; published: table 6.1",
      {{"method", "models", "parts", "without a cut", "failed", "mean s", "median s", "max s",
        "published mean s", "times faster"},
       std::vector<bool>(10, false),
       {},
       false}};
  section.grid.left[0] = true;
  for (const Method method : setup.methods) {
    const Times times = TimesOf(rows, method);
    const Mean seconds = MeanOf(times.seconds);
    const auto mean = seconds.mean;
    const std::size_t n = times.seconds.size();
    const auto known = published.find(method);
    const bool compare = known != published.end();
    section.grid.rows.push_back(
        {std::string(base::Word(method)), fmt::format("{}", n), CellOf(MeanOf(times.parts), 1),
         fmt::format("{}", times.uncut), fmt::format("{}", times.failed), CellOf(seconds),
         n > 0 ? Fixed(base::UpperMedianOf(times.seconds), kDigits) : "-",
         n > 0 ? Fixed(times.seconds.back(), kDigits) : "-",
         compare ? Fixed(known->second, 1) : "-",
         compare && mean && *mean > 0.0 ? Fixed(known->second / *mean, 0) : "-"});
  }
  return section;
}

/// Of clouds of one grade, and of the same models as meshes.
struct CloudFigures {
  std::vector<double> rand_errors, more, parts, seconds;
  int failed = 0;
};

CloudFigures FiguresOf(const Rows& rows, Method method, const CloudGrade& grade,
                       std::optional<Split> split) {
  CloudFigures figures;
  const auto is_wanted = [&](const PartsRow& row) {
    return row.method == method && (!split || row.split == *split);
  };
  for (const PartsRow& row : rows) {
    if (!is_wanted(row) || row.cloud != grade) continue;
    figures.failed += row.failed ? 1 : 0;
    if (row.failed) continue;
    figures.rand_errors.push_back(row.rand_error);
    figures.parts.push_back(row.parts);
    figures.seconds.push_back(row.seconds);
    const auto mesh = std::ranges::find_if(rows, [&](const PartsRow& other) {
      return is_wanted(other) && !other.cloud && !other.failed && other.id == row.id;
    });
    if (mesh != rows.end()) figures.more.push_back(row.rand_error - mesh->rand_error);
  }
  return figures;
}

Section CloudSection(const PartsSetup& setup, const Rows& rows, std::optional<Split> split) {
  constexpr std::size_t kColumns = 9;
  Section section{"Clouds sampled from the models, mean and standard error, " +
                      ModelsText(setup, split) + "; noise in % of the bounding box's diagonal",
                  {{"method", "points", "noise %", "models", "1 - Rand index",
                    "more than of meshes", "parts", "mean [s]", "failed"},
                   std::vector<bool>(kColumns, false),
                   {},
                   false}};
  section.grid.left[0] = true;
  for (const Method method : setup.methods) {
    for (const CloudGrade& grade : setup.clouds) {
      const CloudFigures figures = FiguresOf(rows, method, grade, split);
      section.grid.rows.push_back(
          {std::string(base::Word(method)), fmt::format("{}", grade.points),
           fmt::format("{}", grade.noise_percent), fmt::format("{}", figures.rand_errors.size()),
           CellOf(MeanOf(figures.rand_errors)), CellOf(MeanOf(figures.more)),
           CellOf(MeanOf(figures.parts), 1), CellOf(MeanOf(figures.seconds), 2),
           fmt::format("{}", figures.failed)});
    }
  }
  return section;
}

Section FailuresSection(const Rows& rows) {
  Section section{"Failed",
                  {{"class", "model", "method", "why"}, {true, false, true, true}, {}, false}};
  for (const PartsRow& row : rows) {
    if (!row.failed) continue;
    section.grid.rows.push_back(
        {row.class_name, fmt::format("{}", row.id), std::string(base::Word(row.method)), row.note});
    if (!row.cloud) continue;
    section.grid.rows.back()[2] +=
        fmt::format(", {} points, {} % noise", row.cloud->points, row.cloud->noise_percent);
  }
  return section;
}

// Of table 6.1.
std::vector<experiment::PublishedFigure> FiguresOf(const PartsSetup& setup, const Rows& rows) {
  std::vector<experiment::PublishedFigure> figures;
  for (const auto& [method, published] : PublishedSeconds(setup.published, "published table 6.1")) {
    if (std::ranges::find(setup.methods, method) == setup.methods.end()) continue;
    const Times times = TimesOf(rows, method);
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
  for (const PartsRow& row : rows) {
    text += base::CsvLine({row.class_name, fmt::format("{}", row.id),
                           std::string(base::Word(row.split)), std::string(base::Word(row.method)),
                           fmt::format("{}", row.parts), fmt::format("{}", row.rand_error),
                           row.cut_discrepancy ? fmt::format("{}", *row.cut_discrepancy) : "",
                           fmt::format("{}", row.seconds), row.failed ? "1" : "0", row.note,
                           row.cloud ? fmt::format("{}", row.cloud->points) : "",
                           row.cloud ? fmt::format("{}", row.cloud->noise_percent) : ""});
  }
  return text;
}

}  // namespace

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
    const auto known =
        std::find(kNamesInTable61.begin(), kNamesInTable61.end(), table.Cell(row, 0));
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
  Rows rows;  // of meshes
  std::ranges::copy_if(all, std::back_inserter(rows),
                       [](const PartsRow& row) { return !row.cloud; });
  // The models apart from those of tuning, and all where there are others.
  std::vector<std::optional<Split>> splits;
  if (setup.HasModels(Split::kReport)) splits.emplace_back(Split::kReport);
  if (setup.HasModels(Split::kTune)) splits.emplace_back(std::nullopt);

  experiment::Report report;
  for (const auto split : splits) report.sections.push_back(SummarySection(setup, rows, split));
  for (const auto split : splits) {
    if (!setup.clouds.empty()) report.sections.push_back(CloudSection(setup, all, split));
  }
  for (const Metric metric : base::ValuesOf<Metric>()) {
    for (const auto split : splits) {
      report.sections.push_back(MetricSection(setup, rows, metric, split));
    }
  }
  report.sections.push_back(TimesSection(setup, rows));
  Section failures = FailuresSection(all);
  if (!failures.grid.rows.empty()) report.sections.push_back(std::move(failures));
  report.notes = {"SE: standard error of the mean over models, s / sqrt(n)"};

  report.published = FiguresOf(setup, rows);
  report.files.emplace_back("rows.csv", RowsCsv(all));
  for (const Metric metric : base::ValuesOf<Metric>()) {
    for (const auto split : splits) {
      const MetricMeans means = MeansOf(setup, rows, metric, split);
      const std::string name = std::string(base::Word(metric)) + (split ? "" : "_all_models");
      report.files.emplace_back(name + ".csv", MeansCsv(means, metric));
      for (auto& figure : MeansFigures(means, metric, name)) {
        report.files.push_back(std::move(figure));
      }
    }
  }
  return report;
}

}  // namespace rangegrasp::parts_task
