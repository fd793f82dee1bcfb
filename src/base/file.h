#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace rangegrasp::base {

/// The rest of a stream as bytes.
/// @throws InputError if reading fails, or for more than 2 GiB, e.g. an endless device.
std::string ReadAll(std::istream& in);

/// Reads a whole file as bytes.
/// @throws InputError naming the file if it is missing, unfit or not readable, or as ReadAll.
std::string ReadFile(const std::filesystem::path& file);

/// Why a path cannot be a file with data: a folder, or a named pipe, which may block forever unless
/// this process got it open (/dev/stdin, `<(command)` of a shell). Empty if it is fit, or missing.
std::string WhyUnfit(const std::filesystem::path& file);

/// "PATH: REASON", as a message.
std::string TextOf(const std::filesystem::filesystem_error& error);

/// Checks that a file can be read. For files that a library reads, whose messages say less.
/// @throws InputError as ReadFile.
void CheckReadable(const std::filesystem::path& file);

/// Like ReadFile, but an empty file is also an error.
std::string ReadNonEmptyFile(const std::filesystem::path& file);

/// Writes a whole file and creates its folder. An existing file is replaced atomically.
/// @throws RunError if the bytes did not reach the disk, InputError if there can be no folder.
void WriteFile(const std::filesystem::path& file, std::string_view bytes);

/// Creates a file's folder. @throws InputError naming the folder.
void MakeFolderOf(const std::filesystem::path& file);

/// @throws InputError naming the first line of the text that is not UTF-8.
void CheckUtf8(std::string_view text, const std::string& name);

/// The extension of a file name in lower case: ".ply" for "Cup.PLY".
std::string EndingOf(const std::filesystem::path& file);

/// A table of comma-separated values (RFC 4180) whose first line names the columns.
class CsvTable {
 public:
  /// @param name  name of the file, for messages
  /// @throws InputError naming file and line if the header is missing, a row has a different number
  /// of cells, a quote is not closed, or the text is not UTF-8.
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
  /// Like Number; nullopt for an empty cell.
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

/// A CSV line with its line break; cells are quoted where necessary.
std::string CsvLine(const std::vector<std::string>& cells);

/// 64-bit FNV-1a hash, continued from `state`. Identifies versions of files; not for security.
std::uint64_t Fnv1a(std::string_view bytes, std::uint64_t state = 0xcbf29ce484222325u);

/// 16 hexadecimal digits.
std::string Hex(std::uint64_t value);

}  // namespace rangegrasp::base
