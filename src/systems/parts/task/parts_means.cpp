#include "parts/task/parts_means.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/csv.h"
#include "base/draw/bar_chart.h"
#include "experiment/grid.h"

namespace rangegrasp::parts_task {
namespace {

using experiment::Mean;
using experiment::MeanOf;
using nlohmann::json;
using parts::Method;

std::optional<double> ValueOf(const PartsRow& row, Metric metric) {
  if (row.failed) return std::nullopt;
  return metric == Metric::kRandError ? std::optional(row.rand_error) : row.cut_discrepancy;
}

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

}  // namespace

PartsRow RowOf(const experiment::Record& record) {
  const json params = json::parse(record.which.params);
  const experiment::Result& result = record.result;
  PartsRow row;
  row.class_name = params.at("class");
  row.id = params.at("model");
  row.split = base::FromWord<Split>(params.at("split").get<std::string>(), "split");
  row.method = base::FromWord<Method>(params.at("method").get<std::string>(), "method");
  if (params.contains("points")) row.cloud = {params.at("points"), params.at("noise_percent")};
  row.note = result.detail;
  row.failed = result.outcome != "scored";
  if (row.failed) {
    if (result.outcome != "failed") {
      row.note = result.outcome + (row.note.empty() ? "" : ": " + row.note);
    }
    return row;
  }
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
        if (row.method != method || row.class_name != name || (split && row.split != *split)) {
          continue;
        }
        if (const auto value = ValueOf(row, metric)) values.push_back(*value);
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
    return value ? experiment::Fixed(*value, kMeanDigits) : std::string();
  };
  std::string text = base::CsvLine(
      {"class", "method", metric == Metric::kRandError ? "one_minus_rand_index" : "cut_discrepancy",
       "standard_error", "models"});
  const auto add = [&](const std::string& name, std::size_t m, const std::optional<double>& value,
                       const Mean& spread) {
    text += base::CsvLine({name, std::string(base::Word(means.methods[m])), cell(value),
                           cell(spread.standard_error), fmt::format("{}", spread.count)});
  };
  for (std::size_t c = 0; c < means.classes.size(); ++c) {
    for (std::size_t m = 0; m < means.methods.size(); ++m) {
      add(means.classes[c], m, means.by_class[m][c].mean, means.by_class[m][c]);
    }
  }
  for (std::size_t m = 0; m < means.methods.size(); ++m) {
    add("overall", m, means.overall[m].mean, means.over_models[m]);
  }
  return text;
}

std::vector<std::pair<std::string, std::string>> MeansFigures(const MetricMeans& means,
                                                              Metric metric,
                                                              const std::string& name) {
  constexpr int kClassesWidth_px = 1100;  // ten classes of five bars
  constexpr int kOverallWidth_px = 600;
  const std::string title = metric == Metric::kRandError ? "1 - Rand index" : "Cut discrepancy";
  draw::BarChart classes{title + " by class", "lower is better", means.classes, {}, {}};
  draw::BarChart overall{title + ", mean of the classes", "lower is better", {}, {""}, {{}}};
  const auto number = [](const std::optional<double>& value) {
    return value.value_or(std::numeric_limits<double>::quiet_NaN());
  };
  for (std::size_t m = 0; m < means.methods.size(); ++m) {
    classes.series.emplace_back(base::Word(means.methods[m]));
    auto& bars = classes.values.emplace_back();
    for (const Mean& one : means.by_class[m]) bars.push_back(number(one.mean));
    overall.groups.emplace_back(base::Word(means.methods[m]));
    overall.values[0].push_back(number(means.overall[m].mean));
  }
  return {{name + "_by_class.svg", draw::PlotSvg(classes, kClassesWidth_px)},
          {name + "_overall.svg", draw::PlotSvg(overall, kOverallWidth_px)}};
}

}  // namespace rangegrasp::parts_task
