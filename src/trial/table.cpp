#include "trial/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>

#include "base/units.h"
#include "base/words.h"
#include "trial/judge.h"

namespace rangegrasp::trial {
namespace {

using experiment::Chart;
using experiment::Column;
using experiment::Count;
using experiment::Fixed;
using experiment::Grid;
using experiment::IntervalText;
using experiment::PercentOf;
using experiment::Record;
using experiment::Stamp;
using nlohmann::ordered_json;
using Data = nlohmann::json;  // of a record
using Rate = std::optional<double>;
using Interval = std::optional<std::pair<double, double>>;

// ---- counts and rates ----

struct Published {
  Rate detection, grasping;
  int trials = 0;
};

// Significance level of all rows' comparisons of one kind of rate (detection or grasping).
constexpr double kSignificance = 0.05;
// Maximum for a published row: a larger number is a mistake in the file.
constexpr double kMaxTrials = 1e6;

// A rate, read in per cent; nullopt if the cell is empty.
Rate PublishedRate(const base::CsvTable& csv, std::size_t row, const char* name) {
  const std::size_t column = csv.Column(name);
  const Rate percent = csv.OptionalNumber(row, column);
  if (!percent) return std::nullopt;
  if (!(*percent >= 0.0 && *percent <= 100.0)) {
    csv.Fail(row, column, "must be a rate from 0 to 100 per cent");
  }
  return *percent / 100.0;
}

// Number of trials of a row; 0 if the table does not state it.
int PublishedTrials(const base::CsvTable& csv, std::size_t row) {
  if (std::ranges::find(csv.header(), "trials") == csv.header().end()) return 0;
  const std::size_t column = csv.Column("trials");
  const auto trials = csv.OptionalNumber(row, column);
  if (!trials) return 0;
  if (!(*trials >= 1.0 && *trials == std::floor(*trials) && *trials <= kMaxTrials)) {
    csv.Fail(row, column, "must be a whole number of trials, 1 or more");
  }
  return static_cast<int>(*trials);
}

// Published rows by title, and "overall".
std::map<std::string, Published> PublishedIn(const Stamp& stamp) {
  std::map<std::string, Published> published;
  const auto csv = experiment::ReferenceOf(stamp);
  for (std::size_t row = 0; csv && row < csv->rows(); ++row) {
    const bool overall = csv->Cell(row, csv->Column("object")) == "overall";
    published[overall ? "overall" : csv->Cell(row, csv->Column("name"))] = {
        PublishedRate(*csv, row, "detection_rate"), PublishedRate(*csv, row, "grasping_rate"),
        PublishedTrials(*csv, row)};
  }
  return published;
}

// A row's rates with their names in CSV and JSON.
constexpr std::array<std::pair<std::string_view, RowRate Row::*>, 4> kRates = {
    {{"detection", &Row::detection},
     {"grasp", &Row::grasping},
     {"text_detection", &Row::text_detection},
     {"text_grasp", &Row::text_grasping}}};

void Add(bool success, Count& count) {
  ++count.n;
  count.k += success ? 1 : 0;
}

Data DataOf(const Record& record) {
  auto data = Data::parse(record.result.data, nullptr, false);
  return data.is_object() ? data : Data::object();
}

const std::string kDelivered(base::Word(Outcome::kDelivered));

void CountTrial(bool detected, bool delivered, RowRate& detection, RowRate& grasping) {
  Add(detected, detection.count);
  if (detected) Add(delivered, grasping.count);
}

bool HasDigit(const std::string& word) {
  return std::ranges::any_of(word, [](unsigned char c) { return std::isdigit(c) != 0; });
}

bool HasLetter(const std::string& word) {
  return std::ranges::any_of(word, [](unsigned char c) { return std::isalpha(c) != 0; });
}

// A record's reason, short enough for a table: the first line (of a traceback, whose lines
// process::LastWords joined by " | ", the last) up to ';'. Only the first of several counted
// reasons ("no_ik x3, no_carry x1") is kept. Dots mark a reason that is longer.
std::string ShortReason(std::string detail) {
  constexpr std::size_t kMaxLength = 60;  // of a table cell
  constexpr std::string_view kLines = " | ";
  const std::size_t last = detail.rfind(kLines);
  if (last != std::string::npos && (detail.starts_with("Traceback") || detail.starts_with("..."))) {
    detail.erase(0, last + kLines.size());
  }
  std::string reason;
  for (const std::string& word : base::Split(detail.substr(0, detail.find_first_of(";\n")), ' ')) {
    if (word.starts_with('x') && HasDigit(word)) break;
    if (word.empty() || !base::IsUtf8(word)) continue;
    if (reason.size() + word.size() > kMaxLength) return reason + " ...";
    reason += (reason.empty() ? "" : " ") + word;
  }
  return reason;
}

// A short reason without its numbers, for counting: without words that have no letter, or a digit
// and no underscore (as in "penetration_p95_m").
std::string ReasonWithoutFigures(const std::string& short_reason) {
  std::string reason;
  for (const std::string& word : base::Split(short_reason, ' ')) {
    const bool is_figure = HasDigit(word) && word.find('_') == std::string::npos;
    const bool is_code = reason.ends_with("code");  // "ended with code 1"
    if (!is_code && (is_figure || !HasLetter(word))) continue;
    reason += (reason.empty() ? "" : " ") + word;
  }
  return reason;
}

// "approach_blocked (no straight path)" is an approach_blocked, "detect() failed" is whole.
std::string WithoutParentheses(const std::string& reason) {
  return reason.substr(0, reason.find(" ("));
}

// Counts a reason together with those that differ in numbers or in what is in parentheses.
void CountReason(const std::string& outcome, const std::string& reason, Row& row) {
  const std::string counted = ReasonWithoutFigures(WithoutParentheses(reason));
  if (counted.empty()) return;
  Reason& of = row.reasons[outcome].try_emplace(counted, Reason{0, reason}).first->second;
  ++of.count;
  // What is in parentheses is not the reason of those that state something else there.
  if (ReasonWithoutFigures(of.example) != ReasonWithoutFigures(reason)) {
    of.example = WithoutParentheses(of.example);
  }
}

void CountRecord(const Record& record, const Data& data, Row& row) {
  const std::string& outcome = record.result.outcome;
  ++row.outcomes[outcome];
  CountReason(outcome, ShortReason(record.result.detail), row);
  CountTrial(data.value("detected", false), outcome == kDelivered, row.detection, row.grasping);
  // A record of an older version has no "text"; a trial that crashed has no data at all.
  const auto text = data.find("text");
  if (text == data.end() && !data.empty()) return;
  CountTrial(text != data.end() && text->value("detected", false),
             text != data.end() && text->value("outcome", "") == kDelivered, row.text_detection,
             row.text_grasping);
}

Rate RateOf(const Count& count) {
  if (count.n == 0) return std::nullopt;
  return static_cast<double>(count.k) / count.n;
}

Interval IntervalOf(const Count& count) {
  if (count.n == 0) return std::nullopt;
  return experiment::WilsonInterval(count.k, count.n);
}

// The mean over the rows that have the rate: the dissertation's "overall".
void SetMean(const std::vector<Row>& rows, RowRate Row::*of, Row& overall) {
  std::vector<double> rates;
  std::vector<Count> counts;
  for (const Row& row : rows) {
    if ((row.*of).rate) rates.push_back(*(row.*of).rate);
    counts.push_back((row.*of).count);
  }
  (overall.*of).rate = experiment::MeanOf(rates).mean;
  (overall.*of).interval = experiment::MeanRateInterval(counts);
}

Count PublishedCount(double rate, int trials) {
  return {static_cast<int>(std::lround(rate * trials)), trials};
}

void AddPublished(const std::map<std::string, Published>& published, const std::string& name,
                  Row& row) {
  const auto found = published.find(name);
  if (found == published.end()) return;
  const auto& [detection, grasping, trials] = found->second;
  row.text_detection.published = detection;
  row.text_grasping.published = grasping;
  row.text_detection.published_count.n = trials;
  if (trials == 0 || !detection || !grasping) return;
  // The counts are whole numbers: 77.77 % of 9 detected objects are 7.
  row.text_detection.published_count = PublishedCount(*detection, trials);
  row.text_grasping.published_count =
      PublishedCount(*grasping, row.text_detection.published_count.k);
}

// The published overall row covers all published rows. A run of only some of them is not compared
// with it.
bool HasAllRows(const std::map<std::string, Published>& published, const std::vector<Row>& rows) {
  return std::ranges::all_of(published, [&](const auto& one) {
    return one.first == "overall" || std::ranges::find(rows, one.first, &Row::title) != rows.end();
  });
}

void Compare(Row& row) {
  for (RowRate* rate : {&row.text_detection, &row.text_grasping}) {
    const Count& own = rate->count;
    const Count& published = rate->published_count;
    rate->p_below = experiment::FisherExactLower(own.k, own.n, published.k, published.n);
  }
}

// Compares the rows, and the pooled counts of the overall row if all rows have published counts and
// the published overall row is theirs.
void ComparePooled(Table& table) {
  int compared = 0;
  Count detection, grasping;  // published, of the compared rows
  for (Row& row : table.rows) {
    const Count& of_row = row.text_detection.published_count;
    if (of_row.n == 0) continue;
    Compare(row);
    ++compared;
    detection.n += of_row.n;
    detection.k += of_row.k;
    grasping.k += row.text_grasping.published_count.k;
  }
  grasping.n = detection.k;
  if (compared > 0) table.p_threshold = kSignificance / compared;
  if (compared == 0 || compared < static_cast<int>(table.rows.size())) return;
  Row& overall = table.overall;
  if (!overall.text_detection.published && !overall.text_grasping.published) return;
  overall.text_detection.published_count = detection;
  overall.text_grasping.published_count = grasping;
  Compare(overall);
}

void CountOthers(const Record& record, const Data& data, Table& table) {
  const Data redraws = data.value("redraw_reasons", Data::object());
  for (const auto& [reason, count] : redraws.items()) table.redraws[reason] += count.get<int>();
  if (record.result.outcome != kDelivered) return;
  table.moved_others += data.value("others_moved", 0) > 0 ? 1 : 0;
  table.pushed_off += data.value("others_left_table", 0) > 0 ? 1 : 0;
  table.brought_others += data.value("others_brought", 0) > 0 ? 1 : 0;
}

void RaiseAudit(const Data& data, std::map<std::string, double>& max) {
  if (!data.contains("log") || !data["log"].contains("audit")) return;
  for (const auto& [name, value] : data["log"]["audit"].items()) {
    if (!value.is_number()) continue;
    double& so_far = max.try_emplace(name, value.get<double>()).first->second;
    so_far = std::max(so_far, value.get<double>());
  }
}

// Parses the data of each record only once: they are long, and a table may have a million records.
void CountRecords(const std::vector<Record>& records, Table& table) {
  for (const Record& record : records) {
    const Data data = DataOf(record);
    const auto row = std::ranges::find(table.rows, record.which.group, &Row::object);
    if (row != table.rows.end()) CountRecord(record, data, *row);
    CountRecord(record, data, table.overall);
    CountOthers(record, data, table);
    RaiseAudit(data, table.audit_max);
  }
}

int DeliveredOf(const Table& table) {
  const auto found = table.overall.outcomes.find(kDelivered);
  return found == table.overall.outcomes.end() ? 0 : found->second;
}

// ---- the table as text, CSV and JSON ----

std::string NameOf(const Row& row) { return row.title.empty() ? row.object : row.title; }
std::string Percent(const Rate& rate) { return rate ? Fixed(*rate * 100.0, 2) : "-"; }

// A p-value, marked if it is below the threshold.
std::string PText(const Table& table, const Rate& p) {
  if (!p) return "-";
  return Fixed(*p, 4) + (*p < table.p_threshold ? " *" : "");
}

// Counts of failures with the most frequent reason of each: "dropped 2 (2 x slid out of the hand),
// no_path 3 (2 x no_ik)".
std::string Failures(const Row& row) {
  std::vector<std::string> texts;
  for (const auto& [outcome, count] : row.outcomes) {
    if (outcome == kDelivered) continue;
    std::string& text = texts.emplace_back(fmt::format("{} {}", outcome, count));
    const auto reasons = row.reasons.find(outcome);
    if (reasons == row.reasons.end()) continue;
    const Reason& most = std::ranges::max_element(reasons->second, {}, [](const auto& one) {
                           return one.second.count;
                         })->second;
    text += fmt::format(" ({} x {})", most.count, most.example);
  }
  return base::Join(texts);
}

std::vector<Row> AllRows(const Table& table) {
  std::vector<Row> rows = table.rows;
  rows.push_back(table.overall);
  return rows;
}

Grid GridOf(const Table& table) {
  const auto rows = AllRows(table);
  std::vector<Column<Row>> columns = {
      {"no.", "",
       [&](const Row& row) {
         return &row == &rows.back() ? "" : fmt::format("{}", &row - rows.data() + 1);
       }},
      {"object", "", NameOf, experiment::kLeft},
      {"trials", "", [](const Row& row) { return row.detection.count.n; }}};
  const auto add_rate = [&](const char* title, RowRate Row::*of) {
    columns.push_back({title, "", [of](const Row& row) { return Percent((row.*of).rate); }});
    columns.push_back(
        {"95 %", "", [of](const Row& row) { return IntervalText((row.*of).interval); }});
  };
  const auto add_compared = [&](const char* title, RowRate Row::*of) {
    add_rate(title, of);
    const auto is_published = [of](const Row& row) { return (row.*of).published.has_value(); };
    if (std::ranges::none_of(rows, is_published)) return;
    columns.push_back(
        {"published", "", [of](const Row& row) { return Percent((row.*of).published); }});
    if (table.p_threshold == 0.0) return;
    columns.push_back(
        {"p", "", [&table, of](const Row& row) { return PText(table, (row.*of).p_below); }});
  };
  add_rate("detection %", &Row::detection);
  add_rate("grasping %", &Row::grasping);
  add_compared("detection (text) %", &Row::text_detection);
  add_compared("grasping (text) %", &Row::text_grasping);
  columns.push_back({"failures", "", Failures, experiment::kLeft});
  Grid grid = experiment::GridOf(columns, rows);
  grid.total = true;
  return grid;
}

std::string ComparisonLine(const Table& table) {
  std::vector<std::string> below;
  for (const Row& row : AllRows(table)) {
    if (IsBelowPublished(table, row)) below.push_back(NameOf(row));
  }
  return fmt::format(
      "p: one-sided Fisher's exact test for a rate below the published one (overall: counts of all "
      "rows together); significantly below (* p < {:.4f} = 0.05 / rows, for each kind of rate): {}",
      table.p_threshold, below.empty() ? "none" : base::Join(below));
}

std::string PooledText(const RowRate& rate) {
  return fmt::format("{} % [{}]", Percent(RateOf(rate.count)),
                     IntervalText(IntervalOf(rate.count)));
}

std::string PooledLine(const Table& table) {
  const Row& all = table.overall;
  return fmt::format("pooled: detection {}, grasping {}; by the text: detection {}, grasping {}",
                     PooledText(all.detection), PooledText(all.grasping),
                     PooledText(all.text_detection), PooledText(all.text_grasping));
}

// Numbers of redrawn arrangements and of affected other objects.
std::string OthersLine(const Table& table) {
  return fmt::format(
      "redrawn arrangements: {}; of {} deliveries, {} moved other objects by more than 5 mm, {} "
      "pushed one off the table, {} also brought another one to the delivery place",
      table.redraws.empty() ? "none" : experiment::CountsText(table.redraws), DeliveredOf(table),
      table.moved_others, table.pushed_off, table.brought_others);
}

std::string TextNote(const Table& table) {
  const auto is_published = [](const Row& row) {
    return row.text_detection.published || row.text_grasping.published;
  };
  std::string note =
      "(text): the first object only has to contain a part of the target, as in the dissertation's "
      "\"considered as one object. A grasp will disambiguate the situation\"";
  if (std::ranges::any_of(AllRows(table), is_published)) {
    note += "; the published figures are compared with this verdict";
  }
  return note;
}

std::string TimesLine(const Table& table) {
  std::string line = "seconds, median (95 % quantile):";
  for (const auto& time : table.stage_seconds) {
    if (time.stage.find(':') != std::string::npos) continue;  // steps within a stage: JSON only
    line += fmt::format(" {} {:.3f} ({:.3f})", time.stage, time.median_s, time.p95_s);
  }
  return line;
}

Grid CsvGridOf(const Table& table) {
  std::vector<Column<Row>> columns = {
      {"object", "", &Row::object},
      {"title", "", &Row::title},
      {"trials", "", [](const Row& row) { return row.detection.count.n; }},
      {"detected", "", [](const Row& row) { return row.detection.count.k; }},
      {"delivered", "", [](const Row& row) { return row.grasping.count.k; }}};
  const auto add = [&](const std::string& title, RowRate Row::*of, const auto& value) {
    columns.push_back({title, ".4f", [=](const Row& row) { return value(row.*of); }});
  };
  for (const auto& [word, of] : kRates) {
    const std::string name(word);
    add(name + "_rate", of, [](const RowRate& rate) { return rate.rate; });
    add(name + "_low", of,
        [](const RowRate& r) { return r.interval ? Rate(r.interval->first) : std::nullopt; });
    add(name + "_high", of,
        [](const RowRate& r) { return r.interval ? Rate(r.interval->second) : std::nullopt; });
  }
  const auto published = [](const RowRate& rate) { return rate.published; };
  add("published_detection_rate", &Row::text_detection, published);
  add("published_grasp_rate", &Row::text_grasping, published);
  columns.push_back({"failures", "", Failures});
  return experiment::GridOf(columns, AllRows(table), "");
}

template <typename T>
ordered_json Json(const std::optional<T>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

void AddRate(std::string_view name, const Rate& rate, const Interval& interval,
             ordered_json& json) {
  json[fmt::format("{}_rate", name)] = Json(rate);
  json[fmt::format("{}_interval", name)] = Json(interval);
}

ordered_json RowJson(const Table& table, const Row& row) {
  const RowRate& by_text = row.text_detection;
  const RowRate& text_grasping = row.text_grasping;
  ordered_json json = {{"object", row.object},
                       {"title", row.title},
                       {"trials", row.detection.count.n},
                       {"detected", row.detection.count.k},
                       {"delivered", row.grasping.count.k}};
  for (const auto& [name, of] : kRates) {
    if (of == &Row::text_detection) {
      json["text_detected"] = by_text.count.k;
      json["text_delivered"] = text_grasping.count.k;
    }
    AddRate(name, (row.*of).rate, (row.*of).interval, json);
  }
  json["published_detection_rate"] = Json(by_text.published);
  json["published_grasp_rate"] = Json(text_grasping.published);
  json["outcomes"] = row.outcomes;
  json["reasons"] = ordered_json::object();
  for (const auto& [outcome, reasons] : row.reasons) {
    for (const auto& [reason, of] : reasons) json["reasons"][outcome][reason] = of.count;
  }
  if (by_text.published_count.n == 0) return json;
  json["published_trials"] = by_text.published_count.n;
  json["published_detected"] = by_text.published_count.k;
  json["published_delivered"] = text_grasping.published_count.k;
  json["detection_p_below"] = Json(by_text.p_below);
  json["grasp_p_below"] = Json(text_grasping.p_below);
  json["below_published"] = IsBelowPublished(table, row);
  return json;
}

ordered_json JsonOf(const Table& table) {
  ordered_json json = {{"rows", ordered_json::array()}};
  for (const Row& row : table.rows) json["rows"].push_back(RowJson(table, row));
  json["overall"] = RowJson(table, table.overall);
  for (const auto& [name, of] : kRates) {
    const Count& pooled = (table.overall.*of).count;
    AddRate(fmt::format("pooled_{}", name), RateOf(pooled), IntervalOf(pooled), json["overall"]);
  }
  json["redraws"] = table.redraws;
  json["others"] = {{"delivered", DeliveredOf(table)},
                    {"moved", table.moved_others},
                    {"pushed_off", table.pushed_off},
                    {"brought", table.brought_others}};
  if (table.p_threshold > 0.0) json["p_threshold"] = table.p_threshold;
  json["audit_worst"] = table.audit_max;
  json["stage_seconds"] = ordered_json::object();
  for (const auto& time : table.stage_seconds) {
    json["stage_seconds"][time.stage] = {{"median", time.median_s}, {"p95", time.p95_s}};
  }
  return json;
}

// The overall rates are means of the rows; the overall test uses the pooled counts.
std::vector<experiment::PublishedFigure> FiguresOf(const Table& table) {
  std::vector<experiment::PublishedFigure> figures;
  for (const Row& row : AllRows(table)) {
    for (const auto& [what, rate] :
         {std::pair{"detection", &row.text_detection}, {"grasping", &row.text_grasping}}) {
      if (!rate->published || row.text_detection.published_count.n == 0) continue;
      figures.push_back(
          {.row = row.title + ", " + what,
           .unit = "%",
           .published = *rate->published * 100.0,
           .own = rate->rate ? Rate(*rate->rate * 100.0) : std::nullopt,
           .evidence = experiment::TrialsEvidence{rate->count, rate->published_count}});
    }
  }
  return figures;
}

// ---- what the rates depend on ----

// Width of a bin of the static friction. A bin's number is its lower end divided by the width.
constexpr double kFrictionBin = 0.05;
// A coefficient at the boundary of two bins belongs to the upper bin despite rounding errors.
constexpr double kRounding = 1e-9;

// Upper ends of the bins; larger values are in one more bin. The slip of a held object is one or
// two millimetres, that of a lost object the distance that it fell.
const std::vector<double> kSlipEnds_mm = {1, 2, 5, 10, 20, 50};
const std::vector<double> kTiltEnds_deg = {1, 2, 5, 10, 20, 45};
const std::vector<double> kTenths_percent = {10, 20, 30, 40, 50, 60, 70, 80, 90};

// Data of a record that counts as detected.
struct Tried {
  Data data;
  bool delivered = false;
  std::size_t position = 0;  // in the records
};

using Positions = std::vector<std::size_t>;  // of cases, in the records

void Add(const std::string& label, const Count& count, const Positions& cases, Chart& chart) {
  chart.labels.push_back(label);
  auto& value = chart.series.front().values.emplace_back(PercentOf(count));
  value.cases = cases;
}

// @param cases, cases_by_text  that the rates count, by object
Chart ObjectChart(const Table& table, const std::map<std::string, Positions>& cases,
                  const std::map<std::string, Positions>& cases_by_text, const char* title,
                  RowRate Row::*of, RowRate Row::*text) {
  Chart chart{
      .title = title,
      .unit = "%",
      .along = "object",
      .series = {{.name = "this run"}, {.name = "this run, by the text"}, {.name = "published"}}};
  bool any = false;
  for (const Row& row : table.rows) {
    const Rate& published = (row.*text).published;
    const auto of_row = [&](const std::map<std::string, Positions>& some) {
      const auto found = some.find(row.object);
      return found == some.end() ? Positions() : found->second;
    };
    Add(NameOf(row), (row.*of).count, of_row(cases), chart);
    chart.series[1].values.push_back(PercentOf((row.*text).count));
    chart.series[1].values.back().cases = of_row(cases_by_text);
    chart.series[2].values.emplace_back();
    if (published) chart.series[2].values.back().value = 100.0 * *published;
    any = any || published;
  }
  if (!any) chart.series.pop_back();
  return chart;
}

// A record's bin in a chart: order and label; nullopt if the record does not have the value.
using Bin = std::optional<std::pair<int, std::string>>;

Chart DeliveredChart(const std::vector<Tried>& tried, const std::string& title,
                     const std::string& along, const std::function<Bin(const Data& data)>& bin_of) {
  std::map<std::pair<int, std::string>, std::pair<Count, Positions>> counts;
  for (const Tried& one : tried) {
    const Bin bin = bin_of(one.data);
    if (!bin) continue;
    auto& [count, cases] = counts[*bin];
    Add(one.delivered, count);
    cases.push_back(one.position);
  }
  Chart chart{
      .title = title, .unit = "%", .along = along, .series = {{.name = "delivered of detected"}}};
  for (const auto& [bin, of] : counts) Add(bin.second, of.first, of.second, chart);
  return chart;
}

// Bins by a word of the records.
auto WordBin(const char* key) {
  return [key](const Data& data) -> Bin {
    const std::string word = data.value(key, "");
    return word.empty() ? std::nullopt : Bin({0, word});
  };
}

Bin FrictionBin(const Data& data) {
  const auto friction = data.find("friction");
  if (friction == data.end() || !friction->is_number()) return std::nullopt;
  const int bin = static_cast<int>(std::floor(friction->get<double>() / kFrictionBin + kRounding));
  return {{bin, fmt::format("{:.2f}", bin * kFrictionBin)}};
}

// A number of the execution's log, if the record has it.
std::optional<double> Logged(const Data& data, const char* pointer) {
  const Data::json_pointer at(pointer);
  if (!data.contains(at) || !data[at].is_number()) return std::nullopt;
  return data[at].get<double>();
}

auto LogBin(const char* pointer, double scale, const std::vector<double>& ends) {
  return [=](const Data& data) -> Bin {
    const auto logged = Logged(data, pointer);
    if (!logged) return std::nullopt;
    const double figure = scale * *logged;
    const auto i = static_cast<std::size_t>(std::ranges::upper_bound(ends, figure) - ends.begin());
    const std::string low = i == 0 ? "0" : fmt::format("{:g}", ends[i - 1]);
    return {{static_cast<int>(i),
             i == ends.size() ? "over " + low : fmt::format("{}-{:g}", low, ends[i])}};
  };
}

// Predicted probabilities of the learned score and actual rates (a reliability diagram).
Chart PredictedChart(const std::vector<Tried>& tried) {
  constexpr const char* kProbability = "/log/grasp/probability";
  const auto bin_of = LogBin(kProbability, 100.0, kTenths_percent);
  Chart chart = DeliveredChart(tried, "Delivered by predicted probability",
                               "predicted probability of delivery, %", bin_of);
  std::map<int, std::vector<double>> predicted;
  for (const Tried& one : tried) {
    const auto bin = bin_of(one.data);
    if (bin) predicted[bin->first].push_back(100.0 * *Logged(one.data, kProbability));
  }
  chart.series.push_back({.name = "predicted, mean"});
  for (const auto& [bin, values] : predicted) {
    const double sum = std::reduce(values.begin(), values.end());
    chart.series.back().values.push_back({.value = sum / static_cast<double>(values.size())});
  }
  return chart;
}

}  // namespace

Table BuildTable(const Stamp& stamp, const std::vector<Record>& records) {
  Table table;
  const auto published = PublishedIn(stamp);
  for (const auto& object : base::Split(experiment::Need(stamp.identity, "groups"), ',')) {
    Row& row = table.rows.emplace_back();
    row.object = object;
    row.title = experiment::ValueOr(stamp.data, experiment::kTitlePrefix + object, "");
  }
  CountRecords(records, table);
  for (Row& row : table.rows) {
    for (const auto& [name, of] : kRates) {
      (row.*of).rate = RateOf((row.*of).count);
      (row.*of).interval = IntervalOf((row.*of).count);
    }
    AddPublished(published, row.title, row);
  }
  Row& overall = table.overall;
  overall.object = "overall";
  overall.title = "Overall";
  for (const auto& [name, of] : kRates) SetMean(table.rows, of, overall);
  if (HasAllRows(published, table.rows)) AddPublished(published, "overall", overall);
  ComparePooled(table);
  table.stage_seconds = experiment::StageTimes(records);
  return table;
}

bool IsBelowPublished(const Table& table, const Row& row) {
  const auto below = [&](const RowRate& rate) {
    return rate.p_below.value_or(1.0) < table.p_threshold;
  };
  return below(row.text_detection) || below(row.text_grasping);
}

experiment::Report ReportOf(const Stamp& stamp, const std::vector<Record>& records) {
  const Table table = BuildTable(stamp, records);
  experiment::Report report;
  report.sections.push_back({"", GridOf(table)});
  report.notes = {PooledLine(table), OthersLine(table), TimesLine(table)};
  if (table.overall.text_detection.count.n > 0) report.notes.push_back(TextNote(table));
  if (table.p_threshold > 0.0) report.notes.push_back(ComparisonLine(table));
  report.json = JsonOf(table).dump();
  report.csv = CsvGridOf(table);
  report.published = FiguresOf(table);
  return report;
}

std::vector<Chart> ChartsOf(const Stamp& stamp, const std::vector<Record>& records) {
  const Table table = BuildTable(stamp, records);
  std::vector<Tried> tried;
  std::map<std::string, Positions> all, detected, detected_by_text;  // by object
  for (std::size_t i = 0; i < records.size(); ++i) {
    const std::string& object = records[i].which.group;
    auto data = DataOf(records[i]);
    all[object].push_back(i);
    const auto text = data.find("text");
    if (text != data.end() && text->value("detected", false)) detected_by_text[object].push_back(i);
    if (!data.value("detected", false)) continue;
    detected[object].push_back(i);
    tried.push_back({std::move(data), records[i].result.outcome == kDelivered, i});
  }
  std::vector<Chart> charts = {
      ObjectChart(table, all, all, "Detection rate by object", &Row::detection,
                  &Row::text_detection),
      ObjectChart(table, detected, detected_by_text, "Grasping rate by object", &Row::grasping,
                  &Row::text_grasping),
      DeliveredChart(tried, "Delivered by resting pose", "resting pose", WordBin("pose_class")),
      DeliveredChart(tried, "Delivered by kind of grasp", "kind of grasp", WordBin("grasp_type")),
      DeliveredChart(tried, "Delivered by friction",
                     "static friction of the glove on the object, from", FrictionBin),
      DeliveredChart(tried, "Delivered by slip", "slip in the hand while it held, mm",
                     LogBin("/log/slip_in_hand_m", base::kMmPerM, kSlipEnds_mm)),
      DeliveredChart(tried, "Delivered by tilt", "turn in the hand while it held, degrees",
                     LogBin("/log/tilt_in_hand_rad", base::ToDeg(1.0), kTiltEnds_deg)),
      PredictedChart(tried)};
  std::erase_if(charts, [](const Chart& chart) { return chart.labels.empty(); });
  return charts;
}

}  // namespace rangegrasp::trial
