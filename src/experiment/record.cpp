#include "experiment/record.h"

#include <nlohmann/json.hpp>
#include <tuple>
#include <unordered_map>

#include "base/error.h"

namespace rangegrasp::experiment {

using nlohmann::ordered_json;

std::string ToJson(const Record& record) {
  const auto& [which, result] = record;
  try {
    ordered_json json = {{"id", which.id},
                         {"group", which.group},
                         {"seed", which.seed},
                         {"params", ordered_json::parse(which.params)},
                         {"outcome", result.outcome},
                         {"stage", result.stage},
                         {"detail", result.detail},
                         {"data", ordered_json::parse(result.data)},
                         {"seconds", ordered_json::object()}};
    for (const auto& [stage, seconds] : result.seconds) json["seconds"][stage] = seconds;
    return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  } catch (const ordered_json::parse_error& e) {
    throw base::RunError("case " + which.id + ": its record is damaged: " + e.what());
  }
}

namespace {

// Text as it is, nothing for null, a list as JSON.
std::string CellOf(const ordered_json& value) {
  if (value.is_null()) return "";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

void Flatten(const ordered_json& value, const std::string& name,
             std::vector<std::pair<std::string, std::string>>& cells) {
  if (!value.is_object()) {
    cells.emplace_back(name, CellOf(value));
    return;
  }
  for (const auto& [key, inner] : value.items()) {
    Flatten(inner, name.empty() ? key : name + "." + key, cells);
  }
}

}  // namespace

Grid FlatGridOf(const std::vector<Record>& records) {
  Grid grid;
  std::unordered_map<std::string, std::size_t> column_of;
  for (const Record& record : records) {
    std::vector<std::pair<std::string, std::string>> cells;
    Flatten(ordered_json::parse(ToJson(record)), "", cells);
    auto& row = grid.rows.emplace_back(grid.header.size());
    for (auto& [name, cell] : cells) {
      const auto [column, fresh] = column_of.try_emplace(name, grid.header.size());
      if (fresh) {
        grid.header.push_back(name);
        row.emplace_back();
      }
      row[column->second] = std::move(cell);
    }
  }
  for (auto& row : grid.rows) row.resize(grid.header.size());
  grid.left.assign(grid.header.size(), true);
  return grid;
}

bool SameButTimes(const Record& a, const Record& b) {
  const auto all = [](const Record& r) {
    return std::tie(r.which.id, r.which.group, r.which.seed, r.which.params, r.result.outcome,
                    r.result.stage, r.result.detail, r.result.data);
  };
  return all(a) == all(b);
}

}  // namespace rangegrasp::experiment
