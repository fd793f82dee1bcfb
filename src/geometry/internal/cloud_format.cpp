#include "geometry/internal/cloud_format.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstring>

#include "base/error.h"

namespace rangegrasp::geometry::internal {
std::optional<std::string_view> LineReader::Next() {
  if (position_ >= text_.size()) return std::nullopt;
  ++line_;
  const std::size_t end = std::min(text_.find('\n', position_), text_.size());
  std::string_view line = text_.substr(position_, end - position_);
  position_ = std::min(end + 1, text_.size());
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

void LineReader::Throw(const std::string& message) const {
  throw base::InputError(fmt::format("{}:{}: {}", file_.string(), line_, message));
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

std::optional<double> ParseNumber(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty()) return std::nullopt;
  if (error == std::errc::result_out_of_range) return value;
  if (error != std::errc()) return std::nullopt;
  return value;
}

Eigen::Vector3d PointFrom(const LineReader& lines, std::span<const std::string_view> words) {
  Eigen::Vector3d p;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto value = ParseNumber(words[axis]);
    if (!value) lines.Fail("{} is not a number", Quoted(words[axis]));
    p[static_cast<Eigen::Index>(axis)] = *value;
  }
  return p;
}

std::string Quoted(std::string_view word) {
  constexpr std::size_t kMaxLength = 40;  // a message stays on one line
  std::string text = "\"";
  for (const char c : word.substr(0, kMaxLength)) {
    text += std::isprint(static_cast<unsigned char>(c)) != 0 ? c : '?';
  }
  return text + (word.size() > kMaxLength ? "...\"" : "\"");
}

namespace {

Rgb Unpacked(std::uint32_t packed) {
  return {static_cast<std::uint8_t>(packed >> 16), static_cast<std::uint8_t>(packed >> 8),
          static_cast<std::uint8_t>(packed)};
}

double NumberIn(const LineReader& lines, std::string_view word) {
  const auto value = ParseNumber(word);
  if (!value) lines.Fail("{} is not a number", Quoted(word));
  return *value;
}

Rgb ColorIn(const LineReader& lines, std::span<const std::string_view> words,
            const ColorPlace& place) {
  const double first = NumberIn(lines, words[place.at[0].column]);
  switch (place.kind) {
    case ColorPlace::Kind::kPackedAsFloat:
      return Unpacked(std::bit_cast<std::uint32_t>(static_cast<float>(first)));
    case ColorPlace::Kind::kPacked:
      return Unpacked(static_cast<std::uint32_t>(
          static_cast<std::int64_t>(std::clamp(first, -2147483648.0, 4294967295.0))));
    default:
      break;
  }
  Rgb color;
  for (std::size_t k = 0; k < color.size(); ++k) {
    const double level = NumberIn(lines, words[place.at[k].column]);
    color[k] = static_cast<std::uint8_t>(std::clamp(level, 0.0, 255.0));
  }
  return color;
}

}  // namespace

std::vector<Rgb> DecodeBinaryColors(std::string_view data, std::size_t points,
                                    const ColorPlace& place, bool swap_bytes) {
  if (place.kind == ColorPlace::Kind::kNone) return {};
  std::vector<Rgb> colors(points);
  const auto bytes_at = [&data](const Coordinate& c, std::size_t i) {
    return data.data() + c.start + c.offset + i * c.stride;
  };
  for (std::size_t i = 0; i < points; ++i) {
    if (place.kind == ColorPlace::Kind::kChannels) {
      for (std::size_t k = 0; k < 3; ++k) {
        colors[i][k] = static_cast<std::uint8_t>(*bytes_at(place.at[k], i));
      }
    } else {
      colors[i] = Unpacked(
          static_cast<std::uint32_t>(LoadAs<std::uint32_t>(bytes_at(place.at[0], i), swap_bytes)));
    }
  }
  return colors;
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
          c.size == 4 ? LoadAs<float>(value, swap_bytes) : LoadAs<double>(value, swap_bytes);
    }
  }
  return decoded;
}

Points DecodeAscii(LineReader& lines, std::size_t points, std::size_t columns,
                   const Coordinate (&xyz)[3], const ColorPlace& place, std::vector<Rgb>& colors) {
  Points decoded;
  decoded.reserve(points);
  while (decoded.size() < points) {
    const auto line = lines.Next();
    if (!line) {
      lines.Fail("the data end after {} points; the header says {}", decoded.size(), points);
    }
    const auto words = Words(*line);
    if (words.empty()) continue;
    if (words.size() < columns) {
      lines.Fail("a point has {} values; the header names {}", words.size(), columns);
    }
    Eigen::Vector3d p;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      p[axis] = NumberIn(lines, words[xyz[axis].column]);
    decoded.push_back(p);
    if (place.kind != ColorPlace::Kind::kNone) colors.push_back(ColorIn(lines, words, place));
  }
  return decoded;
}

void AppendPoint(const Eigen::Vector3d& p, std::string& bytes) {
  for (const double value : p) AppendRaw(static_cast<float>(value), bytes);
}

}  // namespace rangegrasp::geometry::internal
