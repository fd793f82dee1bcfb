#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace rangegrasp::base {

/// A table of comma-separated values (RFC 4180: cells with a comma, a quote or a line break stand
/// in quotes, a quote in them is doubled) whose first line names the columns.
class CsvTable {
 public:
  /// @param name  of the file, for what is said of an error.
  /// @throws InputError naming file and line if there is no header, a row has not as many cells as
  /// it, or a quote is not closed.
  static CsvTable Parse(std::string_view text, const std::string& name);
  static CsvTable Read(const std::filesystem::path& file);

  const std::vector<std::string>& header() const { return header_; }
  std::size_t rows() const { return rows_.size(); }
  const std::string& Cell(std::size_t row, std::size_t column) const {
    return rows_[row].cells[column];
  }
  /// The position of a column. @throws InputError naming the file, its columns and the nearest one.
  std::size_t Column(const std::string& name) const;
  /// A finite number. @throws InputError naming file, line, column and the cell.
  double Number(std::size_t row, std::size_t column) const;
  /// The same; nothing for an empty cell.
  std::optional<double> OptionalNumber(std::size_t row, std::size_t column) const;
  /// Throws an InputError for a cell: "file:line: column 'x': 'cell' <must be ...>".
  [[noreturn]] void Fail(std::size_t row, std::size_t column, const std::string& what) const;

 private:
  struct Row {
    int line;
    std::vector<std::string> cells;
  };
  std::string name_;
  std::vector<std::string> header_;
  std::vector<Row> rows_;
};

/// A cell as it is written: quoted where it must be.
std::string CsvCell(const std::string& cell);
/// One line with its line break.
std::string CsvLine(const std::vector<std::string>& cells);

}  // namespace rangegrasp::base
