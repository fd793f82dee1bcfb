#pragma once

#include <fmt/format.h>

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/file.h"
#include "experiment/record.h"
#include "experiment/statistics.h"

namespace rangegrasp::experiment {

/// A table of cells for output as text (with aligned columns), Markdown or CSV.
struct Grid {
  std::vector<std::string> header;
  std::vector<bool> left;  ///< per column: left-aligned (words) or right-aligned (numbers)
  std::vector<std::vector<std::string>> rows;
  bool total = false;  ///< the last row is a total, with a line above it
};

std::string TextOf(const Grid& grid);
std::string MarkdownOf(const Grid& grid);
/// Cells with a comma or a quote are quoted.
std::string CsvOf(const Grid& grid);

/// A column of a table: its title, how a value is formatted, and where it comes from. A table is a
/// list of columns and a list of rows:
///
///   const std::vector<Column<Fit>> columns = {
///       {"method", "", &Fit::name, kLeft},
///       {"|dr| [mm]", ".4f", [](const Fit& fit) { return MeanOf(fit.radius_error_mm).mean; }}};
///   const Grid grid = GridOf(columns, fits);
enum Side { kRight, kLeft };
template <typename Row>
struct Column {
  /// @param format  format of a fmt field, after the colon: ".4f"; empty for words and counts.
  /// @param value  a member or a function of a row: words, a number, or a std::optional of them.
  template <typename Value>
  Column(std::string title_, std::string format, Value value, Side side_ = kRight)
      : title(std::move(title_)),
        text([format = "{:" + std::move(format) + "}", value](const Row& row) {
          const auto& cell = std::invoke(value, row);
          if constexpr (requires { cell.has_value(); }) {
            if (!cell) return std::optional<std::string>();
            return std::optional(fmt::format(fmt::runtime(format), *cell));
          } else {
            return std::optional(fmt::format(fmt::runtime(format), cell));
          }
        }),
        side(side_) {}

  std::string title;
  std::function<std::optional<std::string>(const Row&)> text;  ///< nullopt if there is no value
  Side side;
};

/// @param absent  text of an absent value: "-" for readers, nothing in CSV.
template <typename Row, typename Rows>
Grid GridOf(const std::vector<Column<Row>>& columns, const Rows& rows,
            const std::string& absent = "-") {
  Grid grid;
  for (const auto& column : columns) {
    grid.header.push_back(column.title);
    grid.left.push_back(column.side == kLeft);
  }
  for (const Row& row : rows) {
    auto& cells = grid.rows.emplace_back();
    for (const auto& column : columns) cells.push_back(column.text(row).value_or(absent));
  }
  return grid;
}

/// One row per record, one column for each name in the JSON of any record: "id",
/// "data.log.lift_height_m", "seconds.scan". @throws base::RunError as ToJson.
Grid FlatGridOf(const std::vector<Record>& records);

/// A number with this many digits after the decimal point.
std::string Fixed(double value, int digits);
/// k of n in per cent; "-" for n = 0.
std::string PercentText(int k, int n, int digits);
/// "no_path 1, dropped 2"
std::string CountsText(const std::map<std::string, int>& counts);
/// An interval as "low-high" in whole per cent; "-" if absent.
std::string IntervalText(const std::optional<std::pair<double, double>>& interval);
/// The same for Wilson's 95 % interval of k of n; "-" for n = 0.
std::string IntervalText(int k, int n);

// Evidence for a comparison with a published figure.

/// Independent trials on both sides: Fisher's exact test.
struct TrialsEvidence {
  Count own, published;
};
/// Trials that depend on each other, compared with a published rate that is taken as exact.
struct ClustersEvidence {
  std::vector<Count> own;
};
/// Events, of which a run may have several: exact test of two Poisson rates.
struct EventsEvidence {
  Count own, published;  ///< k events in n runs
};
/// Independent measurements, compared with a published mean that is taken as exact: Student's test.
struct MeanEvidence {
  Mean own;
};
/// Times measured on two different computers: no test.
struct TimesEvidence {
  int measured = 0;
};
using Evidence =
    std::variant<TrialsEvidence, ClustersEvidence, EventsEvidence, MeanEvidence, TimesEvidence>;

/// Key of most experiment files for a published table, and the name of its text in Stamp::data.
inline constexpr const char* kReferenceKey = "reference";
/// The text of a published table, for Stamp::data.
/// @throws base::InputError naming the file unless it is CSV with a header line and rows.
std::string PublishedText(const std::filesystem::path& file);
/// The published table whose text is in the stamp; nullopt if there is none.
/// @throws base::InputError if it is not a table.
std::optional<base::CsvTable> ReferenceOf(const Stamp& stamp);

/// A figure of a published table, and the run's own figure.
struct PublishedFigure {
  std::string row = {};   ///< "Coffee Cup, grasping"
  std::string unit = {};  ///< "%", "mm", "deg", "s", "in 50 runs", for both figures
  int digits = 1;         ///< after the decimal point
  bool lower_is_better = false;
  double published = 0.0;
  std::optional<double> own = {};  ///< absent if nothing was counted
  Evidence evidence = {};
  /// The key of the experiment file that names the published table: an experiment may have two.
  std::string key = kReferenceKey;
};

/// A table with its title.
struct Section {
  std::string title;
  Grid grid;
};

/// Everything that an experiment prints.
struct Report {
  std::vector<Section> sections;
  std::vector<std::string> notes;  ///< lines below the tables, as text and Markdown
  /// JSON object whose keys follow "experiment" and "stamp"; if empty, "tables" has the sections.
  std::string json;
  /// The table of --format csv; without a header, the sections are printed one after the other.
  Grid csv;
  /// Name and text of files that `run` writes next to the store: rows, figures.
  std::vector<std::pair<std::string, std::string>> files;
  /// The figures of the published tables that the experiment names, with the run's own figures.
  std::vector<PublishedFigure> published;
};

enum class TableFormat { kText, kMarkdown, kCsv, kJson };
constexpr std::array<std::string_view, 4> WordsOf(TableFormat) {
  return {"text", "markdown", "csv", "json"};
}

/// The tables one after the other, with the stamp below. CSV contains only the tables, JSON the
/// whole report after the stamp.
std::string Format(const Report& report, const Stamp& stamp, TableFormat format);

/// A bar chart of figures, one for each label and series, drawn on a report's page.
struct Chart {
  struct Value {
    std::optional<double> value = {};                     ///< absent: nothing was counted
    std::optional<std::pair<double, double>> range = {};  ///< low and high end
    std::string of = {};                                  ///< underlying counts: "3 of 10"
    std::vector<std::size_t> cases = {};  ///< positions in the records of what it counts
  };
  struct Series {
    std::string name;
    std::vector<Value> values = {};  ///< one for each label
  };
  std::string title = {};
  std::string unit = {};   ///< "%", "s", "trials"
  std::string along = {};  ///< meaning of the labels: "object"
  std::string note = {};   ///< a sentence below it; may be empty
  /// True: the values of a label add up to one bar. False: each value is a mark with its range.
  bool stacked = false;
  std::vector<std::string> labels = {};
  std::vector<Series> series = {};
};
/// A rate in per cent, with Wilson's 95 % interval; no value for n = 0.
Chart::Value PercentOf(const Count& count);

}  // namespace rangegrasp::experiment
