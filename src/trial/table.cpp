#include "trial/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "base/file.h"
#include "base/units.h"
#include "base/words.h"

namespace rangegrasp::trial {
namespace {

using experiment::Fixed;
using experiment::Grid;
using experiment::IntervalText;
using experiment::Record;
using experiment::Stamp;
using nlohmann::ordered_json;
using Rate = std::optional<double>;
using experiment::Chart;
using experiment::Count;
using experiment::PercentOf;

struct Published {
  Rate detection, grasp;
  std::optional<int> trials;
};

/// All of a family of comparisons together are wrong by chance this often.
constexpr double kSignificance = 0.05;
/// Of a published row: more are a mistake in the file.
constexpr double kMaxTrials = 1e6;

// A rate in per cent; nothing where the cell is empty.
Rate PublishedRate(const base::CsvTable& csv, std::size_t row, const char* name) {
  const std::size_t column = csv.Column(name);
  const Rate percent = csv.OptionalNumber(row, column);
  if (!percent) return std::nullopt;
  if (!(*percent >= 0.0 && *percent <= 100.0)) {
    csv.Fail(row, column, "must be a rate from 0 to 100 per cent");
  }
  return *percent / 100.0;
}

// How many trials a row stands for; nothing where the table does not say.
std::optional<int> PublishedTrials(const base::CsvTable& csv, std::size_t row) {
  const auto& header = csv.header();
  const auto found = std::find(header.begin(), header.end(), "trials");
  if (found == header.end()) return std::nullopt;
  const auto column = static_cast<std::size_t>(found - header.begin());
  const auto trials = csv.OptionalNumber(row, column);
  if (!trials) return std::nullopt;
  if (!(*trials >= 1.0 && *trials == std::floor(*trials) && *trials <= kMaxTrials)) {
    csv.Fail(row, column, "must be a whole number of trials, 1 or more");
  }
  return static_cast<int>(*trials);
}

// By title, and "overall".
std::map<std::string, Published> PublishedIn(const Stamp& stamp) {
  std::map<std::string, Published> published;
  const auto text = stamp.data.find(kReference);
  if (text == stamp.data.end()) return published;
  const auto csv = base::CsvTable::Parse(text->second, "reference table");
  for (std::size_t row = 0; row < csv.rows(); ++row) {
    const bool overall = csv.Cell(row, csv.Column("object")) == "overall";
    published[overall ? "overall" : csv.Cell(row, csv.Column("name"))] = {
        PublishedRate(csv, row, "detection_rate"), PublishedRate(csv, row, "grasping_rate"),
        PublishedTrials(csv, row)};
  }
  return published;
}

void CountRecord(const Record& record, Row& row) {
  const auto data = nlohmann::json::parse(record.result.data, nullptr, false);
  ++row.trials;
  row.detected += data.is_object() && data.value("detected", false) ? 1 : 0;
  row.delivered += record.result.outcome == "delivered" ? 1 : 0;
  ++row.outcomes[record.result.outcome];
}

Rate RateOf(int k, int n) {
  if (n == 0) return std::nullopt;
  return static_cast<double>(k) / n;
}

// The mean of those rows that have the rate: the dissertation's "overall".
Rate MeanOf(const std::vector<Row>& rows, Rate Row::*rate) {
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

int Rounded(double x) { return static_cast<int>(std::lround(x)); }

void AddPublished(const std::map<std::string, Published>& published, const std::string& name,
                  Row& row) {
  const auto found = published.find(name);
  if (found == published.end()) return;
  row.published_detection_rate = found->second.detection;
  row.published_grasp_rate = found->second.grasp;
  row.published_trials = found->second.trials;
  if (!row.published_trials || !row.published_detection_rate || !row.published_grasp_rate) return;
  // The rates are of whole objects: 77.77 % of 9 detected are 7.
  row.published_detected = Rounded(*row.published_detection_rate * *row.published_trials);
  row.published_delivered = Rounded(*row.published_grasp_rate * row.published_detected);
}

// The published overall is that of all published rows: a run of some of them is not compared with
// it.
bool HasAllRows(const std::map<std::string, Published>& published, const std::vector<Row>& rows) {
  return std::all_of(published.begin(), published.end(), [&](const auto& one) {
    return one.first == "overall" || std::any_of(rows.begin(), rows.end(), [&](const Row& row) {
             return row.title == one.first;
           });
  });
}

void Compare(Row& row) {
  if (!row.published_trials) return;
  row.detection_p_below = experiment::FisherExactLower(
      row.detected, row.trials, row.published_detected, *row.published_trials);
  row.grasp_p_below = experiment::FisherExactLower(row.delivered, row.detected,
                                                   row.published_delivered, row.published_detected);
}

/// The overall row stands for the counts of all rows, if all have them.
void ComparePooled(Table& table) {
  int compared = 0;
  int trials = 0;
  for (Row& row : table.rows) {
    Compare(row);
    if (!row.published_trials) continue;
    ++compared;
    trials += *row.published_trials;
    table.overall.published_detected += row.published_detected;
    table.overall.published_delivered += row.published_delivered;
  }
  if (compared > 0) table.p_threshold = kSignificance / compared;
  if (compared == 0 || compared < static_cast<int>(table.rows.size())) return;
  table.overall.published_trials = trials;
  Compare(table.overall);
}

std::map<std::string, double> MaxAudit(const std::vector<Record>& records) {
  std::map<std::string, double> max;
  for (const Record& record : records) {
    const auto data = nlohmann::json::parse(record.result.data, nullptr, false);
    if (!data.is_object() || !data.contains("log") || !data["log"].contains("audit")) continue;
    for (const auto& [name, value] : data["log"]["audit"].items()) {
      if (!value.is_number()) continue;
      const auto [place, fresh] = max.try_emplace(name, value.get<double>());
      if (!fresh) place->second = std::max(place->second, value.get<double>());
    }
  }
  return max;
}

// A p-value, marked where it is below the threshold.
std::string PText(const Table& table, const Rate& p) {
  if (!p) return "-";
  return Fixed(*p, 4) + (*p < table.p_threshold ? " *" : "");
}

std::string NameOf(const Row& row) { return row.title.empty() ? row.object : row.title; }
std::string Percent(const Rate& rate) { return rate ? Fixed(*rate * 100.0, 2) : "-"; }

// The failures of a row, e.g. "no_path 1, dropped 2".
std::string Failures(const Row& row) {
  auto failures = row.outcomes;
  failures.erase("delivered");
  return experiment::CountsText(failures);
}

std::vector<std::string> CellsOf(const Table& table, const Row& row, const std::string& number) {
  return {number,
          NameOf(row),
          fmt::format("{}", row.trials),
          Percent(row.detection_rate),
          IntervalText(row.detected, row.trials),
          Percent(row.published_detection_rate),
          PText(table, row.detection_p_below),
          Percent(row.grasp_rate),
          IntervalText(row.delivered, row.detected),
          Percent(row.published_grasp_rate),
          PText(table, row.grasp_p_below),
          Failures(row)};
}

// Without published counts there are no p-values.
void DropComparison(Grid& grid) {
  for (auto column = grid.header.size(); column-- > 0;) {
    if (grid.header[column] != "p") continue;
    const auto at = static_cast<std::ptrdiff_t>(column);
    grid.header.erase(grid.header.begin() + at);
    grid.left.erase(grid.left.begin() + at);
    for (auto& row : grid.rows) row.erase(row.begin() + at);
  }
}

std::string ComparisonLine(const Table& table) {
  std::vector<std::string> below;
  for (const Row& row : table.rows) {
    if (IsBelowPublished(table, row)) below.push_back(NameOf(row));
  }
  return fmt::format(
      "p: Fisher's exact test, one-sided, of a lower rate than the published one; significantly "
      "below (* p < {:.4f} = 0.05 / rows): {}",
      table.p_threshold, below.empty() ? "none" : base::Join(below));
}

Grid GridOf(const Table& table) {
  Grid grid;
  grid.header = {"no.", "object",     "trials", "detection %", "95 %", "published",
                 "p",   "grasping %", "95 %",   "published",   "p",    "failures"};
  grid.left.assign(grid.header.size(), false);
  grid.left[1] = grid.left.back() = true;
  grid.total = true;
  int number = 0;
  for (const Row& row : table.rows) {
    grid.rows.push_back(CellsOf(table, row, fmt::format("{}", ++number)));
  }
  grid.rows.push_back(CellsOf(table, table.overall, ""));
  if (table.p_threshold == 0.0) DropComparison(grid);
  return grid;
}

std::string PooledLine(const Table& table) {
  return fmt::format(
      "pooled: detection {} % [{}], grasping {} % [{}]", Percent(table.pooled_detection_rate),
      IntervalText(table.overall.detected, table.overall.trials), Percent(table.pooled_grasp_rate),
      IntervalText(table.overall.delivered, table.overall.detected));
}

std::string TimesLine(const Table& table) {
  std::string line = "seconds, median (95 %):";
  for (const auto& time : table.stage_seconds) {
    if (time.stage.find(':') != std::string::npos) continue;  // steps within a stage: JSON only
    line += fmt::format(" {} {:.3f} ({:.3f})", time.stage, time.median_s, time.p95_s);
  }
  return line;
}

// Wilson's, of k of n; nothing for n = 0.
std::pair<Rate, Rate> Interval(int k, int n) {
  if (n == 0) return {};
  const auto [low, high] = experiment::WilsonInterval(k, n);
  return {low, high};
}

Grid CsvGridOf(const Table& table) {
  Grid grid;
  grid.header = base::Split(
      "object,title,trials,detected,delivered,detection_rate,detection_low,detection_high,"
      "grasp_rate,grasp_low,grasp_high,published_detection_rate,published_grasp_rate,failures",
      ',');
  const auto cell = [](const Rate& rate) { return rate ? Fixed(*rate, 4) : std::string(); };
  const auto add = [&](const Row& row) {
    const auto [detection_low, detection_high] = Interval(row.detected, row.trials);
    const auto [grasp_low, grasp_high] = Interval(row.delivered, row.detected);
    grid.rows.push_back(
        {row.object, row.title, fmt::format("{}", row.trials), fmt::format("{}", row.detected),
         fmt::format("{}", row.delivered), cell(row.detection_rate), cell(detection_low),
         cell(detection_high), cell(row.grasp_rate), cell(grasp_low), cell(grasp_high),
         cell(row.published_detection_rate), cell(row.published_grasp_rate), Failures(row)});
  };
  for (const Row& row : table.rows) add(row);
  add(table.overall);
  return grid;
}

ordered_json Json(const Rate& rate) { return rate ? ordered_json(*rate) : ordered_json(nullptr); }

ordered_json IntervalJson(int k, int n) {
  const auto [low, high] = Interval(k, n);
  return low ? ordered_json{*low, *high} : ordered_json(nullptr);
}

ordered_json RowJson(const Table& table, const Row& row) {
  ordered_json json = {{"object", row.object},
                       {"title", row.title},
                       {"trials", row.trials},
                       {"detected", row.detected},
                       {"delivered", row.delivered},
                       {"detection_rate", Json(row.detection_rate)},
                       {"detection_interval", IntervalJson(row.detected, row.trials)},
                       {"grasp_rate", Json(row.grasp_rate)},
                       {"grasp_interval", IntervalJson(row.delivered, row.detected)},
                       {"published_detection_rate", Json(row.published_detection_rate)},
                       {"published_grasp_rate", Json(row.published_grasp_rate)},
                       {"outcomes", row.outcomes}};
  if (!row.published_trials) return json;
  json["published_trials"] = *row.published_trials;
  json["published_detected"] = row.published_detected;
  json["published_delivered"] = row.published_delivered;
  json["detection_p_below"] = Json(row.detection_p_below);
  json["grasp_p_below"] = Json(row.grasp_p_below);
  json["below_published"] = IsBelowPublished(table, row);
  return json;
}

ordered_json JsonOf(const Table& table) {
  ordered_json json;
  json["rows"] = ordered_json::array();
  for (const Row& row : table.rows) json["rows"].push_back(RowJson(table, row));
  json["overall"] = RowJson(table, table.overall);
  json["overall"]["pooled_detection_rate"] = Json(table.pooled_detection_rate);
  json["overall"]["pooled_grasp_rate"] = Json(table.pooled_grasp_rate);
  if (table.p_threshold > 0.0) json["p_threshold"] = table.p_threshold;
  json["audit_worst"] = table.audit_max;
  json["stage_seconds"] = trial::JsonOf(table.stage_seconds);
  return json;
}

// A rate beside its published one; nothing where there is none.
void AddFigure(const Row& row, const char* what, const Rate& own, const Rate& published,
               const experiment::Count& counts, const experiment::Count& published_counts,
               std::vector<experiment::PublishedFigure>& figures) {
  if (!published || !row.published_trials) return;
  figures.push_back({.row = row.title + ", " + what,
                     .unit = "%",
                     .published = *published * 100.0,
                     .own = own ? Rate(*own * 100.0) : std::nullopt,
                     .evidence = experiment::TrialsEvidence{counts, published_counts}});
}

// The overall rates are means of rows, the test is of the pooled counts.
std::vector<experiment::PublishedFigure> FiguresOf(const Table& table) {
  std::vector<experiment::PublishedFigure> figures;
  std::vector<Row> rows = table.rows;
  rows.push_back(table.overall);
  for (const Row& row : rows) {
    const int trials = row.published_trials.value_or(0);
    AddFigure(row, "detection", row.detection_rate, row.published_detection_rate,
              {row.detected, row.trials}, {row.published_detected, trials}, figures);
    AddFigure(row, "grasping", row.grasp_rate, row.published_grasp_rate,
              {row.delivered, row.detected}, {row.published_delivered, row.published_detected},
              figures);
  }
  return figures;
}

// A coefficient that is a bin's end belongs to the bin above, whatever its last bit is.
constexpr double kRounding = 1e-9;

const std::map<int, Count>& BinsOf(const FrictionCurve& curve, const std::string& object) {
  static const std::map<int, Count> none;
  const auto found = curve.find(object);
  return found == curve.end() ? none : found->second;
}

void AddRow(const std::string& name, const std::map<int, Count>& bins, const std::set<int>& columns,
            experiment::Grid& grid) {
  std::vector<std::string> row{name};
  for (const int column : columns) {
    const auto bin = bins.find(column);
    row.push_back(bin == bins.end() ? "-" : fmt::format("{}/{}", bin->second.k, bin->second.n));
  }
  grid.rows.push_back(std::move(row));
}

constexpr const char* kDelivered = "delivered of detected";

// Upper ends of bins; what is larger is in one more. A hold's slip is a millimetre or two, a lost
// object's is as far as it fell.
const std::vector<double> kSlipEnds_mm = {1, 2, 5, 10, 20, 50};
const std::vector<double> kTiltEnds_deg = {1, 2, 5, 10, 20, 45};

// Of a record that counts as detected.
struct Tried {
  std::string object;
  nlohmann::json data;
  bool delivered = false;
};

std::vector<Tried> TriedOf(const std::vector<Record>& records) {
  std::vector<Tried> tried;
  for (const Record& record : records) {
    auto data = nlohmann::json::parse(record.result.data, nullptr, false);
    if (!data.is_object() || !data.value("detected", false)) continue;
    tried.push_back({record.which.group, std::move(data), record.result.outcome == "delivered"});
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

void Add(bool delivered, Count& count) {
  ++count.n;
  count.k += delivered ? 1 : 0;
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
    Add(one.delivered, counts[word->get<std::string>()]);
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
    Add(one.delivered, counts[static_cast<std::size_t>(bin)]);
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
      counts[bin].k += of_object.k;
      counts[bin].n += of_object.n;
    }
  }
  Chart chart =
      DeliveredChart("Delivered by friction", "static friction of the glove on the object, from");
  for (const auto& [bin, count] : counts)
    Add(fmt::format("{:.2f}", bin * kFrictionBin), count, chart);
  return chart;
}

}  // namespace

Table BuildTable(const Stamp& stamp, const std::vector<Record>& records) {
  Table table;
  const auto published = PublishedIn(stamp);
  const std::string& groups = experiment::Need(stamp.identity, "groups");
  for (const std::string& object : base::Split(groups, ',')) {
    Row row;
    row.object = object;
    const auto title = stamp.data.find(kTitlePrefix + object);
    if (title != stamp.data.end()) row.title = title->second;
    for (const Record& record : records) {
      if (record.which.group == object) CountRecord(record, row);
    }
    row.detection_rate = RateOf(row.detected, row.trials);
    row.grasp_rate = RateOf(row.delivered, row.detected);
    AddPublished(published, row.title, row);
    table.rows.push_back(row);
  }
  table.overall.object = "overall";
  table.overall.title = "Overall";
  for (const Record& record : records) CountRecord(record, table.overall);
  table.overall.detection_rate = MeanOf(table.rows, &Row::detection_rate);
  table.overall.grasp_rate = MeanOf(table.rows, &Row::grasp_rate);
  if (HasAllRows(published, table.rows)) AddPublished(published, "overall", table.overall);
  ComparePooled(table);
  table.pooled_detection_rate = RateOf(table.overall.detected, table.overall.trials);
  table.pooled_grasp_rate = RateOf(table.overall.delivered, table.overall.detected);
  table.stage_seconds = experiment::StageTimes(records);
  table.audit_max = MaxAudit(records);
  return table;
}

bool IsBelowPublished(const Table& table, const Row& row) {
  const auto below = [&](const Rate& p) { return p && *p < table.p_threshold; };
  return below(row.detection_p_below) || below(row.grasp_p_below);
}

ordered_json JsonOf(const std::vector<experiment::StageTime>& times) {
  ordered_json json = ordered_json::object();
  for (const auto& time : times) {
    json[time.stage] = {{"median", time.median_s}, {"p95", time.p95_s}};
  }
  return json;
}

experiment::Report ReportOf(const Stamp& stamp, const std::vector<Record>& records) {
  const Table table = BuildTable(stamp, records);
  experiment::Report report;
  report.sections.push_back({"", GridOf(table)});
  const auto objects = base::Split(experiment::Need(stamp.identity, "groups"), ',');
  const FrictionCurve curve = FrictionCurveOf(records);
  if (Grid by_friction = GridOf(curve, objects); !by_friction.rows.empty()) {
    report.sections.push_back(
        {"Delivered of detected by the glove's static friction on the object", by_friction});
  }
  report.notes = {PooledLine(table), TimesLine(table)};
  if (table.p_threshold > 0.0) report.notes.push_back(ComparisonLine(table));
  ordered_json json = JsonOf(table);
  json["friction_curve"] = JsonOf(curve, objects);
  report.json = json.dump();
  report.csv = CsvGridOf(table);
  report.published = FiguresOf(table);
  return report;
}

FrictionCurve FrictionCurveOf(const std::vector<experiment::Record>& records) {
  FrictionCurve curve;
  for (const Tried& one : TriedOf(records)) {
    const auto friction = one.data.find("friction");
    if (friction == one.data.end() || !friction->is_number()) continue;
    const int bin =
        static_cast<int>(std::floor(friction->get<double>() / kFrictionBin + kRounding));
    Add(one.delivered, curve[one.object][bin]);
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
  std::map<int, Count> all;
  for (const auto& [object, bins] : curve) {
    for (const auto& [column, bin] : bins) {
      columns.insert(column);
      all[column].n += bin.n;
      all[column].k += bin.k;
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
                      {"detected", bin.n},
                      {"delivered", bin.k}});
    }
    json.push_back({{"object", object}, {"bins", bins}});
  }
  return json;
}

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
