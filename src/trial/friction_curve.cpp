#include "trial/friction_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

namespace rangegrasp::trial {
namespace {

// A coefficient that is a bin's end belongs to the bin above, whatever its last bit is.
constexpr double kRounding = 1e-9;

const std::map<int, FrictionBin>& BinsOf(const FrictionCurve& curve, const std::string& object) {
  static const std::map<int, FrictionBin> none;
  const auto found = curve.find(object);
  return found == curve.end() ? none : found->second;
}

void AddRow(const std::string& name, const std::map<int, FrictionBin>& bins,
            const std::set<int>& columns, experiment::Grid& grid) {
  std::vector<std::string> row{name};
  for (const int column : columns) {
    const auto bin = bins.find(column);
    row.push_back(bin == bins.end()
                      ? "-"
                      : fmt::format("{}/{}", bin->second.delivered, bin->second.detected));
  }
  grid.rows.push_back(std::move(row));
}

}  // namespace

FrictionCurve FrictionCurveOf(const std::vector<experiment::Record>& records) {
  FrictionCurve curve;
  for (const experiment::Record& record : records) {
    const auto data = nlohmann::json::parse(record.result.data, nullptr, false);
    if (!data.is_object() || !data.value("detected", false)) continue;
    const auto friction = data.find("friction");
    if (friction == data.end() || !friction->is_number()) continue;
    const int bin =
        static_cast<int>(std::floor(friction->get<double>() / kFrictionBin + kRounding));
    FrictionBin& counts = curve[record.which.group][bin];
    ++counts.detected;
    counts.delivered += record.result.outcome == "delivered" ? 1 : 0;
  }
  return curve;
}

experiment::Grid GridOf(const FrictionCurve& curve, const std::vector<std::string>& objects) {
  experiment::Grid grid;
  if (std::all_of(curve.begin(), curve.end(),
                  [](const auto& object) { return object.second.size() < 2; })) {
    return grid;
  }
  std::set<int> columns;
  std::map<int, FrictionBin> all;
  for (const auto& [object, bins] : curve) {
    for (const auto& [column, bin] : bins) {
      columns.insert(column);
      all[column].detected += bin.detected;
      all[column].delivered += bin.delivered;
    }
  }
  grid.header = {"static friction from"};
  for (const int column : columns)
    grid.header.push_back(fmt::format("{:.2f}", column * kFrictionBin));
  grid.left.assign(grid.header.size(), false);
  grid.left[0] = true;
  grid.total = true;
  for (const std::string& object : objects) AddRow(object, BinsOf(curve, object), columns, grid);
  AddRow("all", all, columns, grid);
  return grid;
}

nlohmann::ordered_json JsonOf(const FrictionCurve& curve, const std::vector<std::string>& objects) {
  auto json = nlohmann::ordered_json::array();
  for (const std::string& object : objects) {
    auto bins = nlohmann::ordered_json::array();
    for (const auto& [column, bin] : BinsOf(curve, object)) {
      bins.push_back({{"low", column * kFrictionBin},
                      {"high", (column + 1) * kFrictionBin},
                      {"detected", bin.detected},
                      {"delivered", bin.delivered}});
    }
    json.push_back({{"object", object}, {"bins", bins}});
  }
  return json;
}

}  // namespace rangegrasp::trial
