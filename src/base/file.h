#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace rangegrasp::base {

/// The whole file as bytes.
/// @throws InputError naming the file if it is missing, a folder or not readable.
std::string ReadFile(const std::filesystem::path& file);

/// @throws InputError as ReadFile. For files that a library reads, whose messages say less.
void CheckReadable(const std::filesystem::path& file);

/// An empty file is an error, too.
std::string ReadNonEmptyFile(const std::filesystem::path& file);

/// Writes the file whole, with its folder; replaces one of that name in one step.
/// @throws RunError naming the file if the bytes did not reach the disk, InputError if the folder
/// cannot be made.
void WriteFile(const std::filesystem::path& file, std::string_view bytes);

/// Makes a file's folder. @throws InputError naming the folder.
void MakeFolderOf(const std::filesystem::path& file);

/// @throws InputError naming the text's line that is not UTF-8.
void CheckUtf8(std::string_view text, const std::string& name);

/// What a file's name ends with, in small letters: ".ply" of "Cup.PLY".
std::string EndingOf(const std::filesystem::path& file);

/// A table of comma-separated values (RFC 4180) whose first line names the columns.
class CsvTable {
 public:
  /// @param name  of the file, for messages
  /// @throws InputError naming file and line if there is no header, a row has another number of
  /// cells, a quote is not closed, or the text is not UTF-8.
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
  /// Nothing for an empty cell.
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

/// One line with its line break; cells are quoted where they must be.
std::string CsvLine(const std::vector<std::string>& cells);

/// FNV-1a, 64 bits, continued from `state`. Identifies versions of files; not for security.
std::uint64_t Fnv1a(std::string_view bytes, std::uint64_t state = 0xcbf29ce484222325u);

/// 16 hexadecimal digits.
std::string Hex(std::uint64_t value);

}  // namespace rangegrasp::base
