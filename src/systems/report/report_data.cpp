#include "report/report_data.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "base/version.h"
#include "report/internal/comparison_json.h"
#include "report/internal/grid_json.h"
#include "report/internal/record_charts.h"

namespace rangegrasp::report {
namespace {

using experiment::Chart;
using experiment::Record;
using nlohmann::ordered_json;

// Records that one file holds; the page knows it by data.js.
constexpr std::size_t kBlock = 50;

ordered_json ValueJson(const Chart::Value& value) {
  if (!value.value) return nullptr;
  ordered_json json = {{"value", *value.value}};
  if (value.range) json["range"] = {value.range->first, value.range->second};
  if (!value.of.empty()) json["of"] = value.of;
  return json;
}

ordered_json ChartJson(const Chart& chart) {
  ordered_json json = {{"title", chart.title},           {"unit", chart.unit},
                       {"along", chart.along},           {"note", chart.note},
                       {"stacked", chart.stacked},       {"labels", chart.labels},
                       {"series", ordered_json::array()}};
  for (const auto& series : chart.series) {
    ordered_json values = ordered_json::array();
    for (const Chart::Value& value : series.values) values.push_back(ValueJson(value));
    json["series"].push_back({{"name", series.name}, {"values", values}});
  }
  return json;
}

ordered_json StampJson(const experiment::Stamp& stamp) {
  ordered_json json = ordered_json::array();
  for (const auto* part : {&stamp.identity, &stamp.build}) {
    for (const auto& [name, value] : *part) json.push_back({name, value});
  }
  const auto set = stamp.data.find("set");
  if (set != stamp.data.end() && !set->second.empty()) {
    json.push_back({"set on the command line", set->second});
  }
  return json;
}

ordered_json RunJson(const Run& run) {
  const auto& [stamp, records] = run.results;
  ordered_json json = {{"name", run.name},
                       {"task", run.kind->name},
                       {"success", run.kind->success},
                       {"stamp", StampJson(stamp)},
                       {"tables", ordered_json::array()},
                       {"notes", run.tables.notes},
                       {"charts", ordered_json::array()}};
  for (const auto& section : run.tables.sections) {
    json["tables"].push_back(internal::GridJson(section.title, section.grid));
  }
  if (run.kind->charts) {
    for (const Chart& chart : run.kind->charts(stamp, records)) {
      json["charts"].push_back(ChartJson(chart));
    }
  }
  for (const Chart& chart : internal::RecordCharts(stamp, records, run.kind->success)) {
    json["charts"].push_back(ChartJson(chart));
  }
  const auto text = stamp.data.find("experiment_text");
  json["experiment"] = text == stamp.data.end() ? "" : text->second;
  return json;
}

// What the list shows and filters by.
ordered_json CaseJson(std::size_t run, const Run& of, const Record& record, bool view) {
  const auto& [which, result] = record;
  double seconds = 0.0;
  if (!result.seconds.empty()) seconds = result.seconds.back().second;  // the whole case
  return {run,          which.id,      TitleOf(of.results.stamp, which.group), result.outcome,
          result.stage, result.detail, std::round(1e3 * seconds) / 1e3,        view ? 1 : 0};
}

std::string Script(const std::string& name, const ordered_json& value) {
  return fmt::format("{}={};\n", name,
                     value.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
}

void WriteRecords(const std::vector<const Record*>& records, const std::filesystem::path& folder) {
  for (std::size_t begin = 0; begin < records.size(); begin += kBlock) {
    ordered_json block = ordered_json::array();
    for (std::size_t i = begin; i < std::min(begin + kBlock, records.size()); ++i) {
      auto json = ordered_json::parse(experiment::ToJson(*records[i]));
      json["seed"] = fmt::format("{}", records[i]->which.seed);  // a script's numbers have 53 bits
      block.push_back(std::move(json));
    }
    const std::size_t number = begin / kBlock;
    base::WriteFile(folder / "records" / fmt::format("{}.js", number),
                    Script(fmt::format("rangegrasp.records[{}]", number), block));
  }
}

}  // namespace

void WriteData(const std::vector<Run>& runs, const std::set<std::size_t>& views,
               const std::string& note, const std::filesystem::path& folder) {
  ordered_json json = {{"version", base::Version()},
                       {"block", kBlock},
                       {"viewNote", note},
                       {"runs", ordered_json::array()},
                       {"comparisons", ordered_json::array()},
                       {"cases", ordered_json::array()}};
  std::vector<const Record*> records;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Run& run = runs[i];
    json["runs"].push_back(RunJson(run));
    if (i > 0 && !run.kind->success.empty()) {
      json["comparisons"].push_back(internal::ComparisonJson(runs.front(), 0, run, records.size()));
    }
    for (const Record& record : run.results.records) {
      json["cases"].push_back(CaseJson(i, run, record, views.contains(records.size())));
      records.push_back(&record);
    }
  }
  WriteRecords(records, folder);
  base::WriteFile(folder / "data.js", Script("rangegrasp.data", json));
}

}  // namespace rangegrasp::report
