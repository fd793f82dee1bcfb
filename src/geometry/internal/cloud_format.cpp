#include "geometry/internal/cloud_format.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"

namespace rangegrasp::geometry::internal {
namespace {

double NumberIn(const LineReader& lines, std::string_view word) {
  const auto value = ParseNumber(word);
  if (!value) lines.Fail("{} is not a number", Quoted(word));
  return *value;
}

/// Parses a number of a type; for an integer type it must be whole and in range.
double NumberOf(const LineReader& lines, const Type& type, std::string_view word) {
  const double value = NumberIn(lines, word);
  if (type.kind == 'f') return value;
  const double end = std::ldexp(1.0, static_cast<int>(8 * type.size) - (type.kind == 'i' ? 1 : 0));
  if (value == std::floor(value) && value >= (type.kind == 'i' ? -end : 0.0) && value < end) {
    return value;
  }
  lines.Fail("{} does not fit the type in the header, a whole number of {} byte(s) {} a sign",
             Quoted(word), type.size, type.kind == 'i' ? "with" : "without");
}

Rgb Unpacked(double packed, const Type& type) {
  const auto bits = type.kind == 'f' ? std::bit_cast<std::uint32_t>(static_cast<float>(packed))
                                     : static_cast<std::uint32_t>(static_cast<std::int64_t>(
                                           std::clamp(packed, -2147483648.0, 4294967295.0)));
  return {static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 8),
          static_cast<std::uint8_t>(bits)};
}

/// @param value  value(place) is the point's number at that place
template <class Value>
void AppendPointFrom(const Layout& layout, const Value& value, CloudFile& cloud) {
  const auto& [x, y, z] = layout.xyz;
  cloud.points.push_back({value(x), value(y), value(z)});  // braces: evaluated in this order
  if (layout.label) {
    constexpr double kMax = std::numeric_limits<std::uint32_t>::max();
    cloud.labels.push_back(static_cast<std::uint32_t>(std::clamp(value(*layout.label), 0.0, kMax)));
  }
  const auto& color = layout.color;
  if (color.empty()) return;
  if (color.size() == 1) {
    cloud.colors.push_back(Unpacked(value(color.front()), color.front().type));
    return;
  }
  auto& channels = cloud.colors.emplace_back();
  std::ranges::transform(color, channels.begin(), [&](const Place& place) {
    return static_cast<std::uint8_t>(std::clamp(value(place), 0.0, 255.0));
  });
}

struct Property {
  std::string name;
  Type type;
  std::optional<Type> count;  // for a list: type of its length
};

struct Element {
  std::string name;
  std::size_t count;
  std::vector<Property> properties;
};

struct PlyHeader {
  std::string format;
  std::size_t faces = 0;
  std::size_t elements = 0;  // of all kinds
  bool has_vertex = false;
  bool in_vertex = false;
  Layout vertex;
  std::vector<Element> after;  // after vertex
  std::optional<Eigen::Vector3d> viewpoint;

  bool IsAscii() const { return format == "ascii"; }
  bool IsLast() const { return elements == vertex.points; }  // no data after the vertices
  bool IsSwapped() const { return format == "binary_big_endian"; }
};

Type TypeOf(const LineReader& lines, std::string_view word) {
  static const std::map<std::string_view, Type> kTypes = {
      {"char", {1, 'i'}},  {"uchar", {1, 'u'}},   {"int8", {1, 'i'}},   {"uint8", {1, 'u'}},
      {"short", {2, 'i'}}, {"ushort", {2, 'u'}},  {"int16", {2, 'i'}},  {"uint16", {2, 'u'}},
      {"int", {4, 'i'}},   {"uint", {4, 'u'}},    {"int32", {4, 'i'}},  {"uint32", {4, 'u'}},
      {"float", {4, 'f'}}, {"float32", {4, 'f'}}, {"double", {8, 'f'}}, {"float64", {8, 'f'}}};
  const auto type = kTypes.find(word);
  if (type == kTypes.end()) lines.Fail("{} is not a PLY type", Quoted(word));
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
    header.vertex.points = *count;
  } else if (!header.has_vertex && *count > 0) {
    lines.Fail("element {} comes before vertex; vertex must come first", Quoted(words[1]));
  } else {
    header.after.push_back({std::string(words[1]), *count, {}});
  }
}

void ReadVertexProperty(const LineReader& lines, const WordList& words, PlyHeader& header) {
  if (words.size() != 3)
    lines.Fail("a property of vertex needs a type and a name; it must not be a list");
  Layout& vertex = header.vertex;
  const Type type = TypeOf(lines, words[1]);
  const auto axis = std::ranges::find(kAxes, words[2]) - kAxes.begin();
  if (axis < 3) {
    if (type.kind != 'f') {
      lines.Fail("property {} is of type {}; float or double is needed", Quoted(words[2]),
                 Quoted(words[1]));
    }
    vertex.xyz[static_cast<std::size_t>(axis)] = {type, vertex.columns.size(), vertex.row_bytes};
  }
  static constexpr std::array<std::string_view, 3> kChannels = {"red", "green", "blue"};
  const auto channel = std::ranges::find(kChannels, words[2]) - kChannels.begin();
  if (channel < 3 && type.size == 1) {
    vertex.color.resize(3);
    vertex.color[static_cast<std::size_t>(channel)] = {
        {1, 'u'}, vertex.columns.size(), vertex.row_bytes};
  }
  vertex.columns.push_back(type);
  vertex.row_bytes += type.size;
}

void ReadProperty(const LineReader& lines, const WordList& words, PlyHeader& header) {
  if (header.in_vertex) return ReadVertexProperty(lines, words, header);
  const bool list = words.size() == 5 && words[1] == "list";
  if (!list && words.size() != 3) {
    lines.Fail("a property needs a type and a name, or list, two types and a name");
  }
  Property property{std::string(words.back()), TypeOf(lines, words[list ? 3 : 1]), {}};
  if (list) property.count = TypeOf(lines, words[2]);
  if (!header.after.empty()) header.after.back().properties.push_back(std::move(property));
}

bool IsMissing(const Place& place) { return place.type.size == 0; }

/// Checks a whole header, and drops a color with a missing channel.
void CheckHeader(const LineReader& lines, PlyHeader& header) {
  if (!header.IsAscii() && !header.IsSwapped() && header.format != "binary_little_endian") {
    lines.Fail("format {} is not one of ascii, binary_little_endian, binary_big_endian",
               Quoted(header.format));
  }
  if (header.vertex.points == 0) lines.Fail("the cloud has no points");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!IsMissing(header.vertex.xyz[axis])) continue;
    lines.Fail("element vertex has no property {}; x, y and z are needed", kAxes[axis]);
  }
  if (std::ranges::any_of(header.vertex.color, IsMissing)) header.vertex.color.clear();
}

PlyHeader ReadPlyHeader(LineReader& lines) {
  PlyHeader header;
  lines.Next();  // "ply"
  for (std::size_t i = 0;; ++i) {
    const auto line = lines.Next();
    if (!line || i >= kMaxHeaderLines) lines.Fail("the header ends without end_header");
    const auto words = Words(*line);
    if (words.empty() || words[0] == "obj_info") continue;
    if (words[0] == "comment") {
      // Ours is "viewpoint x y z"; others may use the word, too.
      const bool ours = words.size() == 5 && words[1] == "viewpoint";
      const auto place = ours ? ParsePoint(std::span(words).subspan(2)) : std::nullopt;
      if (place && place->allFinite()) header.viewpoint = place;
      continue;
    }
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

/// The number with these bytes, which are reversed if `swap_bytes`.
template <class T>
double LoadAs(const char* bytes, bool swap_bytes) {
  std::array<char, sizeof(T)> copy;
  std::memcpy(copy.data(), bytes, sizeof(T));
  if (swap_bytes) std::ranges::reverse(copy);
  return static_cast<double>(std::bit_cast<T>(copy));
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

/// Reads the numbers after the vertices, one after the other.
class Values {
 public:
  Values(std::string_view data, const PlyHeader& header, LineReader& lines)
      : data_(data), ascii_(header.IsAscii()), swap_(header.IsSwapped()), lines_(lines) {}

  double Next(const Type& type) {
    if (ascii_) return NextWord();
    if (type.size > data_.size()) FailAtEnd();
    const double value = Load(type, data_.data(), swap_);
    data_.remove_prefix(type.size);
    return value;
  }
  /// The length of a list of numbers of a type; fails if the file is too short for it.
  std::size_t NextCount(const Type& count, const Type& type) {
    const double n = Next(count);
    const std::size_t left =
        ascii_ ? lines_.Rest().size() + words_.size() : data_.size() / type.size;
    if (n >= 0.0 && n == std::floor(n) && n <= static_cast<double>(left)) {
      return static_cast<std::size_t>(n);
    }
    lines_.Fail("a list of {} values is declared; the file is too short for them", n);
  }
  const LineReader& lines() const { return lines_; }

 private:
  [[noreturn]] void FailAtEnd() const { lines_.Fail("the data end within an element"); }

  double NextWord() {
    while (word_ == words_.size()) {
      const auto line = lines_.Next();
      if (!line) FailAtEnd();
      words_ = Words(*line);
      word_ = 0;
    }
    return NumberIn(lines_, words_[word_++]);
  }

  std::string_view data_;  // remaining binary data
  bool ascii_, swap_;
  LineReader& lines_;
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
        values.lines().Fail("face {} uses vertex {}; there are {}, from 0", soup.Polygons(), vertex,
                            soup.points.size());
      }
      soup.corner.push_back(static_cast<std::uint32_t>(vertex));
    }
  }
  if (element.name == "face") soup.EndPolygon();
}

/// @return the data after the vertices, if they are binary.
std::string_view ReadVertices(const PlyHeader& header, LineReader& lines, CloudFile& cloud) {
  const Layout& vertex = header.vertex;
  const bool ascii = header.IsAscii();
  const std::string_view body = lines.Rest();
  const std::size_t needed = ascii ? 2 * vertex.points - 1 : vertex.points * vertex.row_bytes;
  if (body.size() < needed || (!ascii && header.IsLast())) CheckSize(lines, body.size(), needed);
  if (ascii) {
    ReadAsciiPoints(lines, vertex, cloud);
    if (header.IsLast()) CheckEnd(lines);
  } else {
    ReadBinaryPoints(body, vertex, header.IsSwapped(), cloud);
  }
  return body.substr(needed);
}

void CheckElements(const PlyHeader& header, const LineReader& lines) {
  if (header.elements <= lines.Rest().size()) return;
  lines.Fail(
      "the data have {} bytes; the header says {} elements: the file is truncated, or a count is "
      "wrong",
      lines.Rest().size(), header.elements);
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
  if (error == std::errc::result_out_of_range) {  // gives infinity or zero
    return std::strtod(std::string(word).c_str(), nullptr);
  }
  if (error != std::errc()) return std::nullopt;
  return value;
}

std::optional<Eigen::Vector3d> ParsePoint(std::span<const std::string_view> words) {
  Eigen::Vector3d p;
  for (int axis = 0; axis < 3; ++axis) {
    const auto value = axis < std::ssize(words) ? ParseNumber(words[axis]) : std::nullopt;
    if (!value) return std::nullopt;
    p[axis] = *value;
  }
  return p;
}

Eigen::Vector3d PointFrom(const LineReader& lines, std::span<const std::string_view> words) {
  Eigen::Vector3d p;
  for (int axis = 0; axis < 3; ++axis) p[axis] = NumberIn(lines, words[axis]);
  return p;
}

void CheckPlace(const std::filesystem::path& file, const std::string& what,
                const Eigen::Vector3d& p, double max) {
  if (!p.allFinite()) throw base::InputError(file.string() + ": " + what + " is not finite");
  if (p.cwiseAbs().maxCoeff() <= max) return;
  throw base::InputError(
      fmt::format("{}: {} is at {:g} {:g} {:g}, beyond {:g}: the file is damaged, or its "
                  "coordinates have another unit",
                  file.string(), what, p.x(), p.y(), p.z(), max));
}

std::string Quoted(std::string_view word) {
  constexpr std::size_t kMaxLength = 40;  // keeps a message on one line
  std::string text = "\"";
  for (const char c : word.substr(0, kMaxLength)) {
    text += std::isprint(static_cast<unsigned char>(c)) != 0 ? c : '?';
  }
  return text + (word.size() > kMaxLength ? "...\"" : "\"");
}

void ReadAsciiPoints(LineReader& lines, const Layout& layout, CloudFile& cloud) {
  cloud.points.reserve(layout.points);
  std::vector<double> values(layout.columns.size());
  while (cloud.points.size() < layout.points) {
    const auto line = lines.Next();
    if (!line) {
      lines.Fail("the data end after {}; the header says {}",
                 base::Counted(cloud.points.size(), "point"), layout.points);
    }
    const auto words = Words(*line);
    if (words.empty()) continue;
    if (words.size() != layout.columns.size()) {
      lines.Fail("a point has {} values; the header lists {}", words.size(), layout.columns.size());
    }
    for (std::size_t i = 0; i < words.size(); ++i) {
      values[i] = NumberOf(lines, layout.columns[i], words[i]);
    }
    AppendPointFrom(
        layout, [&](const Place& place) { return values[place.column]; }, cloud);
  }
}

void CheckEnd(LineReader& lines) {
  while (const auto line = lines.Next()) {
    if (!Words(*line).empty()) lines.Fail("more data follow than the header says");
  }
}

void CheckSize(const LineReader& lines, std::size_t is, std::size_t needed) {
  if (is == needed) return;
  lines.Fail("the data have {} bytes; the header says {}: {}, or a count in the header is wrong",
             is, needed, is < needed ? "the file is truncated" : "bytes were inserted");
}

void ReadBinaryPoints(std::string_view data, const Layout& layout, bool swap_bytes,
                      CloudFile& cloud) {
  cloud.points.reserve(layout.points);
  for (std::size_t i = 0; i < layout.points; ++i) {
    const auto value = [&](const Place& place) {
      const std::size_t stride = layout.by_field ? place.type.size : layout.row_bytes;
      return Load(place.type, data.data() + place.start + i * stride, swap_bytes);
    };
    AppendPointFrom(layout, value, cloud);
  }
}

void AppendPoint(const Eigen::Vector3d& p, std::string& bytes) {
  for (const double value : p) AppendRaw(static_cast<float>(value), bytes);
}

bool IsPly(const std::filesystem::path& file, std::string_view bytes) {
  if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r")) return true;
  if (base::EndingOf(file) != ".ply") return false;
  throw base::InputError(file.string() + ":1: a PLY file starts with the line \"ply\"");
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
  CheckElements(header, lines);
  return header.faces;
}

PolygonSoup ReadPlyPolygons(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  const PlyHeader header = ReadPlyHeader(lines);
  CheckElements(header, lines);
  CloudFile cloud;
  const std::string_view behind = ReadVertices(header, lines, cloud);
  PolygonSoup soup;
  soup.points = std::move(cloud.points);
  Values values(behind, header, lines);
  for (const Element& element : header.after) {
    for (std::size_t i = 0; i < element.count; ++i) ReadRow(element, values, soup);
    if (element.name == "face") break;  // later elements are not used
  }
  return soup;
}

CloudFile ReadPlyCloud(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  const PlyHeader header = ReadPlyHeader(lines);
  CloudFile cloud;
  cloud.width = static_cast<int>(header.vertex.points);
  cloud.sensor_origin = header.viewpoint;
  ReadVertices(header, lines, cloud);
  return cloud;
}

}  // namespace rangegrasp::geometry::internal
