#include "trial/trial_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "base/units.h"
#include "trial/friction_curve.h"
#include "trial/table.h"

namespace rangegrasp::trial {
namespace {

using experiment::Chart;
using experiment::Count;
using experiment::PercentOf;
using experiment::Record;
using nlohmann::json;

constexpr const char* kDelivered = "delivered of detected";

// Upper ends of bins; what is larger is in one more. A hold's slip is a millimetre or two, a lost
// object's is as far as it fell.
const std::vector<double> kSlipEnds_mm = {1, 2, 5, 10, 20, 50};
const std::vector<double> kTiltEnds_deg = {1, 2, 5, 10, 20, 45};

// Of a record that counts as detected.
struct Tried {
  json data;
  bool delivered = false;
};

std::vector<Tried> TriedOf(const std::vector<Record>& records) {
  std::vector<Tried> tried;
  for (const Record& record : records) {
    auto data = json::parse(record.result.data, nullptr, false);
    if (!data.is_object() || !data.value("detected", false)) continue;
    tried.push_back({std::move(data), record.result.outcome == "delivered"});
  }
  return tried;
}

Chart DeliveredChart(const std::string& title, const std::string& along) {
  Chart chart;
  chart.title = title;
  chart.unit = "%";
  chart.along = along;
  chart.series = {{kDelivered, {}}};
  return chart;
}

void Add(const std::string& label, const Count& count, Chart& chart) {
  chart.labels.push_back(label);
  chart.series.front().values.push_back(PercentOf(count));
}

Chart::Value PublishedValue(const std::optional<double>& rate) {
  if (!rate) return {};
  return {100.0 * *rate, {}, ""};
}

Chart ObjectChart(const Table& table, const char* title, int Row::*k, int Row::*n,
                  std::optional<double> Row::*published) {
  Chart chart;
  chart.title = title;
  chart.unit = "%";
  chart.along = "object";
  chart.series = {{"this run", {}}, {"published", {}}};
  bool any = false;
  for (const Row& row : table.rows) {
    chart.labels.push_back(row.title.empty() ? row.object : row.title);
    chart.series[0].values.push_back(PercentOf({row.*k, row.*n}));
    chart.series[1].values.push_back(PublishedValue(row.*published));
    any = any || row.*published;
  }
  if (!any) chart.series.pop_back();
  return chart;
}

// By a word of the records.
Chart WordChart(const std::vector<Tried>& tried, const char* key, const std::string& title,
                const std::string& along) {
  std::map<std::string, Count> counts;
  for (const Tried& one : tried) {
    const auto word = one.data.find(key);
    if (word == one.data.end() || !word->is_string() || word->get_ref<const std::string&>().empty())
      continue;
    Count& count = counts[word->get<std::string>()];
    ++count.n;
    count.k += one.delivered ? 1 : 0;
  }
  Chart chart = DeliveredChart(title, along);
  for (const auto& [word, count] : counts) Add(word, count, chart);
  return chart;
}

// By a figure of the executions' logs.
Chart LogChart(const std::vector<Tried>& tried, const char* key, double scale,
               const std::vector<double>& ends, const std::string& title,
               const std::string& along) {
  std::vector<Count> counts(ends.size() + 1);
  for (const Tried& one : tried) {
    const auto log = one.data.find("log");
    if (log == one.data.end() || !log->contains(key) || !(*log)[key].is_number()) continue;
    const double figure = scale * (*log)[key].get<double>();
    const auto bin = std::upper_bound(ends.begin(), ends.end(), figure) - ends.begin();
    Count& count = counts[static_cast<std::size_t>(bin)];
    ++count.n;
    count.k += one.delivered ? 1 : 0;
  }
  Chart chart = DeliveredChart(title, along);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i].n == 0) continue;
    const std::string low = i == 0 ? "0" : fmt::format("{:g}", ends[i - 1]);
    Add(i == ends.size() ? "over " + low : fmt::format("{}-{:g}", low, ends[i]), counts[i], chart);
  }
  return chart;
}

Chart FrictionChart(const std::vector<Record>& records) {
  std::map<int, Count> counts;
  for (const auto& [object, bins] : FrictionCurveOf(records)) {
    for (const auto& [bin, of_object] : bins) {
      counts[bin].k += of_object.delivered;
      counts[bin].n += of_object.detected;
    }
  }
  Chart chart =
      DeliveredChart("Delivered by friction", "static friction of the glove on the object, from");
  for (const auto& [bin, count] : counts)
    Add(fmt::format("{:.2f}", bin * kFrictionBin), count, chart);
  return chart;
}

}  // namespace

std::vector<Chart> ChartsOf(const experiment::Stamp& stamp, const std::vector<Record>& records) {
  const Table table = BuildTable(stamp, records);
  const auto tried = TriedOf(records);
  std::vector<Chart> charts = {
      ObjectChart(table, "Detection rate by object", &Row::detected, &Row::trials,
                  &Row::published_detection_rate),
      ObjectChart(table, "Grasping rate by object", &Row::delivered, &Row::detected,
                  &Row::published_grasp_rate),
      WordChart(tried, "pose_class", "Delivered by resting pose", "resting pose"),
      WordChart(tried, "grasp_type", "Delivered by kind of grasp", "kind of grasp"),
      FrictionChart(records),
      LogChart(tried, "slip_in_hand_m", base::kMmPerM, kSlipEnds_mm, "Delivered by slip",
               "slip in the hand while it held, mm"),
      LogChart(tried, "tilt_in_hand_rad", base::ToDeg(1.0), kTiltEnds_deg, "Delivered by tilt",
               "turn in the hand while it held, degrees")};
  std::erase_if(charts, [](const Chart& chart) { return chart.labels.empty(); });
  return charts;
}

}  // namespace rangegrasp::trial
