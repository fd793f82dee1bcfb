#include "report/internal/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>

#include "base/error.h"
#include "base/file.h"
#include "base/installation.h"
#include "experiment/statistics.h"
#include "page_files.h"
#include "report/internal/view_file.h"

namespace rangegrasp::report {
namespace {

namespace fs = std::filesystem;
using experiment::Chart;
using experiment::Record;
using experiment::ValueOr;
using nlohmann::ordered_json;
using Records = std::vector<Record>;

// Files that mark a folder as a report's, and as a failed or unfinished report's: it can be redone.
constexpr const char* kData = "data.js";
constexpr const char* kUnfinished = "report.unfinished";

struct Library {
  const char* package;  // Debian package
  const char* file;
  const char* name;  // name in the report
};
// Both are plain scripts, since a page opened from disk may not load modules.
constexpr std::array kLibraries = {
    Library{"libjs-chart.js", "/usr/share/javascript/chart.js/chart.min.js", "chart.min.js"},
    Library{"libjs-chart.js", "/usr/share/doc/libjs-chart.js/copyright", "chart.copyright.txt"},
    Library{"libjs-three", "/usr/share/javascript/three/three.min.js", "three.min.js"},
    Library{"libjs-three", "/usr/share/javascript/three/examples/js/controls/OrbitControls.js",
            "OrbitControls.js"},
    Library{"libjs-three", "/usr/share/doc/libjs-three/copyright", "three.copyright.txt"}};

// A table as the page reads it: every cell as printed.
ordered_json TableJson(const experiment::Section& table) {
  return {{"title", table.title},
          {"header", table.grid.header},
          {"left", table.grid.left},
          {"rows", table.grid.rows},
          {"total", table.grid.total}};
}

// Number of cases by label, in the order in which labels first occur, and by outcome.
// @param left_out  an outcome that is not counted; may be empty
Chart OutcomeChart(const Records& records, const std::string& left_out, const std::string& title,
                   const std::string& along,
                   const std::function<std::string(const Record&)>& label_of) {
  Chart chart{.title = title, .unit = "cases", .along = along, .stacked = true};
  using Positions = std::vector<std::size_t>;
  std::map<std::string, std::map<std::string, Positions>> cases;  // by outcome, then label
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (records[i].result.outcome == left_out) continue;
    const std::string label = label_of(records[i]);
    if (std::ranges::find(chart.labels, label) == chart.labels.end()) chart.labels.push_back(label);
    cases[records[i].result.outcome][label].push_back(i);
  }
  for (auto& [outcome, by_label] : cases) {
    auto& series = chart.series.emplace_back();
    series.name = outcome;
    for (const std::string& label : chart.labels) {
      const Positions& some = by_label[label];
      series.values.push_back({.value = static_cast<double>(some.size()), .cases = some});
    }
  }
  return chart;
}

Chart TimesChart(const Records& records) {
  Chart chart{.title = "Time of each stage",
              .unit = "s",
              .along = "stage",
              .note = "The mark is the median; the line ends at the 95 % quantile.",
              .series = {{"median", {}}}};
  for (const auto& time : experiment::StageTimes(records)) {
    if (time.stage.find(':') != std::string::npos) continue;  // a step within a stage
    chart.labels.push_back(time.stage);
    chart.series.front().values.push_back(
        {time.median_s, std::pair(time.median_s, time.p95_s), ""});
  }
  return chart;
}

// Charts for any kind of experiment: outcomes by group, failures by the stage in which they ended,
// and the duration of stages.
std::vector<Chart> RecordCharts(const experiment::Stamp& stamp, const Records& records,
                                const std::string& success) {
  std::vector<Chart> charts = {
      OutcomeChart(records, success, success.empty() ? "Outcomes by group" : "Failures by group",
                   "group",
                   [&](const Record& record) { return TitleOf(stamp, record.which.group); }),
      TimesChart(records)};
  if (!success.empty()) {
    charts.insert(charts.begin(),
                  OutcomeChart(records, success, "Failures by stage", "stage",
                               [](const Record& record) { return record.result.stage; }));
  }
  std::erase_if(charts, [](const Chart& chart) { return chart.labels.empty(); });
  return charts;
}

/// Paired comparison of two runs in a group.
struct ComparedGroup {
  std::string name;
  experiment::Comparison pairs;
};

experiment::Grid ComparisonGrid(const std::vector<ComparedGroup>& groups,
                                const std::string& success) {
  using experiment::Comparison;
  const auto column = [](const std::string& title, auto member, const char* format = "") {
    return experiment::Column<ComparedGroup>(
        title, format, [member](const ComparedGroup& group) { return group.pairs.*member; });
  };
  return experiment::GridOf<ComparedGroup>({{"group", "", &ComparedGroup::name, experiment::kLeft},
                                            column("pairs", &Comparison::pairs),
                                            column(success + " by both", &Comparison::both),
                                            column("only by the first", &Comparison::only_first),
                                            column("only by the second", &Comparison::only_second),
                                            column("same outcome", &Comparison::same_outcome),
                                            column("McNemar exact p", &Comparison::p_value, ".3g")},
                                           groups);
}

Records OfGroup(const Records& records, const std::string& group) {
  Records chosen;
  std::ranges::copy_if(records, std::back_inserter(chosen),
                       [&](const Record& record) { return record.which.group == group; });
  return chosen;
}

// Two runs paired by id and seed: a table with a row for each group, and the numbers of the cases
// whose success differs.
// @param first  the report's first run
// @param second_number  number of the other run's first case
ordered_json ComparisonJson(const Run& first, const Run& second, std::size_t second_number) {
  const std::string success = first.Success();
  const Records& one = first.results.records;
  const Records& two = second.results.records;
  std::vector<ComparedGroup> groups;
  for (const std::string& group : GroupsOf(one)) {
    groups.push_back({TitleOf(first.results.stamp, group),
                      experiment::Compare(OfGroup(one, group), OfGroup(two, group), success)});
  }
  groups.push_back({"All", experiment::Compare(one, two, success)});
  std::erase_if(groups, [](const ComparedGroup& group) { return group.pairs.pairs == 0; });
  experiment::Grid grid = ComparisonGrid(groups, success);
  grid.total = grid.rows.size() > 1;
  const auto numbers = [&](const auto& pair) -> ordered_json {
    return {pair.first, second_number + pair.second};
  };
  return {{"first", first.name},
          {"second", second.name},
          {"success", success},
          {"table", TableJson({"", grid})},
          {"differing", ListOf(experiment::Differing(one, two, success), numbers)}};
}

// Number of records in one file; the page reads it from data.js.
constexpr std::size_t kBlock = 50;

// @param first  number of the run's first case
ordered_json ValueJson(const Chart::Value& value, std::size_t first) {
  if (!value.value) return nullptr;
  ordered_json json = {{"value", *value.value}};
  if (value.range) json["range"] = {value.range->first, value.range->second};
  if (!value.of.empty()) json["of"] = value.of;
  if (!value.cases.empty()) {
    json["cases"] = ListOf(value.cases, [&](std::size_t position) { return first + position; });
  }
  return json;
}

ordered_json ChartJson(const Chart& chart, std::size_t first) {
  const auto value_json = [&](const Chart::Value& value) { return ValueJson(value, first); };
  const auto series = [&](const Chart::Series& one) -> ordered_json {
    return {{"name", one.name}, {"values", ListOf(one.values, value_json)}};
  };
  return {{"title", chart.title},
          {"unit", chart.unit},
          {"along", chart.along},
          {"note", chart.note},
          {"stacked", chart.stacked},
          {"labels", chart.labels},
          {"series", ListOf(chart.series, series)}};
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

// Folders with the number of each one's first case: what `trial` needs to run a case again.
ordered_json StoresJson(const Run& run, std::size_t first) {
  ordered_json json = ordered_json::array();
  for (const auto& [folder, count] : run.stores) {
    json.push_back({first, folder.string()});
    first += count;
  }
  return json;
}

ordered_json RunJson(const Run& run, std::size_t first) {
  const experiment::Stamp& stamp = run.results.stamp;
  const Records& records = run.results.records;
  std::vector<Chart> charts;
  if (run.kind->charts) charts = run.kind->charts(stamp, records);
  const std::string success = run.Success();
  std::ranges::move(RecordCharts(stamp, records, success), std::back_inserter(charts));
  return {{"name", run.name},
          {"task", run.kind->name},
          {"success", success},
          {"stamp", StampJson(stamp)},
          {"tables", ListOf(run.tables.sections, TableJson)},
          {"notes", run.tables.notes},
          {"charts", ListOf(charts, [&](const Chart& chart) { return ChartJson(chart, first); })},
          {"stores", StoresJson(run, first)},
          {"experiment", ValueOr(stamp.data, "experiment_text", "")}};
}

// What the list of cases shows and filters by.
ordered_json CaseJson(std::size_t run, const Run& of, const Record& record, bool view) {
  const auto& [which, result] = record;
  double seconds = 0.0;
  if (!result.seconds.empty()) seconds = result.seconds.back().second;  // the whole case
  return {run,          which.id,      TitleOf(of.results.stamp, which.group), result.outcome,
          result.stage, result.detail, std::round(1e3 * seconds) / 1e3,        view ? 1 : 0};
}

void WriteRecords(const std::vector<const Record*>& records, const fs::path& folder) {
  for (std::size_t begin = 0; begin < records.size(); begin += kBlock) {
    ordered_json block = ordered_json::array();
    for (std::size_t i = begin; i < std::min(begin + kBlock, records.size()); ++i) {
      auto json = ordered_json::parse(experiment::ToJson(*records[i]));
      json["seed"] = fmt::format("{}", records[i]->which.seed);  // JavaScript numbers have 53 bits
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

void PrepareFolder(const fs::path& folder) {
  for (const Library& library : kLibraries) {
    if (fs::exists(library.file)) continue;
    throw base::InputError(std::string(library.file) + ": is missing, but a report needs it; " +
                           "install the Debian package " + library.package);
  }
  std::error_code error;
  bool is_report = false, is_empty = true;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    is_report = is_report || name == kData || name.starts_with(kUnfinished);
    is_empty = is_empty && name == experiment::FolderLock::kFile;
  }
  if (fs::exists(folder) && !is_report && (!fs::is_directory(folder) || !is_empty)) {
    throw base::InputError(
        folder.string() +
        ": contains files that are not of a report; choose another folder with --out");
  }
  base::WriteFile(folder / kUnfinished, "");
  for (const char* part : {kData, "views", "meshes", "records"}) {
    fs::remove_all(folder / part, error);
  }
}

void WritePage(const fs::path& folder) {
  for (const Library& library : kLibraries) {
    base::WriteFile(folder / "lib" / library.name, base::ReadFile(library.file));
  }
  for (const auto& [name, text] : internal::kPageFiles) base::WriteFile(folder / name, text);
}

void WriteData(const std::vector<Run>& runs, const std::set<std::size_t>& views,
               const std::string& note, const fs::path& folder) {
  ordered_json json = {{"version", base::Version()},
                       {"block", kBlock},
                       {"viewNote", note},
                       {"runs", ordered_json::array()},
                       {"comparisons", ordered_json::array()},
                       {"cases", ordered_json::array()}};
  std::vector<const Record*> records;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Run& run = runs[i];
    json["runs"].push_back(RunJson(run, records.size()));
    if (i > 0 && !run.Success().empty() && run.Success() == runs.front().Success()) {
      json["comparisons"].push_back(ComparisonJson(runs.front(), run, records.size()));
    }
    for (const Record& record : run.results.records) {
      json["cases"].push_back(CaseJson(i, run, record, views.contains(records.size())));
      records.push_back(&record);
    }
  }
  WriteRecords(records, folder);
  base::WriteFile(folder / kData, Script("rangegrasp.data", json));
  std::error_code ignored;
  fs::remove(folder / kUnfinished, ignored);
}

std::vector<std::size_t> ChooseViews(const std::vector<experiment::Record>& records,
                                     const std::string& success, ViewChoice choice) {
  std::vector<std::size_t> chosen(records.size());
  std::iota(chosen.begin(), chosen.end(), std::size_t{0});
  if (choice == ViewChoice::kAll) return chosen;
  if (choice == ViewChoice::kNone) return {};
  // Successes come after all others.
  const auto others = std::stable_partition(chosen.begin(), chosen.end(), [&](std::size_t i) {
    return !success.empty() && records[i].result.outcome != success;
  });
  auto some = Spread({chosen.begin(), others}, kFailuresShown);
  const auto successes = Spread({others, chosen.end()}, kSuccessesShown);
  some.insert(some.end(), successes.begin(), successes.end());
  std::ranges::sort(some);
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
