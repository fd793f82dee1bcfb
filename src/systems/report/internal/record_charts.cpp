#include "report/internal/record_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

#include "experiment/compare.h"

namespace rangegrasp::report::internal {
namespace {

using experiment::Chart;
using experiment::Record;

// Cases by label and outcome, both in the order in which they first occur.
Chart OutcomeChart(const std::vector<Record>& records, const std::string& title,
                   const std::string& along,
                   const std::function<std::string(const Record&)>& label_of) {
  Chart chart;
  chart.title = title;
  chart.unit = "cases";
  chart.along = along;
  chart.stacked = true;
  std::map<std::string, std::map<std::string, int>> counts;  // by outcome, then label
  for (const Record& record : records) {
    const std::string label = label_of(record);
    if (std::find(chart.labels.begin(), chart.labels.end(), label) == chart.labels.end()) {
      chart.labels.push_back(label);
    }
    ++counts[record.result.outcome][label];
  }
  for (auto& [outcome, by_label] : counts) {
    auto& series = chart.series.emplace_back();
    series.name = outcome;
    for (const std::string& label : chart.labels) {
      series.values.push_back({static_cast<double>(by_label[label]), {}, ""});
    }
  }
  return chart;
}

Chart TimesChart(const std::vector<Record>& records) {
  Chart chart;
  chart.title = "Time of each stage";
  chart.unit = "s";
  chart.along = "stage";
  chart.note = "The mark is the median, the line goes from it to the 95 % quantile.";
  chart.series = {{"median", {}}};
  for (const auto& time : experiment::StageTimes(records)) {
    if (time.stage.find(':') != std::string::npos) continue;  // a step within a stage
    chart.labels.push_back(time.stage);
    chart.series.front().values.push_back(
        {time.median_s, std::pair(time.median_s, time.p95_s), ""});
  }
  return chart;
}

}  // namespace

std::vector<Chart> RecordCharts(const experiment::Stamp& stamp, const std::vector<Record>& records,
                                const std::string& success) {
  std::vector<Record> failed;
  std::copy_if(records.begin(), records.end(), std::back_inserter(failed),
               [&](const Record& record) { return record.result.outcome != success; });
  std::vector<Chart> charts = {
      OutcomeChart(success.empty() ? records : failed,
                   success.empty() ? "Outcomes by group" : "Failures by group", "group",
                   [&](const Record& record) { return TitleOf(stamp, record.which.group); }),
      TimesChart(records)};
  if (!success.empty()) {
    charts.insert(charts.begin(),
                  OutcomeChart(failed, "Failures by the stage that they ended in", "stage",
                               [](const Record& record) { return record.result.stage; }));
  }
  std::erase_if(charts, [](const Chart& chart) { return chart.labels.empty(); });
  return charts;
}

}  // namespace rangegrasp::report::internal
