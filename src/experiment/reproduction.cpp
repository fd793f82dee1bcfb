#include "experiment/reproduction.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/words.h"

namespace rangegrasp::experiment {
namespace {

using nlohmann::ordered_json;

bool IsWhole(const ReproducedTable& table) {
  return table.left_out.empty() && table.done >= table.cases;
}

std::string StateOf(const ReproducedTable& table) {
  if (!table.left_out.empty()) return "left out";
  if (table.done == 0) return "not run yet";
  return IsWhole(table) ? "done" : fmt::format("{} of {} cases", table.done, table.cases);
}

Section SummaryOf(const Reproduction& all) {
  Section section{
      all.is_short ? "Published tables, short run: verdicts are weak" : "Published tables",
      {{"table", "title", "experiment", "state", "trials", "figures", "better", "same", "worse",
        "no figure"},
       {true, true, true, true, false, false, false, false, false, false},
       {},
       false}};
  for (const ReproducedTable& table : all.tables) {
    std::vector<std::string> row = {table.number, table.title, table.experiment, StateOf(table)};
    const bool there = table.done > 0;
    row.push_back(there ? fmt::format("{}", table.done) : "-");
    row.push_back(there ? fmt::format("{}", table.judged.rows.size()) : "-");
    for (const Verdict verdict : base::ValuesOf<Verdict>()) {
      row.push_back(there ? fmt::format("{}", CountOf(table, verdict)) : "-");
    }
    section.grid.rows.push_back(std::move(row));
  }
  return section;
}

std::string VerdictText(const Reproduction& all, const Judged& row) {
  const std::string word(base::Word(row.verdict));
  return all.is_short && row.verdict != Verdict::kNoFigure ? word + " (weak)" : word;
}

std::string Cell(const std::optional<double>& value, int digits) {
  return value ? Fixed(*value, digits) : "-";
}

std::string PText(const std::optional<double>& p) {
  if (!p) return "-";
  return *p < 1e-4 ? "< 0.0001" : Fixed(*p, 4);
}

Section SectionOf(const Reproduction& all, const ReproducedTable& table) {
  Section section{
      fmt::format("Table {}: {} ({})", table.number, table.title, table.experiment),
      {{"row", "published", "reproduced", "unit", "better is", "compared", "p", "verdict"},
       {true, false, false, true, true, true, false, true},
       {},
       false}};
  for (const Judged& row : table.judged.rows) {
    const PublishedFigure& figure = row.figure;
    section.grid.rows.push_back({figure.row, Fixed(figure.published, figure.digits),
                                 Cell(figure.own, figure.digits), figure.unit,
                                 figure.lower_is_better ? "lower" : "higher", row.counts,
                                 PText(row.p), VerdictText(all, row)});
  }
  return section;
}

Grid CsvGridOf(const Reproduction& all) {
  Grid grid;
  grid.header = {"table",      "experiment", "row", "unit",      "lower_is_better", "published",
                 "reproduced", "compared",   "p",   "threshold", "verdict",         "weak"};
  grid.left.assign(grid.header.size(), true);
  for (const ReproducedTable& table : all.tables) {
    for (const Judged& row : table.judged.rows) {
      const PublishedFigure& figure = row.figure;
      grid.rows.push_back(
          {table.number, table.experiment, figure.row, figure.unit,
           figure.lower_is_better ? "1" : "0", fmt::format("{}", figure.published),
           figure.own ? fmt::format("{}", *figure.own) : "", row.counts,
           row.p ? fmt::format("{}", *row.p) : "",
           table.judged.threshold > 0.0 ? fmt::format("{}", table.judged.threshold) : "",
           std::string(base::Word(row.verdict)), all.is_short ? "1" : "0"});
    }
  }
  return grid;
}

template <typename T>
ordered_json Json(const std::optional<T>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json JsonOf(const Judged& row) {
  return {{"row", row.figure.row},
          {"unit", row.figure.unit},
          {"lower_is_better", row.figure.lower_is_better},
          {"published", row.figure.published},
          {"reproduced", Json(row.figure.own)},
          {"compared", row.counts},
          {"p", Json(row.p)},
          {"verdict", base::Word(row.verdict)}};
}

ordered_json JsonOf(const ReproducedTable& table) {
  ordered_json json = {{"table", table.number},          {"title", table.title},
                       {"experiment", table.experiment}, {"state", StateOf(table)},
                       {"left_out", table.left_out},     {"seeds", table.seeds},
                       {"cases", table.cases},           {"done", table.done},
                       {"crashed", table.crashed},       {"p_threshold", table.judged.threshold},
                       {"tests", table.judged.tests},    {"rows", ordered_json::array()}};
  for (const Judged& row : table.judged.rows) json["rows"].push_back(JsonOf(row));
  return json;
}

// What the verdicts rest on, each test with the tables that it is of.
std::vector<std::string> TestNotes(const Reproduction& all) {
  std::vector<std::pair<std::string, std::vector<std::string>>> tests;
  std::vector<std::string> thresholds;
  for (const ReproducedTable& table : all.tables) {
    for (const std::string& test : table.judged.tests) {
      auto found = std::ranges::find(tests, test, [](const auto& one) { return one.first; });
      if (found == tests.end()) found = tests.insert(tests.end(), {test, {}});
      found->second.push_back(table.number);
    }
    if (table.judged.threshold > 0.0) {
      thresholds.push_back(fmt::format("{} in {}", PText(table.judged.threshold), table.number));
    }
  }
  std::vector<std::string> notes;
  for (const auto& [test, numbers] : tests) {
    notes.push_back(fmt::format("{} ({})", test, base::Join(numbers)));
  }
  if (!thresholds.empty()) {
    notes.push_back(
        "a verdict is better or worse where p is below 0.05 over the number of the table's "
        "tests: " +
        base::Join(thresholds));
  }
  return notes;
}

std::vector<std::string> NotesOf(const Reproduction& all) {
  std::vector<std::string> notes = {
      "same: no difference is shown, which is not the same as none: few trials show none"};
  if (all.is_short) {
    notes.emplace_back("weak: of a tenth of the trials; only large differences can show in so few");
  }
  for (const std::string& note : TestNotes(all)) notes.push_back(note);
  for (const ReproducedTable& table : all.tables) {
    if (!table.left_out.empty()) {
      notes.push_back(fmt::format("{} is left out: {}", table.number, table.left_out));
    }
    if (table.crashed > 0) {
      notes.push_back(fmt::format("{}: {} of {} cases crashed or timed out, and count as failures",
                                  table.number, table.crashed, table.done));
    }
  }
  return notes;
}

}  // namespace

int CountOf(const ReproducedTable& table, Verdict verdict) {
  return static_cast<int>(std::ranges::count(table.judged.rows, verdict, &Judged::verdict));
}

Report PageOf(const Reproduction& reproduction) {
  Report page;
  ordered_json json = {{"short", reproduction.is_short}, {"tables", ordered_json::array()}};
  page.sections.push_back(SummaryOf(reproduction));
  for (const ReproducedTable& table : reproduction.tables) {
    if (!table.judged.rows.empty()) page.sections.push_back(SectionOf(reproduction, table));
    json["tables"].push_back(JsonOf(table));
  }
  page.notes = NotesOf(reproduction);
  page.csv = CsvGridOf(reproduction);
  page.json = json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  return page;
}

}  // namespace rangegrasp::experiment
