#include "report/internal/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "base/error.h"
#include "base/file.h"
#include "base/installation.h"
#include "experiment/statistics.h"
#include "page_files.h"

namespace rangegrasp::report {
namespace {

using experiment::Chart;
using experiment::Record;
using experiment::ValueOr;
using nlohmann::ordered_json;
using Records = std::vector<Record>;

// What marks a folder as a report's.
constexpr const char* kData = "data.js";

struct Library {
  const char* package;  // of Debian
  const char* file;
  const char* name;  // in the report
};
// Both are plain scripts: a page that is opened from disk may not load modules.
constexpr std::array kLibraries = {
    Library{"libjs-chart.js", "/usr/share/javascript/chart.js/chart.min.js", "chart.min.js"},
    Library{"libjs-chart.js", "/usr/share/doc/libjs-chart.js/copyright", "chart.copyright.txt"},
    Library{"libjs-three", "/usr/share/javascript/three/three.min.js", "three.min.js"},
    Library{"libjs-three", "/usr/share/javascript/three/examples/js/controls/OrbitControls.js",
            "OrbitControls.js"},
    Library{"libjs-three", "/usr/share/doc/libjs-three/copyright", "three.copyright.txt"}};

// A table as the page reads it: every cell as it is printed.
ordered_json GridJson(const std::string& title, const experiment::Grid& grid) {
  return {{"title", title},
          {"header", grid.header},
          {"left", grid.left},
          {"rows", grid.rows},
          {"total", grid.total}};
}

// Cases by label and outcome, both in the order in which they first occur.
Chart OutcomeChart(const Records& records, const std::string& title, const std::string& along,
                   const std::function<std::string(const Record&)>& label_of) {
  Chart chart;
  chart.title = title;
  chart.unit = "cases";
  chart.along = along;
  chart.stacked = true;
  std::map<std::string, std::map<std::string, int>> counts;  // by outcome, then label
  for (const Record& record : records) {
    const std::string label = label_of(record);
    if (std::ranges::find(chart.labels, label) == chart.labels.end()) chart.labels.push_back(label);
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

Chart TimesChart(const Records& records) {
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

// Charts of any kind of experiment: outcomes by group, failures by the stage that they ended in,
// and how long stages took.
std::vector<Chart> RecordCharts(const experiment::Stamp& stamp, const Records& records,
                                const std::string& success) {
  Records failed = records;
  std::erase_if(failed, [&](const Record& record) { return record.result.outcome == success; });
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
  std::ranges::copy_if(records, std::back_inserter(chosen),
                       [&](const Record& record) { return record.which.group == group; });
  return chosen;
}

// Two runs in pairs of the same id and seed: a table with a row for each group, and the numbers of
// the cases whose success differs.
// @param first_number, second_number  of the runs' first cases
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
  for (const std::string& group : GroupsOf(one)) {
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
  const std::string set = ValueOr(stamp.data, "set", "");
  if (!set.empty()) json.push_back({"set on the command line", set});
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
    json["tables"].push_back(GridJson(section.title, section.grid));
  }
  if (run.kind->charts) {
    for (const Chart& chart : run.kind->charts(stamp, records)) {
      json["charts"].push_back(ChartJson(chart));
    }
  }
  for (const Chart& chart : RecordCharts(stamp, records, run.kind->success)) {
    json["charts"].push_back(ChartJson(chart));
  }
  json["experiment"] = ValueOr(stamp.data, "experiment_text", "");
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

std::vector<std::size_t> Spread(const std::vector<std::size_t>& all, std::size_t max) {
  std::vector<std::size_t> some;
  const std::size_t count = std::min(max, all.size());
  for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  return some;
}

}  // namespace

void PrepareFolder(const std::filesystem::path& folder) {
  for (const Library& library : kLibraries) {
    if (std::filesystem::exists(library.file)) continue;
    throw base::InputError(std::string(library.file) + ": is not there, but a report needs it; " +
                           "install the Debian package " + library.package);
  }
  std::error_code error;
  const bool is_report = std::filesystem::exists(folder / kData);
  if (std::filesystem::exists(folder) && !is_report &&
      (!std::filesystem::is_directory(folder) || !std::filesystem::is_empty(folder, error))) {
    throw base::InputError(folder.string() +
                           ": holds something that is no report; --out names another folder");
  }
  for (const char* part : {"views", "meshes", "records"}) {
    std::filesystem::remove_all(folder / part, error);
  }
}

void WritePage(const std::filesystem::path& folder) {
  for (const Library& library : kLibraries) {
    base::WriteFile(folder / "lib" / library.name, base::ReadFile(library.file));
  }
  base::WriteFile(folder / "plots.js", internal::kPlotsJs);
  base::WriteFile(folder / "report.css", internal::kReportCss);
  base::WriteFile(folder / "report.js", internal::kReportJs);
  base::WriteFile(folder / "view.js", internal::kViewJs);
  base::WriteFile(folder / "index.html", internal::kIndexHtml);
}

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
      json["comparisons"].push_back(ComparisonJson(runs.front(), 0, run, records.size()));
    }
    for (const Record& record : run.results.records) {
      json["cases"].push_back(CaseJson(i, run, record, views.contains(records.size())));
      records.push_back(&record);
    }
  }
  WriteRecords(records, folder);
  base::WriteFile(folder / "data.js", Script("rangegrasp.data", json));
}

std::vector<std::size_t> ChooseViews(const std::vector<experiment::Record>& records,
                                     const std::string& success, ViewChoice choice) {
  std::vector<std::size_t> chosen(records.size());
  std::iota(chosen.begin(), chosen.end(), std::size_t{0});
  if (choice == ViewChoice::kAll) return chosen;
  if (choice == ViewChoice::kNone) return {};
  // Successes behind all others.
  const auto others = std::stable_partition(chosen.begin(), chosen.end(), [&](std::size_t i) {
    return !success.empty() && records[i].result.outcome != success;
  });
  auto some = Spread({chosen.begin(), others}, kFailuresShown);
  const auto successes = Spread({others, chosen.end()}, kSuccessesShown);
  some.insert(some.end(), successes.begin(), successes.end());
  std::sort(some.begin(), some.end());
  return some;
}

std::vector<std::size_t> Fitting(const std::vector<std::uintmax_t>& sizes,
                                 std::uintmax_t max_bytes) {
  std::vector<std::size_t> all(sizes.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  for (std::size_t count = all.size(); count > 0; --count) {
    const auto kept = Spread(all, count);
    std::uintmax_t sum = 0;
    for (const std::size_t i : kept) sum += sizes[i];
    if (sum <= max_bytes) return kept;
  }
  return {};
}

}  // namespace rangegrasp::report
