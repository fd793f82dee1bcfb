#include "base/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "base/error.h"
#include "base/words.h"

namespace rangegrasp::base {
namespace {

// Removes one record from the front of `rest`; adds the number of its line breaks to `line`.
std::vector<std::string> TakeRecord(std::string_view& rest, int& line, const std::string& name) {
  std::vector<std::string> cells(1);
  const int first_line = line;
  bool quoted = false;
  std::size_t i = 0;
  for (; i < rest.size(); ++i) {
    const char c = rest[i];
    if (c == '\n') ++line;
    if (quoted) {
      if (c != '"') {
        cells.back() += c;
      } else if (i + 1 < rest.size() && rest[i + 1] == '"') {
        cells.back() += rest[++i];
      } else {
        quoted = false;
      }
    } else if (c == '"' && cells.back().empty()) {
      quoted = true;
    } else if (c == ',') {
      cells.emplace_back();
    } else if (c == '\n') {
      break;
    } else if (c != '\r') {
      cells.back() += c;
    }
  }
  if (quoted) throw InputError(fmt::format("{}:{}: missing closing quote", name, first_line));
  rest.remove_prefix(std::min(i + 1, rest.size()));
  return cells;
}

std::string CsvCell(const std::string& cell) {
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

// A larger file would fill the memory of many computers. 50 million points take half of this.
constexpr std::uintmax_t kMaxBytes = std::uintmax_t{2} << 30U;

std::string TooLarge() {
  return fmt::format("has more than {} bytes, the most that is read from a file", kMaxBytes);
}

// Whether a path names a descriptor that this process got open.
bool IsDescriptor(const std::filesystem::path& file) {
  const std::string name = file.string();
  return name == "/dev/stdin" || name.starts_with("/dev/fd/") || name.starts_with("/proc/");
}

std::ifstream Opened(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found) {
    throw InputError(file.string() + ": no such file");
  }
  std::string why = WhyUnfit(file);
  if (why.empty() && std::filesystem::file_size(file, error) > kMaxBytes && !error) {
    why = TooLarge();
  }
  if (!why.empty()) throw InputError(file.string() + ": " + why);
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    throw InputError(file.string() + ": cannot be opened for reading: " + std::strerror(errno));
  }
  return in;
}

// Writes all bytes; with `sync` waits until they are on the disk, so that a file renamed afterwards
// is whole even after a power failure. @return 0, or errno of what failed.
int WriteBytes(const std::filesystem::path& file, std::string_view bytes, bool sync) {
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) return errno;
  int failed = 0;
  while (!bytes.empty() && failed == 0) {
    const ssize_t n = write(fd, bytes.data(), bytes.size());
    if (n >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(n));
    } else if (errno != EINTR) {
      failed = errno;
    }
  }
  if (failed == 0 && sync && fsync(fd) != 0) failed = errno;
  if (close(fd) != 0 && failed == 0) failed = errno;  // a full disk may be reported only here
  return failed;
}

}  // namespace

void CheckReadable(const std::filesystem::path& file) { Opened(file); }

std::string ReadAll(std::istream& in) {
  std::string bytes;
  std::string block(std::size_t{1} << 16U, '\0');
  while (in) {
    in.read(block.data(), std::ssize(block));
    const auto count = static_cast<std::size_t>(in.gcount());
    if (bytes.size() + count > kMaxBytes) throw InputError(TooLarge());
    bytes.append(block, 0, count);
  }
  if (in.bad()) throw InputError("reading failed before the end of the file");
  return bytes;
}

std::string ReadFile(const std::filesystem::path& file) {
  std::ifstream in = Opened(file);
  try {
    return ReadAll(in);
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

std::string WhyUnfit(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (std::filesystem::is_directory(status)) return "is a folder; a file is needed";
  if (!std::filesystem::is_fifo(status) || IsDescriptor(file)) return "";
  return "is a named pipe; a file is needed";
}

std::string TextOf(const std::filesystem::filesystem_error& error) {
  const bool is_named = !error.path1().empty();
  return (is_named ? error.path1().string() : "the current folder") + ": " + error.code().message();
}

std::string ReadNonEmptyFile(const std::filesystem::path& file) {
  std::string bytes = ReadFile(file);
  if (bytes.empty()) throw InputError(file.string() + ": is empty");
  return bytes;
}

void WriteFile(const std::filesystem::path& file, std::string_view bytes) {
  MakeFolderOf(file);
  std::error_code error;
  // A device or a pipe (/dev/stdout, /dev/full) is written in place, not replaced.
  const auto status = std::filesystem::status(file, error);
  const bool in_place =
      std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
  std::filesystem::path target = file;
  if (!in_place) target += fmt::format(".part{}", getpid());
  int failed = WriteBytes(target, bytes, !in_place);
  if (failed == 0 && (in_place || rename(target.c_str(), file.c_str()) == 0)) return;
  if (failed == 0) failed = errno;
  if (!in_place) std::filesystem::remove(target, error);
  throw RunError(
      fmt::format("{}: could not be written completely ({} bytes): {} (is the disk full, or the "
                  "folder not writable?)",
                  file.string(), bytes.size(), std::strerror(failed)));
}

void MakeFolderOf(const std::filesystem::path& file) {
  if (!file.has_parent_path()) return;
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  if (error) {
    throw InputError(file.parent_path().string() +
                     ": the folder cannot be created: " + error.message());
  }
}

void CheckUtf8(std::string_view text, const std::string& name) {
  if (IsUtf8(text)) return;
  int line = 1;
  for (const std::string& one : Split(text, '\n')) {
    if (!IsUtf8(one)) break;
    ++line;
  }
  throw InputError(fmt::format("{}:{}: is not UTF-8; save the file as UTF-8", name, line));
}

std::string EndingOf(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return ending;
}

CsvTable CsvTable::Parse(std::string_view text, const std::string& name) {
  CheckUtf8(text, name);
  CsvTable table;
  table.name_ = name;
  int line = 1;
  while (!text.empty()) {
    const int at = line;
    auto cells = TakeRecord(text, line, name);
    if (cells.size() == 1 && cells[0].empty()) continue;
    if (table.header_.empty()) {
      table.header_ = std::move(cells);
      continue;
    }
    if (cells.size() != table.header_.size()) {
      throw InputError(fmt::format("{}:{}: has {}; there must be {}: {}", name, at,
                                   Counted(std::ssize(cells), "cell"), table.header_.size(),
                                   Join(table.header_, ",")));
    }
    table.rows_.push_back({at, std::move(cells)});
  }
  if (table.header_.empty()) {
    throw InputError(name + ": is empty; it needs a header line with column names");
  }
  return table;
}

CsvTable CsvTable::Read(const std::filesystem::path& file) {
  return Parse(ReadFile(file), file.string());
}

std::size_t CsvTable::Column(const std::string& name) const {
  const auto found = std::ranges::find(header_, name);
  if (found != header_.end()) return static_cast<std::size_t>(found - header_.begin());
  throw InputError(fmt::format("{}: lacks the column '{}'; its columns are {}{}", name_, name,
                               Join(header_), Suggestion(name, header_, " (nearest: {})")));
}

double CsvTable::Number(std::size_t row, std::size_t column) const {
  const auto value = NumberFrom<double>(Cell(row, column));
  if (!value || !std::isfinite(*value)) Fail(row, column, "must be a number");
  return *value;
}

std::optional<double> CsvTable::OptionalNumber(std::size_t row, std::size_t column) const {
  if (Cell(row, column).empty()) return std::nullopt;
  return Number(row, column);
}

void CsvTable::Fail(std::size_t row, std::size_t column, const std::string& what) const {
  throw InputError(fmt::format("{}:{}: column '{}': '{}' {}", name_, rows_[row].line,
                               header_[column], Excerpt(Cell(row, column)), what));
}

std::string CsvLine(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) line += (i > 0 ? "," : "") + CsvCell(cells[i]);
  return line + "\n";
}

std::uint64_t Fnv1a(std::string_view bytes, std::uint64_t state) {
  for (const unsigned char c : bytes) state = (state ^ c) * 0x100000001b3u;
  return state;
}

std::string Hex(std::uint64_t value) { return fmt::format("{:016x}", value); }

}  // namespace rangegrasp::base
