#include "geometry/internal/ply.h"

#include <map>

#include "core/number.h"
#include "geometry/internal/cloud_format.h"

namespace rangegrasp::geometry::internal {
namespace {

struct Header {
  std::string format;
  std::size_t points = 0;
  std::size_t faces = 0;
  std::size_t elements = 0;  // of all kinds
  bool has_vertex = false;
  bool in_vertex = false;
  Coordinate xyz[3];
  std::size_t columns = 0;
  std::size_t row_bytes = 0;
};

std::size_t TypeSize(const LineReader& lines, std::string_view type) {
  static const std::map<std::string_view, std::size_t> kSizes = {
      {"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
      {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  const auto size = kSizes.find(type);
  if (size == kSizes.end()) lines.Fail("{} is not a type of PLY", Quoted(type));
  return size->second;
}

bool IsReal(std::string_view type) {
  return type == "float" || type == "float32" || type == "double" || type == "float64";
}

void ReadElement(const LineReader& lines, const std::vector<std::string_view>& words,
                 Header& header) {
  const auto count = words.size() == 3 ? core::NumberFrom<std::size_t>(words[2]) : std::nullopt;
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
  }
}

void ReadProperty(const LineReader& lines, const std::vector<std::string_view>& words,
                  Header& header) {
  if (!header.in_vertex) {
    const bool list = words.size() == 5 && words[1] == "list";
    if (!list && words.size() != 3) {
      lines.Fail("a property needs a type and a name, or list, two types and a name");
    }
    TypeSize(lines, words[list ? 2 : 1]);
    if (list) TypeSize(lines, words[3]);
    return;
  }
  if (words.size() != 3) lines.Fail("a property of vertex needs a type and a name, and is no list");
  const std::size_t size = TypeSize(lines, words[1]);
  for (int axis = 0; axis < 3; ++axis) {
    if (words[2] != std::string(1, static_cast<char>('x' + axis))) continue;
    if (!IsReal(words[1])) {
      lines.Fail("property {} is of type {}; float or double is needed", Quoted(words[2]),
                 Quoted(words[1]));
    }
    Coordinate& c = header.xyz[axis];
    c.found = true;
    c.column = header.columns;
    c.offset = header.row_bytes;
    c.size = size;
  }
  ++header.columns;
  header.row_bytes += size;
}

Header ReadHeader(LineReader& lines) {
  Header header;
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
  return header;
}

void Check(const LineReader& lines, Header& header) {
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

}  // namespace

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
  Header header = ReadHeader(lines);
  Check(lines, header);
  if (header.elements > bytes.size() - lines.position()) {
    lines.Fail(
        "the data are {} bytes; the header says {} elements: the file is truncated, or a count is "
        "wrong",
        bytes.size() - lines.position(), header.elements);
  }
  return header.faces;
}

CloudFile ReadPlyCloud(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  Header header = ReadHeader(lines);
  Check(lines, header);
  const std::string_view body = bytes.substr(lines.position());
  const bool ascii = header.format == "ascii";
  const std::size_t needed = ascii ? 2 * header.points - 1 : header.points * header.row_bytes;
  if (body.size() < needed) {
    lines.Fail(
        "the data are {} bytes; the header says {}{}: the file is truncated, or the count of "
        "vertices is wrong",
        body.size(), needed, ascii ? " or more" : "");
  }
  CloudFile cloud;
  cloud.width = static_cast<int>(header.points);
  cloud.points =
      ascii ? DecodeAscii(lines, header.points, header.columns, header.xyz)
            : DecodeBinary(body, header.points, header.xyz, header.format == "binary_big_endian");
  return cloud;
}

}  // namespace rangegrasp::geometry::internal
