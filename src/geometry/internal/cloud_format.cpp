#include "geometry/internal/cloud_format.h"

#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>

#include "base/error.h"
#include "base/words.h"

namespace rangegrasp::geometry::internal {
namespace {

double NumberIn(const LineReader& lines, std::string_view word) {
  const auto value = ParseNumber(word);
  if (!value) lines.Fail("{} is not a number", Quoted(word));
  return *value;
}

Rgb Unpacked(std::uint32_t packed) {
  return {static_cast<std::uint8_t>(packed >> 16), static_cast<std::uint8_t>(packed >> 8),
          static_cast<std::uint8_t>(packed)};
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

/// Of a number: its bytes, and 'f' real, 'i' whole, 'u' whole without a sign.
struct Type {
  std::size_t size;
  char kind;
};

struct Property {
  std::string name;
  Type type;
  std::optional<Type> count;  // of a list
};

struct Element {
  std::string name;
  std::size_t count;
  std::vector<Property> properties;
};

struct PlyHeader {
  std::string format;
  std::size_t points = 0;
  std::size_t faces = 0;
  std::size_t elements = 0;  // of all kinds
  bool has_vertex = false;
  bool in_vertex = false;
  Coordinate xyz[3];
  Coordinate rgb[3];  // those of a byte
  std::size_t columns = 0;
  std::size_t row_bytes = 0;
  std::vector<Element> after;  // behind vertex
};

Type TypeOf(const LineReader& lines, std::string_view word) {
  static const std::map<std::string_view, Type> kTypes = {
      {"char", {1, 'i'}},  {"uchar", {1, 'u'}},   {"int8", {1, 'i'}},   {"uint8", {1, 'u'}},
      {"short", {2, 'i'}}, {"ushort", {2, 'u'}},  {"int16", {2, 'i'}},  {"uint16", {2, 'u'}},
      {"int", {4, 'i'}},   {"uint", {4, 'u'}},    {"int32", {4, 'i'}},  {"uint32", {4, 'u'}},
      {"float", {4, 'f'}}, {"float32", {4, 'f'}}, {"double", {8, 'f'}}, {"float64", {8, 'f'}}};
  const auto type = kTypes.find(word);
  if (type == kTypes.end()) lines.Fail("{} is not a type of PLY", Quoted(word));
  return type->second;
}

void ReadElement(const LineReader& lines, const WordList& words, PlyHeader& header) {
  const auto count = words.size() == 3 ? base::NumberFrom<std::size_t>(words[2]) : std::nullopt;
  if (!count || *count >= kEndOfCounts)
    lines.Fail("an element needs a name and a count below 2^31");
  header.in_vertex = words[1] == "vertex";
  header.elements += *count;
  if (words[1] == "face") header.faces = *count;
  if (header.in_vertex) {
    header.has_vertex = true;
    header.points = *count;
  } else if (!header.has_vertex && *count > 0) {
    lines.Fail("element {} stands before vertex; vertex must come first", Quoted(words[1]));
  } else {
    header.after.push_back({std::string(words[1]), *count, {}});
  }
}

void ReadProperty(const LineReader& lines, const WordList& words, PlyHeader& header) {
  if (!header.in_vertex) {
    const bool list = words.size() == 5 && words[1] == "list";
    if (!list && words.size() != 3) {
      lines.Fail("a property needs a type and a name, or list, two types and a name");
    }
    Property property{std::string(words.back()), TypeOf(lines, words[list ? 3 : 1]), {}};
    if (list) property.count = TypeOf(lines, words[2]);
    if (!header.after.empty()) header.after.back().properties.push_back(std::move(property));
    return;
  }
  if (words.size() != 3) lines.Fail("a property of vertex needs a type and a name, and is no list");
  const Type type = TypeOf(lines, words[1]);
  for (int axis = 0; axis < 3; ++axis) {
    if (words[2] != std::string(1, static_cast<char>('x' + axis))) continue;
    if (type.kind != 'f') {
      lines.Fail("property {} is of type {}; float or double is needed", Quoted(words[2]),
                 Quoted(words[1]));
    }
    header.xyz[axis] = {
        .found = true, .column = header.columns, .offset = header.row_bytes, .size = type.size};
  }
  static constexpr std::string_view kChannels[] = {"red", "green", "blue"};
  for (std::size_t k = 0; k < 3; ++k) {
    if (words[2] != kChannels[k] || type.size != 1) continue;
    header.rgb[k] = {
        .found = true, .column = header.columns, .offset = header.row_bytes, .size = 1};
  }
  ++header.columns;
  header.row_bytes += type.size;
}

/// The color is known where all of its channels are.
ColorPlace ColorOf(const PlyHeader& header) {
  ColorPlace place;
  if (!std::ranges::all_of(header.rgb, &Coordinate::found)) return place;
  place.kind = ColorPlace::Kind::kChannels;
  for (std::size_t k = 0; k < 3; ++k) {
    place.at[k] = header.rgb[k];
    place.at[k].stride = header.row_bytes;
  }
  return place;
}

/// Checks a whole header, and completes its coordinates.
void CheckHeader(const LineReader& lines, PlyHeader& header) {
  if (header.format != "ascii" && header.format != "binary_little_endian" &&
      header.format != "binary_big_endian") {
    lines.Fail("format {} is none of ascii, binary_little_endian, binary_big_endian",
               Quoted(header.format));
  }
  if (!header.has_vertex || header.points == 0) lines.Fail("the cloud has no points");
  for (int axis = 0; axis < 3; ++axis) {
    header.xyz[axis].stride = header.row_bytes;
    if (!header.xyz[axis].found) {
      lines.Fail("element vertex has no property {}; x, y and z are needed",
                 static_cast<char>('x' + axis));
    }
  }
}

PlyHeader ReadPlyHeader(LineReader& lines) {
  PlyHeader header;
  lines.Next();  // "ply"
  for (std::size_t i = 0;; ++i) {
    const auto line = lines.Next();
    if (!line || i >= kMaxHeaderLines) lines.Fail("the header ends without end_header");
    const auto words = Words(*line);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format") {
      header.format = words.size() > 1 ? std::string(words[1]) : "";
    } else if (words[0] == "element") {
      ReadElement(lines, words, header);
    } else if (words[0] == "property") {
      ReadProperty(lines, words, header);
    } else {
      lines.Fail("{} is not a key of a PLY header (format, comment, element, property, end_header)",
                 Quoted(words[0]));
    }
  }
  CheckHeader(lines, header);
  return header;
}

std::size_t LeftIn(std::string_view bytes, const LineReader& lines) {
  return bytes.size() - lines.position();
}

double Load(const Type& type, const char* at, bool swap) {
  switch (type.kind) {
    case 'f':
      return type.size == 4 ? LoadAs<float>(at, swap) : LoadAs<double>(at, swap);
    case 'i':
      return type.size == 1   ? LoadAs<std::int8_t>(at, swap)
             : type.size == 2 ? LoadAs<std::int16_t>(at, swap)
                              : LoadAs<std::int32_t>(at, swap);
    default:
      return type.size == 1   ? LoadAs<std::uint8_t>(at, swap)
             : type.size == 2 ? LoadAs<std::uint16_t>(at, swap)
                              : LoadAs<std::uint32_t>(at, swap);
  }
}

/// The numbers behind the vertices, one after the other.
class Values {
 public:
  Values(std::string_view bytes, std::string_view format, LineReader& lines, std::size_t begin)
      : bytes_(bytes),
        ascii_(format == "ascii"),
        swap_(format == "binary_big_endian"),
        lines_(lines),
        at_(begin) {}

  double Next(const Type& type) {
    if (ascii_) return NextWord();
    if (type.size > bytes_.size() - at_) lines_.Fail("the data end within {}", "an element");
    at_ += type.size;
    return Load(type, bytes_.data() + at_ - type.size, swap_);
  }
  /// The length of a list of numbers of a type, which the file can hold.
  std::size_t NextCount(const Type& count, const Type& type) {
    const double n = Next(count);
    const std::size_t left =
        ascii_ ? LeftIn(bytes_, lines_) + words_.size() : (bytes_.size() - at_) / type.size;
    if (n >= 0.0 && n == std::floor(n) && n <= static_cast<double>(left)) {
      return static_cast<std::size_t>(n);
    }
    lines_.Fail("a list of {} values is declared; the file cannot hold them", n);
  }
  const LineReader& lines() const { return lines_; }

 private:
  double NextWord() {
    while (word_ == words_.size()) {
      const auto line = lines_.Next();
      if (!line) lines_.Fail("the data end within {}", "an element");
      words_ = Words(*line);
      word_ = 0;
    }
    return NumberIn(lines_, words_[word_++]);
  }

  std::string_view bytes_;
  bool ascii_, swap_;
  LineReader& lines_;
  std::size_t at_;
  WordList words_;
  std::size_t word_ = 0;
};

void ReadRow(const Element& element, Values& values, PolygonSoup& soup) {
  for (const Property& property : element.properties) {
    if (!property.count) {
      values.Next(property.type);
      continue;
    }
    const std::size_t n = values.NextCount(*property.count, property.type);
    const bool corners = element.name == "face" &&
                         (property.name == "vertex_indices" || property.name == "vertex_index");
    for (std::size_t k = 0; k < n; ++k) {
      const double vertex = values.Next(property.type);
      if (!corners) continue;
      const auto vertices = static_cast<double>(soup.points.size());
      if (!(vertex >= 0.0 && vertex < vertices && vertex == std::floor(vertex))) {
        values.lines().Fail("face {} names vertex {}; there are {}, from 0", soup.Polygons(),
                            vertex, soup.points.size());
      }
      soup.corner.push_back(static_cast<std::uint32_t>(vertex));
    }
  }
  if (element.name == "face") soup.EndPolygon();
}

/// @return where the data behind the vertices begin, if they are binary.
std::size_t ReadVertices(std::string_view bytes, const PlyHeader& header, LineReader& lines,
                         Points& points, std::vector<Rgb>& colors) {
  const std::size_t begin = lines.position();
  const std::string_view body = bytes.substr(begin);
  const bool ascii = header.format == "ascii";
  const std::size_t needed = ascii ? 2 * header.points - 1 : header.points * header.row_bytes;
  if (body.size() < needed) {
    lines.Fail(
        "the data are {} bytes; the header says {}{}: the file is truncated, or the count of "
        "vertices is wrong",
        body.size(), needed, ascii ? " or more" : "");
  }
  const ColorPlace color = ColorOf(header);
  if (ascii) {
    points = DecodeAscii(lines, header.points, header.columns, header.xyz, color, colors);
  } else {
    const bool swap = header.format == "binary_big_endian";
    points = DecodeBinary(body, header.points, header.xyz, swap);
    colors = DecodeBinaryColors(body, header.points, color, swap);
  }
  return begin + needed;
}

void CheckElements(std::string_view bytes, const PlyHeader& header, const LineReader& lines) {
  if (header.elements <= LeftIn(bytes, lines)) return;
  lines.Fail(
      "the data are {} bytes; the header says {} elements: the file is truncated, or a count is "
      "wrong",
      LeftIn(bytes, lines), header.elements);
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

void LineReader::Throw(const std::string& message) const {
  throw base::InputError(fmt::format("{}:{}: {}", file_.string(), line_, message));
}

WordList Words(std::string_view line) {
  WordList words;
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
    p[static_cast<Eigen::Index>(axis)] = NumberIn(lines, words[axis]);
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

bool IsPly(std::string_view bytes) {
  return bytes.starts_with("ply\n") || bytes.starts_with("ply\r");
}

std::string PlyVertexHeader(std::size_t vertices) {
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n",
      vertices);
}

std::size_t CheckPlyHeader(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  const PlyHeader header = ReadPlyHeader(lines);
  CheckElements(bytes, header, lines);
  return header.faces;
}

PolygonSoup ReadPlyPolygons(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  const PlyHeader header = ReadPlyHeader(lines);
  CheckElements(bytes, header, lines);
  PolygonSoup soup;
  std::vector<Rgb> colors;
  const std::size_t begin = ReadVertices(bytes, header, lines, soup.points, colors);
  Values values(bytes, header.format, lines, begin);
  for (const Element& element : header.after) {
    for (std::size_t i = 0; i < element.count; ++i) ReadRow(element, values, soup);
    if (element.name == "face") break;  // nothing behind it counts
  }
  return soup;
}

CloudFile ReadPlyCloud(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  const PlyHeader header = ReadPlyHeader(lines);
  CloudFile cloud;
  cloud.width = static_cast<int>(header.points);
  ReadVertices(bytes, header, lines, cloud.points, cloud.colors);
  return cloud;
}

}  // namespace rangegrasp::geometry::internal
