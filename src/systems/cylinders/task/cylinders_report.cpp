#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/draw/plot.h"
#include "cylinders/task/cylinders_task.h"

namespace rangegrasp::cylinders {
namespace {

using experiment::Column;
using experiment::kLeft;
using experiment::MeanOf;
using experiment::Record;

/// Number of iterations in the published tables.
constexpr int kPublishedIterations = 100;

/// Names and colors in figures, in the order of Method.
struct MethodStyle {
  const char* name;
  const char* color;
};
constexpr std::array<MethodStyle, 5> kStyles = {{{"LSF", "#d62728"},
                                                 {"RCF as printed", "#9467bd"},
                                                 {"RCF with additions", "#1f77b4"},
                                                 {"PCL", "#7f7f7f"},
                                                 {"refined", "#2ca02c"}}};
const MethodStyle& StyleOf(Method method) { return kStyles[static_cast<std::size_t>(method)]; }

struct Key {
  Source source;
  std::size_t row;
  Method method;
  int iterations;
  auto operator<=>(const Key&) const = default;
};

struct Fits {
  std::vector<double> radius_mm, radius_error_mm, axis_error_deg, seconds, preparation;
  int failed = 0;

  int All() const { return failed + static_cast<int>(radius_mm.size()); }
};

struct PublishedRow {
  double radius_error_mm, axis_error_deg, time_s;
};
using PublishedRows = std::map<std::pair<Method, int>, PublishedRow>;  ///< by method and points

/// One line of the tables: for a source, a row, a method and a number of iterations.
struct TableLine : Key, Fits {
  double true_radius_mm, height_mm;
  int points;
  std::optional<PublishedRow> published;
};

/// Contents of the stamp and the records.
struct Collected {
  Shown shown;
  std::vector<int> points;  ///< for each row
  std::vector<TableLine> lines;
  PublishedRows published;
  /// Iterations of the tables: the published number, or the largest available.
  int iterations = 0;
};

PublishedRows ReadPublished(const experiment::Stamp& stamp) {
  PublishedRows published;
  const auto csv = experiment::ReferenceOf(stamp);
  if (!csv) return published;
  for (std::size_t row = 0; row < csv->rows(); ++row) {
    const auto number = [&](const char* name) { return csv->Number(row, csv->Column(name)); };
    const std::size_t column = csv->Column("method");
    const std::string& name = csv->Cell(row, column);
    if (name != "LSF" && name != "RCF") csv->Fail(row, column, "must be LSF or RCF");
    // The dissertation's RCF is the one without our additions.
    const Method method = name == "LSF" ? Method::kLsf : Method::kPrinted;
    published[{method, static_cast<int>(number("points"))}] = {
        number("radius_error_mm"), number("axis_error_deg"), number("time_s")};
  }
  return published;
}

void AddFit(const nlohmann::json& fit, const Record& record, Fits& fits) {
  const std::string name =
      fmt::format("{} {}", fit.at("method").get<std::string>(), fit.at("iterations").get<int>());
  const auto seconds_of = [&](const std::string& step) {
    const auto& all = record.result.seconds;
    const auto found = std::ranges::find(all, step, &std::pair<std::string, double>::first);
    return found == all.end() ? 0.0 : found->second;
  };
  fits.seconds.push_back(seconds_of(name));
  fits.preparation.push_back(seconds_of(name + kPreparation));
  if (fit.contains("failed")) {
    ++fits.failed;
    return;
  }
  fits.radius_mm.push_back(fit.at("radius_mm"));
  fits.radius_error_mm.push_back(fit.at("radius_error_mm"));
  fits.axis_error_deg.push_back(fit.at("axis_error_deg"));
}

/// A case without a result counts as a failure of each method that occurs in other results.
std::map<Key, Fits> FitsOf(const std::vector<Record>& records) {
  std::map<Key, Fits> all;
  std::map<std::pair<Source, std::size_t>, int> without_result;  // crashed or timed out
  for (const Record& record : records) {
    const auto& params = record.which.params;
    const auto source = base::FromWord<Source>(params.Text("source"), "source");
    const auto row = static_cast<std::size_t>(params.Int("row"));
    const auto data = nlohmann::json::parse(record.result.data, nullptr, false);
    if (!data.is_object() || !data.contains("fits")) {
      ++without_result[{source, row}];
      continue;
    }
    for (const auto& fit : data.at("fits")) {
      const auto method = base::FromWord<Method>(fit.at("method").get<std::string>(), "method");
      AddFit(fit, record, all[{source, row, method, fit.at("iterations")}]);
    }
  }
  for (auto& [key, fits] : all) fits.failed += without_result[{key.source, key.row}];
  return all;
}

Collected Collect(const experiment::Stamp& stamp, const std::vector<Record>& records) {
  Collected all;
  all.shown = base::FromWord<Shown>(experiment::Need(stamp.data, kShown), kShown);
  const auto rows = nlohmann::json::parse(experiment::Need(stamp.data, kRows));
  for (const auto& row : rows) all.points.push_back(row.at("points"));
  all.published = ReadPublished(stamp);
  for (const auto& [key, fits] : FitsOf(records)) {
    const auto& row = rows.at(key.row);
    TableLine line{key, fits, row.at("radius_mm"), row.at("height_mm"), row.at("points"), {}};
    const auto found = all.published.find({key.method, line.points});
    // The published images had no noise.
    const bool comparable = key.source == Source::kPerfect && found != all.published.end();
    if (comparable) line.published = found->second;
    all.lines.push_back(std::move(line));
    all.iterations = std::max(all.iterations, key.iterations);
  }
  const auto is_published = [](const Key& key) { return key.iterations == kPublishedIterations; };
  if (std::ranges::any_of(all.lines, is_published)) all.iterations = kPublishedIterations;
  return all;
}

auto MeanIn(std::vector<double> Fits::*values) {
  return [values](const TableLine& line) { return MeanOf(line.*values).mean; };
}
auto ErrorIn(std::vector<double> Fits::*values) {
  return [values](const TableLine& line) { return MeanOf(line.*values).standard_error; };
}
auto PublishedIn(double PublishedRow::*figure) {
  return [figure](const TableLine& line) {
    return line.published ? std::optional(*line.published.*figure) : std::nullopt;
  };
}

experiment::Grid TableOf(const Collected& all, Source source) {
  using T = TableLine;
  using P = PublishedRow;
  static const std::vector<Column<T>> columns = {
      {"r x h [mm]", "",
       [](const T& t) { return fmt::format("{:.6g} x {:.6g}", t.true_radius_mm, t.height_mm); }},
      {"points", "", &T::points},
      {"method", "", [](const T& t) { return StyleOf(t.method).name; }, kLeft},
      {"r [mm]", ".4f", MeanIn(&T::radius_mm)},
      {"|dr| [mm]", ".4f", MeanIn(&T::radius_error_mm)},
      {"SE", ".4f", ErrorIn(&T::radius_error_mm)},
      {"published", ".3f", PublishedIn(&P::radius_error_mm)},
      {"|dv| [deg]", ".4f", MeanIn(&T::axis_error_deg)},
      {"SE", ".4f", ErrorIn(&T::axis_error_deg)},
      {"published", ".4f", PublishedIn(&P::axis_error_deg)},
      {"t [s]", ".4f", MeanIn(&T::seconds)},
      {"of it ppt [s]", ".4f", MeanIn(&T::preparation)},
      {"published", ".2f", PublishedIn(&P::time_s)},
      {"failed", "", [](const T& t) { return fmt::format("{} of {}", t.failed, t.All()); }}};
  std::vector<T> lines;
  std::ranges::copy_if(all.lines, std::back_inserter(lines), [&](const T& line) {
    return line.source == source && line.iterations == all.iterations;
  });
  return GridOf(columns, lines);
}

/// All means, machine-readable.
experiment::Grid MeansOf(const std::vector<TableLine>& lines) {
  using T = TableLine;
  static const std::vector<Column<T>> columns = {
      {"source", "", [](const T& t) { return base::Word(t.source); }},
      {"radius_true_mm", ".7g", &T::true_radius_mm},
      {"height_mm", ".7g", &T::height_mm},
      {"points", "", &T::points},
      {"method", "", [](const T& t) { return base::Word(t.method); }},
      {"iterations", "", &T::iterations},
      {"fits", "", &T::All},
      {"failed", "", &T::failed},
      {"radius_mm", ".7g", MeanIn(&T::radius_mm)},
      {"radius_se_mm", ".7g", ErrorIn(&T::radius_mm)},
      {"radius_error_mm", ".7g", MeanIn(&T::radius_error_mm)},
      {"radius_error_se_mm", ".7g", ErrorIn(&T::radius_error_mm)},
      {"axis_error_deg", ".7g", MeanIn(&T::axis_error_deg)},
      {"axis_error_se_deg", ".7g", ErrorIn(&T::axis_error_deg)},
      {"time_s", ".7g", MeanIn(&T::seconds)},
      {"preparation_s", ".7g", MeanIn(&T::preparation)}};
  return GridOf(columns, lines, "");
}

/// The quantity on a figure's y axis.
struct Quantity {
  const char* title;
  const char* name;
  const char* unit;
  int digits;
  std::vector<double> Fits::*own;
  double PublishedRow::*published;
};
constexpr std::array<Quantity, 3> kQuantities = {{
    {"Radius deviation", "radius error", "mm", 3, &TableLine::radius_error_mm,
     &PublishedRow::radius_error_mm},
    {"Angle deviation", "axis error", "deg", 4, &TableLine::axis_error_deg,
     &PublishedRow::axis_error_deg},
    {"Time", "time", "s", 4, &TableLine::seconds, &PublishedRow::time_s},
}};

/// A line of a figure: one method over the iterations of a row, or without a row over the points.
draw::Series SeriesOf(const Collected& all, const Quantity& quantity, Method method, Source source,
                      std::optional<std::size_t> row) {
  draw::Series series{.label = StyleOf(method).name, .x = {}, .y = {}};
  series.color = StyleOf(method).color;
  for (const TableLine& line : all.lines) {
    if (line.source != source || line.method != method) continue;
    if (row ? line.row != *row : line.iterations != all.iterations) continue;
    series.x.push_back(row ? line.iterations : line.points);
    series.y.push_back(MeanOf(line.*quantity.own).mean.value_or(std::nan("")));
  }
  // Rows are in the order of the file, which may be descending.
  if (series.x.size() > 1 && series.x.front() > series.x.back()) {
    std::ranges::reverse(series.x);
    std::ranges::reverse(series.y);
  }
  return series;
}

draw::Panel PanelOf(const Collected& all, const Quantity& quantity, Source source,
                    std::optional<std::size_t> row, const std::string& title) {
  draw::Panel panel{title, row ? "iterations" : "points", quantity.unit, {}, {}, {}, false};
  for (const Method method : base::ValuesOf<Method>()) {
    auto series = SeriesOf(all, quantity, method, source, row);
    if (!series.x.empty()) panel.series.push_back(std::move(series));
  }
  for (const auto& [key, published] : all.published) {
    const auto& [method, points] = key;
    if (source != Source::kPerfect || (row && points != all.points.at(*row))) continue;
    draw::Series dots;
    dots.color = StyleOf(method).color;
    dots.dots = true;
    dots.x = {static_cast<double>(row ? kPublishedIterations : points)};
    dots.y = {published.*quantity.published};
    // One legend entry per method.
    const bool first = std::ranges::none_of(
        panel.series, [&](const auto& s) { return s.dots && s.color == dots.color; });
    if (first) dots.label = std::string(StyleOf(method).name) + ", published";
    panel.series.push_back(std::move(dots));
  }
  double high = 0.0;
  for (const auto& series : panel.series) {
    // With few triples its errors are tens of millimetres, which would flatten all other lines.
    const bool cut = row && series.label == StyleOf(Method::kPrinted).name;
    for (std::size_t i = 0; i < series.y.size(); ++i) {
      if (cut && series.x[i] < kPublishedIterations) continue;
      if (std::isfinite(series.y[i])) high = std::max(high, series.y[i]);
    }
  }
  panel.y_range = {0.0, 1.1 * std::max(high, 1e-6)};
  return panel;
}

std::vector<experiment::PublishedFigure> FiguresOf(const Collected& all) {
  std::vector<experiment::PublishedFigure> figures;
  for (const TableLine& line : all.lines) {
    if (line.iterations != all.iterations || !line.published) continue;
    std::string row = fmt::format("{}, {} points, ", StyleOf(line.method).name, line.points);
    if (line.failed > 0) row += fmt::format("{} of {} failed, ", line.failed, line.All());
    for (const Quantity& quantity : kQuantities) {
      const experiment::Mean own = MeanOf(line.*quantity.own);
      experiment::Evidence evidence = experiment::MeanEvidence{own};
      if (quantity.own == &TableLine::seconds) {
        evidence = experiment::TimesEvidence{static_cast<int>(own.count)};
      }
      figures.push_back({.row = row + quantity.name,
                         .unit = quantity.unit,
                         .digits = quantity.digits,
                         .lower_is_better = true,
                         .published = *line.published.*quantity.published,
                         .own = own.mean,
                         .evidence = evidence});
    }
  }
  return figures;
}

/// Figure 4.13, or 4.14 to 4.19, three per row.
void AddFigures(const Collected& all, Source source, experiment::Report& report) {
  const std::string_view word = base::Word(source);
  const auto add = [&](int number, const std::vector<draw::Panel>& panels) {
    report.files.emplace_back(fmt::format("figure_4.{}_{}.svg", number, word),
                              draw::PlotSvg(panels));
  };
  if (all.shown == Shown::kResolution) {
    std::vector<draw::Panel> panels;
    for (const Quantity& quantity : kQuantities) {
      panels.push_back(PanelOf(all, quantity, source, std::nullopt,
                               fmt::format("{} ({})", quantity.title, word)));
    }
    return add(13, panels);
  }
  int number = 14;
  for (std::size_t row = 0; row < all.points.size(); ++row) {
    for (const Quantity& quantity : kQuantities) {
      add(number++, {PanelOf(all, quantity, source, row,
                             fmt::format("Cylinder {} ({} points, {}): {}", row + 1,
                                         all.points[row], word, quantity.title))});
    }
  }
}

}  // namespace

experiment::Report ComparisonReport(const experiment::Stamp& stamp,
                                    const std::vector<Record>& records) {
  const Collected all = Collect(stamp, records);
  experiment::Report report;
  report.csv = MeansOf(all.lines);
  for (const Source source : base::ValuesOf<Source>()) {
    if (std::ranges::find(all.lines, source, &TableLine::source) == all.lines.end()) continue;
    report.sections.push_back({fmt::format("Table {}, points: {}, {} iterations",
                                           all.shown == Shown::kResolution ? "4.3" : "4.4",
                                           base::Word(source), all.iterations),
                               TableOf(all, source)});
    AddFigures(all, source, report);
  }
  report.notes = {
      fmt::format(
          "means over the successful fits, with standard errors; noisy: {} mm along the rays",
          experiment::ValueOr(stamp.data, kNoise, "?")),
      "published: one synthetic range image a row, without noise; 2 GHz Core 2 Duo; ppt: normals "
      "and curvature"};
  report.published = FiguresOf(all);
  return report;
}

}  // namespace rangegrasp::cylinders
