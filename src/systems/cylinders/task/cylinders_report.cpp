#include "cylinders/task/cylinders_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/draw/plot.h"
#include "base/file.h"
#include "cylinders/task/cylinders_task.h"
#include "experiment/statistics.h"

namespace rangegrasp::cylinders {
namespace {

using experiment::Fixed;
using experiment::Grid;
using experiment::Mean;
using experiment::MeanOf;
using experiment::PercentText;
using experiment::Record;

/// A fit this near to the truth serves to grasp the cylinder: what detection is held to
/// (docs/cylinders.md).
constexpr double kGoodRadius_mm = 0.5;
constexpr double kGoodAxis_deg = 1.0;
/// The published tables are of so many iterations.
constexpr int kPublishedIterations = 100;
constexpr int kDigits = 4;

/// Figures' names and colors, in the order of Method.
struct MethodStyle {
  const char* name;
  const char* color;
};
constexpr std::array<MethodStyle, 5> kStyles = {{{"LSF", "#d62728"},
                                                 {"RCF as printed", "#9467bd"},
                                                 {"RCF", "#1f77b4"},
                                                 {"PCL", "#7f7f7f"},
                                                 {"refined", "#2ca02c"}}};
const MethodStyle& StyleOf(Method method) { return kStyles[static_cast<std::size_t>(method)]; }

/// One line of the tables: a source, a row, a method, a number of iterations.
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
  int good = 0;

  int All() const { return failed + static_cast<int>(radius_mm.size()); }
};

struct PublishedRow {
  double radius_mm, radius_error_mm, axis_error_deg, time_s;
  std::optional<double> preparation_s;
};

/// What the stamp says and the records hold.
struct Collected {
  Shown shown;
  nlohmann::json rows;
  std::map<Key, Fits> fits;
  std::map<std::pair<Source, std::size_t>, int> without_result;  ///< crashed or timed out
  std::map<std::pair<Method, int>, PublishedRow> published;      ///< by method and points
};

std::optional<Method> MethodOf(const std::string& name) {
  for (const Method method : base::ValuesOf<Method>()) {
    if (name == StyleOf(method).name) return method;
  }
  return std::nullopt;
}

void ReadPublished(const experiment::Stamp& stamp, Collected& all) {
  const auto text = stamp.data.find(kReference);
  if (text == stamp.data.end()) return;
  const auto csv = base::CsvTable::Parse(text->second, "reference table");
  for (std::size_t row = 0; row < csv.rows(); ++row) {
    const auto method = MethodOf(csv.Cell(row, csv.Column("method")));
    if (!method) csv.Fail(row, csv.Column("method"), "must be LSF or RCF");
    all.published[{*method, static_cast<int>(csv.Number(row, csv.Column("points")))}] = {
        csv.Number(row, csv.Column("radius_mm")), csv.Number(row, csv.Column("radius_error_mm")),
        csv.Number(row, csv.Column("axis_error_deg")), csv.Number(row, csv.Column("time_s")),
        csv.OptionalNumber(row, csv.Column("preprocessing_s"))};
  }
}

double SecondsOf(const Record& record, const std::string& name) {
  for (const auto& [step, seconds] : record.result.seconds) {
    if (step == name) return seconds;
  }
  return 0.0;
}

void AddRecord(const Record& record, Collected& all) {
  const auto source = base::FromWord<Source>(record.which.params.Text("source"), "source");
  const auto row = static_cast<std::size_t>(record.which.params.Int("row"));
  const auto data = nlohmann::json::parse(record.result.data, nullptr, false);
  if (!data.is_object() || !data.contains("fits")) {
    ++all.without_result[{source, row}];
    return;
  }
  for (const auto& fit : data.at("fits")) {
    const std::string word = fit.at("method");
    const int iterations = fit.at("iterations");
    Fits& fits = all.fits[{source, row, base::FromWord<Method>(word, "method"), iterations}];
    const std::string name = fmt::format("{} {}", word, iterations);
    fits.seconds.push_back(SecondsOf(record, name));
    fits.preparation.push_back(SecondsOf(record, name + kPreparation));
    if (fit.contains("failed")) {
      ++fits.failed;
      continue;
    }
    fits.radius_mm.push_back(fit.at("radius_mm"));
    fits.radius_error_mm.push_back(fit.at("radius_error_mm"));
    fits.axis_error_deg.push_back(fit.at("axis_error_deg"));
    const bool good = fits.radius_error_mm.back() <= kGoodRadius_mm &&
                      fits.axis_error_deg.back() <= kGoodAxis_deg;
    fits.good += good ? 1 : 0;
  }
}

Collected Collect(const experiment::Stamp& stamp, const std::vector<Record>& records) {
  Collected all;
  all.shown = base::FromWord<Shown>(experiment::Need(stamp.data, kShown), kShown);
  all.rows = nlohmann::json::parse(experiment::Need(stamp.data, kRows));
  ReadPublished(stamp, all);
  for (const Record& record : records) AddRecord(record, all);
  // A case without a result is a failure of each method that the others' results name.
  for (auto& [key, fits] : all.fits) {
    const auto lost = all.without_result.find({key.source, key.row});
    if (lost != all.without_result.end()) fits.failed += lost->second;
  }
  return all;
}

int PointsOf(const Collected& all, std::size_t row) { return all.rows.at(row).at("points"); }

std::string CellOf(const std::optional<double>& value, int digits) {
  return value ? Fixed(*value, digits) : "-";
}

std::vector<std::string> LineOf(const Collected& all, const Key& key, const Fits& fits) {
  const auto& row = all.rows.at(key.row);
  const Mean radius = MeanOf(fits.radius_mm);
  const Mean radius_error = MeanOf(fits.radius_error_mm);
  const Mean axis = MeanOf(fits.axis_error_deg);
  std::vector<std::string> line = {fmt::format("{:.6g} x {:.6g}", row.at("radius_mm").get<double>(),
                                               row.at("height_mm").get<double>()),
                                   fmt::format("{}", PointsOf(all, key.row)),
                                   StyleOf(key.method).name,
                                   CellOf(radius.mean, kDigits),
                                   CellOf(radius_error.mean, kDigits),
                                   CellOf(radius_error.standard_error, kDigits),
                                   "-",
                                   CellOf(axis.mean, kDigits),
                                   CellOf(axis.standard_error, kDigits),
                                   "-",
                                   CellOf(MeanOf(fits.seconds).mean, kDigits),
                                   CellOf(MeanOf(fits.preparation).mean, kDigits),
                                   "-",
                                   fmt::format("{} of {}", fits.failed, fits.All()),
                                   PercentText(fits.good, fits.All(), 1)};
  const auto published = all.published.find({key.method, PointsOf(all, key.row)});
  if (published != all.published.end()) {
    line[6] = Fixed(published->second.radius_error_mm, 3);
    line[9] = Fixed(published->second.axis_error_deg, 4);
    line[12] = Fixed(published->second.time_s, 2);
  }
  return line;
}

/// The lines that stand in the tables: of the published number of iterations, or of the largest
/// there is.
int TableIterations(const Collected& all) {
  int most = 0;
  for (const auto& [key, fits] : all.fits) {
    if (key.iterations == kPublishedIterations) return kPublishedIterations;
    most = std::max(most, key.iterations);
  }
  return most;
}

Grid TableOf(const Collected& all, Source source) {
  Grid grid;
  grid.header = {"r x h [mm]", "points",        "method",     "r [mm]", "|dr| [mm]",
                 "SE",         "published",     "|dv| [deg]", "SE",     "published",
                 "t [s]",      "of it ppt [s]", "published",  "failed", "good [%]"};
  grid.left.assign(grid.header.size(), false);
  grid.left[2] = true;
  const int iterations = TableIterations(all);
  for (const auto& [key, fits] : all.fits) {
    if (key.source == source && key.iterations == iterations) {
      grid.rows.push_back(LineOf(all, key, fits));
    }
  }
  return grid;
}

// All means, for programs.
Grid MeansOf(const Collected& all) {
  Grid grid;
  grid.header = base::Split(
      "source,radius_true_mm,height_mm,points,method,iterations,fits,failed,good,radius_mm,"
      "radius_se_mm,radius_error_mm,radius_error_se_mm,axis_error_deg,axis_error_se_deg,time_s,"
      "preparation_s",
      ',');
  grid.left.assign(grid.header.size(), false);
  const auto cell = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.7g}", *value) : std::string();
  };
  for (const auto& [key, fits] : all.fits) {
    const auto& row = all.rows.at(key.row);
    std::vector<std::string> line = {std::string(base::Word(key.source)),
                                     cell(row.at("radius_mm").get<double>()),
                                     cell(row.at("height_mm").get<double>()),
                                     fmt::format("{}", PointsOf(all, key.row)),
                                     std::string(base::Word(key.method)),
                                     fmt::format("{}", key.iterations),
                                     fmt::format("{}", fits.All()),
                                     fmt::format("{}", fits.failed),
                                     fmt::format("{}", fits.good)};
    for (const auto* values : {&fits.radius_mm, &fits.radius_error_mm, &fits.axis_error_deg}) {
      const Mean mean = MeanOf(*values);
      line.push_back(cell(mean.mean));
      line.push_back(cell(mean.standard_error));
    }
    line.push_back(cell(MeanOf(fits.seconds).mean));
    line.push_back(cell(MeanOf(fits.preparation).mean));
    grid.rows.push_back(std::move(line));
  }
  return grid;
}

/// What a figure has along y.
struct Quantity {
  const char* title;
  const char* unit;
  std::optional<double> (*of)(const Fits& fits);
  double (*published)(const PublishedRow& row);
};
constexpr std::array<Quantity, 3> kQuantities = {{
    {"Radius deviation", "mm", [](const Fits& f) { return MeanOf(f.radius_error_mm).mean; },
     [](const PublishedRow& p) { return p.radius_error_mm; }},
    {"Angle deviation", "deg", [](const Fits& f) { return MeanOf(f.axis_error_deg).mean; },
     [](const PublishedRow& p) { return p.axis_error_deg; }},
    {"Time", "s", [](const Fits& f) { return MeanOf(f.seconds).mean; },
     [](const PublishedRow& p) { return p.time_s; }},
}};

/// A line of a figure: one method, over points or iterations.
draw::Series SeriesOf(const Collected& all, const Quantity& quantity, Method method, Source source,
                      std::optional<std::size_t> row) {
  draw::Series series;
  series.label = StyleOf(method).name;
  series.color = StyleOf(method).color;
  for (const auto& [key, fits] : all.fits) {
    if (key.source != source || key.method != method || (row && key.row != *row)) continue;
    if (!row && key.iterations != TableIterations(all)) continue;
    series.x.push_back(row ? key.iterations : PointsOf(all, key.row));
    series.y.push_back(quantity.of(fits).value_or(std::nan("")));
  }
  // Rows stand in the order of the file, which may count down.
  if (series.x.size() > 1 && series.x.front() > series.x.back()) {
    std::reverse(series.x.begin(), series.x.end());
    std::reverse(series.y.begin(), series.y.end());
  }
  return series;
}

draw::Panel PanelOf(const Collected& all, const Quantity& quantity, Source source,
                    std::optional<std::size_t> row, const std::string& title) {
  draw::Panel panel{title, row ? "iterations" : "points", quantity.unit, {}, {}, {}, false};
  for (const Method method : base::ValuesOf<Method>()) {
    // Off by tens of millimetres, it would press all others to the axis; fits.csv has it.
    if (method == Method::kPrinted) continue;
    auto series = SeriesOf(all, quantity, method, source, row);
    if (!series.x.empty()) panel.series.push_back(std::move(series));
  }
  for (const auto& [key, published] : all.published) {
    if (row && key.second != PointsOf(all, *row)) continue;
    draw::Series dots;
    dots.color = StyleOf(key.first).color;
    dots.dots = true;
    dots.x = {static_cast<double>(row ? kPublishedIterations : key.second)};
    dots.y = {quantity.published(published)};
    // One entry in the legend a method.
    const bool first = std::none_of(panel.series.begin(), panel.series.end(),
                                    [&](const auto& s) { return s.dots && s.color == dots.color; });
    if (first) dots.label = std::string(StyleOf(key.first).name) + ", published";
    panel.series.push_back(std::move(dots));
  }
  double high = 0.0;
  for (const auto& series : panel.series) {
    for (const double y : series.y) high = std::isfinite(y) ? std::max(high, y) : high;
  }
  panel.y_range = {0.0, 1.1 * std::max(high, 1e-6)};
  return panel;
}

// The published images were perfect ones: only these are compared.
std::vector<experiment::PublishedFigure> FiguresOf(const Collected& all) {
  std::vector<experiment::PublishedFigure> figures;
  for (const auto& [key, fits] : all.fits) {
    const auto found = all.published.find({key.method, PointsOf(all, key.row)});
    if (key.source != Source::kPerfect || key.iterations != TableIterations(all) ||
        found == all.published.end()) {
      continue;
    }
    const PublishedRow& published = found->second;
    std::string row =
        fmt::format("{}, {} points, ", StyleOf(key.method).name, PointsOf(all, key.row));
    if (fits.failed > 0) row += fmt::format("{} of {} failed, ", fits.failed, fits.All());
    const auto add = [&](const char* what, const char* unit, int digits, double value,
                         const std::vector<double>& own, bool is_time) {
      const Mean mean = MeanOf(own);
      experiment::PublishedFigure figure{.row = row + what,
                                         .unit = unit,
                                         .digits = digits,
                                         .lower_is_better = true,
                                         .published = value,
                                         .own = mean.mean,
                                         .evidence = experiment::MeanEvidence{mean}};
      if (is_time) figure.evidence = experiment::TimesEvidence{static_cast<int>(mean.count)};
      figures.push_back(std::move(figure));
    };
    add("radius error", "mm", 3, published.radius_error_mm, fits.radius_error_mm, false);
    add("axis error", "deg", kDigits, published.axis_error_deg, fits.axis_error_deg, false);
    add("time", "s", kDigits, published.time_s, fits.seconds, true);
  }
  return figures;
}

std::vector<Source> SourcesOf(const Collected& all) {
  std::vector<Source> sources;  // the fits are in the order of their sources
  for (const auto& [key, fits] : all.fits) {
    if (sources.empty() || sources.back() != key.source) sources.push_back(key.source);
  }
  return sources;
}

/// Number of the first of each source's figures, three a row.
constexpr int kFirstIterationFigure = 14;

void AddFigures(const Collected& all, experiment::Report& report) {
  for (const Source source : SourcesOf(all)) {
    const std::string word(base::Word(source));
    if (all.shown == Shown::kResolution) {
      std::vector<draw::Panel> panels;
      for (const Quantity& quantity : kQuantities) {
        panels.push_back(PanelOf(all, quantity, source, std::nullopt,
                                 fmt::format("{} ({})", quantity.title, word)));
      }
      report.files.emplace_back(fmt::format("figure_4.13_{}.svg", word), draw::PlotSvg(panels));
      continue;
    }
    int number = kFirstIterationFigure;
    for (std::size_t row = 0; row < all.rows.size(); ++row) {
      for (const Quantity& quantity : kQuantities) {
        const auto panel = PanelOf(all, quantity, source, row,
                                   fmt::format("Cylinder {} ({} points, {}): {}", row + 1,
                                               PointsOf(all, row), word, quantity.title));
        report.files.emplace_back(fmt::format("figure_4.{}_{}.svg", number++, word),
                                  draw::PlotSvg({panel}));
      }
    }
  }
}

}  // namespace

experiment::Report ComparisonReport(const experiment::Stamp& stamp,
                                    const std::vector<Record>& records) {
  const Collected all = Collect(stamp, records);
  const bool resolution = all.shown == Shown::kResolution;
  experiment::Report report;
  for (const Source source : SourcesOf(all)) {
    report.sections.push_back(
        {fmt::format("Table {}, points: {}, {} iterations", resolution ? "4.3" : "4.4",
                     base::Word(source), TableIterations(all)),
         TableOf(all, source)});
  }
  const auto noise = stamp.data.find(kNoise);
  report.notes.push_back(
      fmt::format("means over the fits that did not fail, with their standard errors; good: radius "
                  "within {} mm and axis within {} deg, of all; noisy: {} mm along the rays",
                  kGoodRadius_mm, kGoodAxis_deg, noise == stamp.data.end() ? "?" : noise->second));
  report.notes.push_back(
      "published: one synthetic range image a row, 2 GHz Core 2 Duo; ppt: normals and curvature");
  report.csv = MeansOf(all);
  report.files.emplace_back("fits.csv", experiment::CsvOf(report.csv));
  AddFigures(all, report);
  report.published = FiguresOf(all);
  return report;
}

}  // namespace rangegrasp::cylinders
