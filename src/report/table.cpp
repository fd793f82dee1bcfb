#include "report/table.h"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/error.h"
#include "report/statistics.h"

namespace rangegrasp::report {
namespace {

using experiment::Outcome;
using experiment::TrialResult;

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

struct Published {
  std::optional<double> detection, grasp;
};

// A rate in per cent; nothing where the cell is empty.
std::optional<double> PublishedRate(const std::string& cell, const std::string& line) {
  if (cell.empty()) return std::nullopt;
  char* end = nullptr;
  const double percent = std::strtod(cell.c_str(), &end);
  if (*end != '\0' || !(percent >= 0.0 && percent <= 100.0)) {
    throw core::InputError("reference table, line '" + line + "': '" + cell +
                           "' must be a rate from 0 to 100 per cent");
  }
  return percent / 100.0;
}

// The published table: object,name,detection_rate,grasping_rate in per cent; by name, and
// "overall".
std::map<std::string, Published> ParseReference(const std::string& csv) {
  std::map<std::string, Published> published;
  for (std::string line : Split(csv, '\n')) {
    if (line.ends_with('\r')) line.pop_back();
    const auto cells = Split(line, ',');
    if (line.empty() || cells[0] == "object") continue;
    if (cells.size() != 4) {
      throw core::InputError("reference table, line '" + line +
                             "': must be object,name,detection_rate,grasping_rate");
    }
    const std::string name = cells[0] == "overall" ? "overall" : cells[1];
    published[name] = {PublishedRate(cells[2], line), PublishedRate(cells[3], line)};
  }
  return published;
}

void Count(const TrialResult& result, Row& row) {
  ++row.trials;
  row.detected += result.detected ? 1 : 0;
  row.delivered += result.outcome == Outcome::kDelivered ? 1 : 0;
  ++row.outcomes[experiment::Name(result.outcome)];
}

std::optional<double> Rate(int k, int n) {
  if (n == 0) return std::nullopt;
  return static_cast<double>(k) / n;
}

// The mean of those rows that have the rate: the dissertation's "overall".
std::optional<double> MeanOf(const std::vector<Row>& rows, std::optional<double> Row::*rate) {
  double sum = 0.0;
  int n = 0;
  for (const Row& row : rows) {
    if (!(row.*rate)) continue;
    sum += *(row.*rate);
    ++n;
  }
  if (n == 0) return std::nullopt;
  return sum / n;
}

double Quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  const double position = q * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(position);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  const double t = position - static_cast<double>(low);
  return values[low] * (1.0 - t) + values[high] * t;
}

std::vector<StageTime> StageTimes(const std::vector<TrialResult>& results) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<double>> by_stage;
  for (const TrialResult& result : results) {
    for (const auto& [stage, seconds] : result.seconds) {
      if (!by_stage.contains(stage)) order.push_back(stage);
      by_stage[stage].push_back(seconds);
    }
  }
  std::vector<StageTime> times;
  for (const std::string& stage : order) {
    const auto& all = by_stage[stage];
    times.push_back({stage, Quantile(all, 0.5), Quantile(all, 0.95)});
  }
  return times;
}

std::map<std::string, double> WorstAudit(const std::vector<TrialResult>& results) {
  std::map<std::string, double> worst;
  for (const TrialResult& result : results) {
    const auto log = nlohmann::json::parse(result.log, nullptr, false);
    if (!log.is_object() || !log.contains("audit")) continue;
    for (const auto& [name, value] : log["audit"].items()) {
      if (value.is_number()) {
        worst[name] =
            std::max(worst.contains(name) ? worst[name] : value.get<double>(), value.get<double>());
      }
    }
  }
  return worst;
}

}  // namespace

Table BuildTable(const experiment::Store& store) {
  return BuildTable(store.ReadStamp(), store.ReadAll());
}

Table BuildTable(const std::map<std::string, std::string>& stamp,
                 const std::vector<TrialResult>& results) {
  Table table;
  table.stamp = stamp;
  const auto get = [&](const std::string& key) {
    const auto it = stamp.find(key);
    return it == stamp.end() ? std::string() : it->second;
  };
  const auto published = ParseReference(get("reference"));
  for (const std::string& object : Split(get("objects"), ',')) {
    Row row;
    row.object = object;
    row.title = get("title." + object);
    for (const TrialResult& result : results) {
      if (result.object == object) Count(result, row);
    }
    row.detection_rate = Rate(row.detected, row.trials);
    row.grasp_rate = Rate(row.delivered, row.detected);
    if (const auto it = published.find(row.title); it != published.end()) {
      row.published_detection_rate = it->second.detection;
      row.published_grasp_rate = it->second.grasp;
    }
    table.rows.push_back(row);
  }
  table.overall.object = "overall";
  table.overall.title = "Overall";
  for (const TrialResult& result : results) Count(result, table.overall);
  table.overall.detection_rate = MeanOf(table.rows, &Row::detection_rate);
  table.overall.grasp_rate = MeanOf(table.rows, &Row::grasp_rate);
  if (const auto it = published.find("overall"); it != published.end()) {
    table.overall.published_detection_rate = it->second.detection;
    table.overall.published_grasp_rate = it->second.grasp;
  }
  table.pooled_detection_rate = Rate(table.overall.detected, table.overall.trials);
  table.pooled_grasp_rate = Rate(table.overall.delivered, table.overall.detected);
  table.stage_seconds = StageTimes(results);
  table.audit_worst = WorstAudit(results);
  return table;
}

Comparison Compare(const std::vector<TrialResult>& first, const std::vector<TrialResult>& second) {
  std::map<std::string, const TrialResult*> by_id;
  for (const TrialResult& result : first) by_id[result.id] = &result;
  Comparison comparison;
  for (const TrialResult& b : second) {
    const auto it = by_id.find(b.id);
    if (it == by_id.end() || it->second->seed != b.seed) continue;
    const bool first_delivered = it->second->outcome == Outcome::kDelivered;
    const bool second_delivered = b.outcome == Outcome::kDelivered;
    ++comparison.pairs;
    comparison.both += first_delivered && second_delivered ? 1 : 0;
    comparison.only_first += first_delivered && !second_delivered ? 1 : 0;
    comparison.only_second += !first_delivered && second_delivered ? 1 : 0;
    comparison.same_outcome += it->second->outcome == b.outcome ? 1 : 0;
  }
  comparison.p_value = McNemarExact(comparison.only_first, comparison.only_second);
  return comparison;
}

}  // namespace rangegrasp::report
