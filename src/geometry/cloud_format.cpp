#include "geometry/internal/cloud_format.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>

#include "core/error.h"

namespace rangegrasp::geometry::internal {
namespace {

template <class T>
double Load(const char* bytes, bool swap_bytes) {
  char copy[sizeof(T)];
  std::memcpy(copy, bytes, sizeof(T));
  if (swap_bytes) std::reverse(copy, copy + sizeof(T));
  T value;
  std::memcpy(&value, copy, sizeof(T));
  return static_cast<double>(value);
}

}  // namespace

std::optional<std::string_view> LineReader::Next() {
  if (position_ >= text_.size()) return std::nullopt;
  ++line_;
  const std::size_t end = std::min(text_.find('\n', position_), text_.size());
  std::string_view line = text_.substr(position_, end - position_);
  position_ = std::min(end + 1, text_.size());
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

void LineReader::Fail(const std::string& message) const {
  throw core::InputError(file_.string() + ":" + std::to_string(line_) + ": " + message);
}

std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view kSpace = " \t\r\v\f";
  std::size_t begin = line.find_first_not_of(kSpace);
  while (begin != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(kSpace, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSpace, end);
  }
  return words;
}

std::optional<std::size_t> ParseCount(std::string_view word) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::optional<double> ParseNumber(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty()) return std::nullopt;
  if (error == std::errc::result_out_of_range) return value;
  if (error != std::errc()) return std::nullopt;
  return value;
}

std::string Quoted(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string text = "\"";
  for (const char c : word.substr(0, kLongest)) {
    text += std::isprint(static_cast<unsigned char>(c)) != 0 ? c : '?';
  }
  return text + (word.size() > kLongest ? "...\"" : "\"");
}

Points DecodeBinary(std::string_view data, std::size_t points, const Coordinate (&xyz)[3],
                    bool swap_bytes) {
  Points decoded(points);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Coordinate& c = xyz[axis];
    const char* at = data.data() + c.start + c.offset;
    for (std::size_t i = 0; i < points; ++i) {
      const char* value = at + i * c.stride;
      decoded[i][axis] =
          c.size == 4 ? Load<float>(value, swap_bytes) : Load<double>(value, swap_bytes);
    }
  }
  return decoded;
}

Points DecodeAscii(LineReader& lines, std::size_t points, std::size_t columns,
                   const Coordinate (&xyz)[3]) {
  Points decoded;
  decoded.reserve(points);
  while (decoded.size() < points) {
    const auto line = lines.Next();
    if (!line) {
      lines.Fail("the data end after " + std::to_string(decoded.size()) +
                 " points; the header says " + std::to_string(points));
    }
    const auto words = Words(*line);
    if (words.empty()) continue;
    if (words.size() < columns) {
      lines.Fail("a point has " + std::to_string(words.size()) + " values; the header names " +
                 std::to_string(columns));
    }
    Eigen::Vector3d p;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const std::string_view word = words[xyz[axis].column];
      const auto value = ParseNumber(word);
      if (!value) lines.Fail(Quoted(word) + " is not a number");
      p[axis] = *value;
    }
    decoded.push_back(p);
  }
  return decoded;
}

std::optional<std::string> ExpandLzf(std::string_view data, std::size_t size) {
  std::string out;
  out.reserve(size);
  std::size_t at = 0;
  const auto byte = [&data](std::size_t i) { return static_cast<unsigned char>(data[i]); };
  while (at < data.size()) {
    const unsigned control = byte(at++);
    if (control < 32) {  // a run of control + 1 bytes as they are
      const std::size_t run = control + 1;
      if (data.size() - at < run || size - out.size() < run) return std::nullopt;
      out.append(data.substr(at, run));
      at += run;
      continue;
    }
    // A copy of earlier output: 3 bits of length (7: one more byte), 13 bits of distance.
    std::size_t length = control >> 5;
    if (length == 7) {
      if (at >= data.size()) return std::nullopt;
      length += byte(at++);
    }
    length += 2;
    if (at >= data.size()) return std::nullopt;
    const std::size_t distance = ((control & 31u) << 8) + byte(at++) + 1;
    if (distance > out.size() || size - out.size() < length) return std::nullopt;
    // It may overlap with what it writes.
    for (std::size_t i = 0; i < length; ++i) out.push_back(out[out.size() - distance]);
  }
  if (out.size() != size) return std::nullopt;
  return out;
}

}  // namespace rangegrasp::geometry::internal
