#include "report/internal/comparison_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "experiment/compare.h"
#include "report/internal/grid_json.h"

namespace rangegrasp::report::internal {
namespace {

using experiment::Record;
using nlohmann::ordered_json;
using Records = std::vector<Record>;

void AddRow(const std::string& name, const Records& first, const Records& second,
            const std::string& success, experiment::Grid& grid) {
  const auto c = experiment::Compare(first, second, success);
  if (c.pairs == 0) return;
  const auto text = [](int n) { return fmt::format("{}", n); };
  grid.rows.push_back({name, text(c.pairs), text(c.both), text(c.only_first), text(c.only_second),
                       text(c.same_outcome), fmt::format("{:.3g}", c.p_value)});
}

Records OfGroup(const Records& records, const std::string& group) {
  Records chosen;
  std::copy_if(records.begin(), records.end(), std::back_inserter(chosen),
               [&](const Record& record) { return record.which.group == group; });
  return chosen;
}

}  // namespace

ordered_json ComparisonJson(const Run& first, std::size_t first_number, const Run& second,
                            std::size_t second_number) {
  const std::string& success = first.kind->success;
  const Records& one = first.results.records;
  const Records& two = second.results.records;
  experiment::Grid grid;
  grid.header = {"group",
                 "pairs",
                 success + " by both",
                 "only by the first",
                 "only by the second",
                 "same outcome",
                 "McNemar exact p"};
  grid.left.assign(grid.header.size(), false);
  grid.left.front() = true;
  std::vector<std::string> groups;
  for (const Record& record : one) {
    const std::string& group = record.which.group;
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
  }
  for (const std::string& group : groups) {
    AddRow(TitleOf(first.results.stamp, group), OfGroup(one, group), OfGroup(two, group), success,
           grid);
  }
  AddRow("All", one, two, success, grid);
  grid.total = grid.rows.size() > 1;
  ordered_json differing = ordered_json::array();
  for (const auto& [a, b] : experiment::Differing(one, two, success)) {
    differing.push_back({first_number + a, second_number + b});
  }
  return {{"first", first.name},
          {"second", second.name},
          {"success", success},
          {"table", GridJson("", grid)},
          {"differing", differing}};
}

}  // namespace rangegrasp::report::internal
