#include <array>
#include <charconv>
#include <fstream>
#include <string_view>

#include "core/error.h"
#include "core/file.h"
#include "parts/benchmark.h"

namespace rangegrasp::parts {
namespace {

constexpr std::string_view kHeader =
    "class,id,split,method,parts,rand_error,cut_discrepancy,seconds,failed,note";

template <typename T>
std::string Shortest(T value) {
  std::array<char, 64> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// One line, quoted.
std::string NoteCell(const std::string& note) {
  std::string cell = "\"";
  for (const char c : note) {
    if (c == '"') cell += '"';
    cell += c == '\n' || c == '\r' ? ' ' : c;
  }
  return cell + "\"";
}

std::string LineOf(const BenchmarkRow& row) {
  std::string line = row.class_name + "," + std::to_string(row.id) + "," + Name(row.split) + "," +
                     Name(row.method) + "," + std::to_string(row.parts) + "," +
                     Shortest(row.rand_error) + ",";
  if (row.cut_discrepancy) line += Shortest(*row.cut_discrepancy);
  line += "," + Shortest(row.seconds) + (row.failed ? ",1," : ",0,");
  return line + (row.note.empty() ? "" : NoteCell(row.note)) + "\n";
}

/// Cells of one line, with where it stands for what is wrong with them.
class LineReader {
 public:
  LineReader(std::string where, std::string_view line) : where_(std::move(where)), rest_(line) {}

  std::string_view Cell(const char* name) {
    const std::size_t comma = rest_.find(',');
    if (comma == std::string_view::npos) Fail(name, rest_, "more cells after it");
    const std::string_view cell = rest_.substr(0, comma);
    rest_.remove_prefix(comma + 1);
    return cell;
  }
  template <typename T>
  T Number(const char* name) {
    const std::string_view cell = Cell(name);
    T value{};
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size()) Fail(name, cell, "a number");
    return value;
  }
  std::optional<double> OptionalNumber(const char* name) {
    if (!rest_.starts_with(',')) return Number<double>(name);
    rest_.remove_prefix(1);
    return std::nullopt;
  }
  template <typename T, std::size_t n>
  T Word(const char* name, const std::array<T, n>& values) {
    const std::string_view cell = Cell(name);
    std::string names;
    for (const T value : values) {
      if (cell == Name(value)) return value;
      names += (names.empty() ? "" : ", ") + std::string(Name(value));
    }
    Fail(name, cell, "one of " + names);
  }
  /// What is left, unquoted.
  std::string Note() {
    if (rest_.empty()) return "";
    if (rest_.size() < 2 || rest_.front() != '"' || rest_.back() != '"') {
      Fail("note", rest_, "text in quotes, or nothing");
    }
    std::string note;
    for (std::size_t i = 1; i + 1 < rest_.size(); ++i) {
      note += rest_[i];
      if (rest_[i] == '"') ++i;
    }
    return note;
  }

 private:
  [[noreturn]] void Fail(const char* name, std::string_view cell, const std::string& right) const {
    throw core::InputError(where_ + "'" + std::string(cell.substr(0, 60)) + "' in column '" + name +
                           "': there must be " + right);
  }

  std::string where_;
  std::string_view rest_;
};

BenchmarkRow ParseLine(LineReader line) {
  BenchmarkRow row;
  row.class_name = line.Cell("class");
  row.id = line.Number<int>("id");
  row.split = line.Word("split", std::array{Split::kTune, Split::kReport});
  row.method = line.Word("method", kMethods);
  row.parts = line.Number<int>("parts");
  row.rand_error = line.Number<double>("rand_error");
  row.cut_discrepancy = line.OptionalNumber("cut_discrepancy");
  row.seconds = line.Number<double>("seconds");
  row.failed = line.Number<int>("failed") != 0;
  row.note = line.Note();
  return row;
}

/// Not there, or killed before the first byte.
bool IsEmpty(const std::filesystem::path& csv) {
  std::error_code error;
  return !std::filesystem::exists(csv, error) ||
         (std::filesystem::is_regular_file(csv, error) && std::filesystem::file_size(csv) == 0);
}

void Write(const std::filesystem::path& file, const std::string& text, std::ios::openmode mode) {
  std::ofstream out(file, std::ios::binary | mode);
  out << text;
  out.close();
  if (!out) throw core::RunError(file.string() + ": cannot be written (is the disk full?)");
}

}  // namespace

std::vector<BenchmarkRow> ReadRows(const std::filesystem::path& csv) {
  std::vector<BenchmarkRow> rows;
  if (IsEmpty(csv)) return rows;
  const std::string text = core::ReadNonEmptyFile(csv);
  int number = 0;
  std::size_t at = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', at)) {
    const std::string_view line(text.data() + at, end - at);
    const std::string where = csv.string() + ":" + std::to_string(++number) + ": ";
    at = end + 1;
    if (number > 1) {
      rows.push_back(ParseLine({where, line}));
    } else if (line != kHeader) {
      throw core::InputError(where + "'" + std::string(line.substr(0, 60)) +
                             "' is not the head of a file of rows, '" + std::string(kHeader) + "'");
    }
  }
  return rows;
}

void AppendRow(const std::filesystem::path& csv, const BenchmarkRow& row) {
  Write(csv, (IsEmpty(csv) ? std::string(kHeader) + "\n" : "") + LineOf(row), std::ios::app);
}

void WriteRows(const std::filesystem::path& csv, const std::vector<BenchmarkRow>& rows) {
  std::string text = std::string(kHeader) + "\n";
  for (const BenchmarkRow& row : rows) text += LineOf(row);
  const std::filesystem::path fresh = csv.string() + ".new";
  Write(fresh, text, std::ios::trunc);
  std::error_code error;
  std::filesystem::rename(fresh, csv, error);
  if (error) throw core::RunError(csv.string() + ": cannot be written: " + error.message());
}

}  // namespace rangegrasp::parts
