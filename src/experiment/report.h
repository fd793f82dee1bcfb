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

/// Cells that people read, as text (columns aligned), Markdown or CSV.
struct Grid {
  std::vector<std::string> header;
  std::vector<bool> left;  ///< columns of words; numbers stand to the right; as many as the header
  std::vector<std::vector<std::string>> rows;
  bool total = false;  ///< the last row is a total: a line stands above it
};

std::string TextOf(const Grid& grid);
std::string MarkdownOf(const Grid& grid);
/// Cells that hold a comma or a quote are quoted.
std::string CsvOf(const Grid& grid);

/// A column of a table that is data: what stands above it, how a value is written, where it comes
/// from. A table is a list of columns and a list of rows:
///
///   const std::vector<Column<Fit>> columns = {
///       {"method", "", &Fit::name, kLeft},
///       {"|dr| [mm]", ".4f", [](const Fit& fit) { return MeanOf(fit.radius_error_mm).mean; }}};
///   const Grid grid = GridOf(columns, fits);
enum Side { kRight, kLeft };
template <typename Row>
struct Column {
  /// @param format  what stands behind the colon in a fmt field: ".4f"; empty for words and counts.
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
  std::function<std::optional<std::string>(const Row&)> text;  ///< nothing where it has no value
  Side side;
};

/// @param absent  what stands where a row has no value: "-" for people, nothing in CSV.
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

/// A row a record, a column for each name that any has in JSON: "id", "data.log.lift_height_m",
/// "seconds.scan". @throws base::RunError as ToJson.
Grid FlatGridOf(const std::vector<Record>& records);

/// A number with so many digits after the point.
std::string Fixed(double value, int digits);
/// k of n in per cent; "-" for n = 0.
std::string PercentText(int k, int n, int digits);
/// "no_path 1, dropped 2"
std::string CountsText(const std::map<std::string, int>& counts);
/// "low-high" in whole per cent; "-" without one.
std::string IntervalText(const std::optional<std::pair<double, double>>& interval);
/// That of Wilson's 95 % interval of k of n; "-" for n = 0.
std::string IntervalText(int k, int n);

// What a comparison with a published figure rests on.

/// Independent trials on both sides: Fisher's exact test.
struct TrialsEvidence {
  Count own, published;
};
/// Trials that are not independent of each other, against a published rate that is taken as exact.
struct ClustersEvidence {
  std::vector<Count> own;
};
/// Events, of which a run may have several: the exact test of two Poisson rates.
struct EventsEvidence {
  Count own, published;  ///< k events in n runs
};
/// Independent measurements, against a published mean that is taken as exact: Student's test.
struct MeanEvidence {
  Mean own;
};
/// Times of two different computers: no test.
struct TimesEvidence {
  int measured = 0;
};
using Evidence =
    std::variant<TrialsEvidence, ClustersEvidence, EventsEvidence, MeanEvidence, TimesEvidence>;

/// The key that names a published table in most experiment files, and the name of its text in
/// Stamp::data.
inline constexpr const char* kReferenceKey = "reference";
/// The published table whose text is in the stamp; nullopt if there is none.
/// @throws base::InputError if it is no table.
std::optional<base::CsvTable> ReferenceOf(const Stamp& stamp);

/// A figure of a published table, and what a run has in its place.
struct PublishedFigure {
  std::string row = {};   ///< "Coffee Cup, grasping"
  std::string unit = {};  ///< "%", "mm", "deg", "s", "in 50 runs": of both figures
  int digits = 1;         ///< after the point
  bool lower_is_better = false;
  double published = 0.0;
  std::optional<double> own = {};  ///< absent where nothing was counted
  Evidence evidence = {};
  /// The key of the experiment file that names the published table: an experiment may have two.
  std::string key = kReferenceKey;
};

/// A table with its title.
struct Section {
  std::string title;
  Grid grid;
};

/// All that an experiment prints.
struct Report {
  std::vector<Section> sections;
  std::vector<std::string> notes;  ///< lines below the tables, as text and Markdown
  /// JSON object whose keys follow "experiment" and "stamp"; empty: "tables" with the sections.
  std::string json;
  /// The table of --format csv; without a header: the sections one after the other.
  Grid csv;
  /// Name and text of files that `run` leaves next to the store: rows, figures.
  std::vector<std::pair<std::string, std::string>> files;
  /// The figures of the published tables that the experiment names, with the own ones.
  std::vector<PublishedFigure> published;
};

enum class TableFormat { kText, kMarkdown, kCsv, kJson };
constexpr std::array<std::string_view, 4> WordsOf(TableFormat) {
  return {"text", "markdown", "csv", "json"};
}

/// The tables one after the other, the stamp below them; CSV holds the tables alone, JSON the whole
/// report with the stamp in front.
std::string Format(const Report& report, const Stamp& stamp, TableFormat format);

/// A bar chart of figures, one for each label and series; a report's page draws it.
struct Chart {
  struct Value {
    std::optional<double> value = {};                     ///< absent: nothing was counted
    std::optional<std::pair<double, double>> range = {};  ///< low and high end
    std::string of = {};                                  ///< what it is made from: "3 of 10"
  };
  struct Series {
    std::string name;
    std::vector<Value> values = {};  ///< one for each label
  };
  std::string title = {};
  std::string unit = {};   ///< "%", "s", "trials"
  std::string along = {};  ///< what the labels are: "object"
  std::string note = {};   ///< a sentence below it; may be empty
  /// Values of a label add up and are drawn as one bar; if not, each is a mark with its range.
  bool stacked = false;
  std::vector<std::string> labels = {};
  std::vector<Series> series = {};
};
/// In per cent, with Wilson's 95 % interval; no value for n = 0.
Chart::Value PercentOf(const Count& count);

}  // namespace rangegrasp::experiment
