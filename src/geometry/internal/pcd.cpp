#include "geometry/internal/pcd.h"

#include <cstdint>
#include <cstring>
#include <limits>

#include "base/number.h"
#include "geometry/internal/cloud_format.h"

namespace rangegrasp::geometry::internal {
namespace {

struct Field {
  std::string name;
  std::size_t size = 4;
  char type = 'F';
  std::size_t count = 1;
};

struct Header {
  std::vector<Field> fields;
  std::optional<std::size_t> width;
  std::optional<std::size_t> height;
  std::optional<std::size_t> points;
  std::optional<Eigen::Vector3d> viewpoint;
  std::string data;
};

using WordList = std::vector<std::string_view>;

void NeedPerField(const LineReader& lines, const WordList& words, const Header& header) {
  if (header.fields.empty()) lines.Fail("{} stands before FIELDS", Quoted(words[0]));
  if (words.size() != header.fields.size() + 1) {
    lines.Fail("{} has {} values; there are {} FIELDS", words[0], words.size() - 1,
               header.fields.size());
  }
}

std::size_t CountOf(const LineReader& lines, const WordList& words, std::size_t i,
                    std::size_t min) {
  const auto value = i < words.size() ? base::NumberFrom<std::size_t>(words[i]) : std::nullopt;
  if (!value || *value < min || *value >= kEndOfCounts) {
    lines.Fail("{} is {}; a whole number from {} to {} is needed", words[0],
               i < words.size() ? Quoted(words[i]) : "missing", min, kEndOfCounts - 1);
  }
  return *value;
}

void ReadType(const LineReader& lines, const WordList& words, Header& header) {
  NeedPerField(lines, words, header);
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i] != "F" && words[i] != "U" && words[i] != "I") {
      lines.Fail("TYPE {} is none of F, U, I", Quoted(words[i]));
    }
    header.fields[i - 1].type = words[i][0];
  }
}

void ReadSize(const LineReader& lines, const WordList& words, Header& header) {
  NeedPerField(lines, words, header);
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::size_t size = CountOf(lines, words, i, 1);
    if (size != 1 && size != 2 && size != 4 && size != 8) {
      lines.Fail("SIZE {} is none of 1, 2, 4, 8", Quoted(words[i]));
    }
    header.fields[i - 1].size = size;
  }
}

void ReadViewpoint(const LineReader& lines, const WordList& words, Header& header) {
  Eigen::Vector3d origin;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = i + 1 < words.size() ? ParseNumber(words[i + 1]) : std::nullopt;
    if (!value) lines.Fail("VIEWPOINT needs seven numbers: x y z and a quaternion");
    origin[static_cast<Eigen::Index>(i)] = *value;
  }
  if (origin.allFinite()) header.viewpoint = origin;
}

void ReadKey(const LineReader& lines, const WordList& words, Header& header) {
  const std::string_view key = words[0];
  if (key == "FIELDS" || key == "COLUMNS") {
    header.fields.clear();
    for (std::size_t i = 1; i < words.size(); ++i) header.fields.push_back({std::string(words[i])});
  } else if (key == "SIZE") {
    ReadSize(lines, words, header);
  } else if (key == "TYPE") {
    ReadType(lines, words, header);
  } else if (key == "COUNT") {
    NeedPerField(lines, words, header);
    for (std::size_t i = 1; i < words.size(); ++i) {
      header.fields[i - 1].count = CountOf(lines, words, i, 0);
    }
  } else if (key == "WIDTH") {
    header.width = CountOf(lines, words, 1, 0);
  } else if (key == "HEIGHT") {
    header.height = CountOf(lines, words, 1, 0);
  } else if (key == "POINTS") {
    header.points = CountOf(lines, words, 1, 0);
  } else if (key == "VIEWPOINT") {
    ReadViewpoint(lines, words, header);
  } else if (key == "DATA") {
    header.data = words.size() > 1 ? std::string(words[1]) : "";
    if (header.data != "ascii" && header.data != "binary" && header.data != "binary_compressed") {
      lines.Fail("DATA {} is none of ascii, binary, binary_compressed", Quoted(header.data));
    }
  } else if (key != "VERSION") {
    lines.Fail(
        "{} is not a key of a PCD header (VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, "
        "VIEWPOINT, POINTS, DATA)",
        Quoted(key));
  }
}

Header ReadHeader(LineReader& lines) {
  Header header;
  for (std::size_t i = 0; header.data.empty(); ++i) {
    const auto line = lines.Next();
    if (!line || i >= kMaxHeaderLines) lines.Fail("the header ends without DATA");
    const auto words = Words(*line);
    if (words.empty() || words[0].front() == '#') continue;
    ReadKey(lines, words, header);
  }
  return header;
}

/// Fills in what may be left out, and checks that the numbers agree.
void Complete(const LineReader& lines, Header& header) {
  if (header.fields.empty()) lines.Fail("the header has no FIELDS");
  if (!header.width && header.points) header.width = header.points;
  if (!header.width) lines.Fail("the header has neither WIDTH nor POINTS");
  if (!header.height) header.height = 1;
  const std::size_t product = *header.width * *header.height;
  if (!header.points) header.points = product;
  if (*header.points != product) {
    lines.Fail("POINTS is {}, but WIDTH x HEIGHT is {} x {}", *header.points, *header.width,
               *header.height);
  }
  if (product == 0) lines.Fail("the cloud has no points (POINTS is 0)");
  if (product >= kEndOfCounts) lines.Fail("POINTS {} is absurd", product);
}

struct Layout {
  Coordinate xyz[3];
  ColorPlace color;
  std::size_t columns = 0;
  std::size_t row_bytes = 0;
};

/// A field that is a packed color; others of its name are no color.
bool IsColor(const Field& field) {
  return (field.name == "rgb" || field.name == "rgba") && field.size == 4 && field.count == 1;
}

/// Where x, y, z and the color are: row by row, or, for binary_compressed, field by field.
Layout FindCoordinates(const LineReader& lines, const Header& header, bool by_field) {
  Layout layout;
  for (const Field& field : header.fields) {
    for (int axis = 0; axis < 3; ++axis) {
      if (field.name != std::string(1, static_cast<char>('x' + axis))) continue;
      if (field.type != 'F' || field.size < 4 || field.count != 1) {
        lines.Fail("field {} is of TYPE {}, SIZE {}, COUNT {}; F, 4 or 8, and 1 are needed",
                   field.name, field.type, field.size, field.count);
      }
      Coordinate& c = layout.xyz[axis];
      c.found = true;
      c.column = layout.columns;
      c.size = field.size;
      c.offset = by_field ? 0 : layout.row_bytes;
      c.start = by_field ? layout.row_bytes * *header.points : 0;
    }
    if (IsColor(field)) {
      layout.color.kind =
          field.type == 'F' ? ColorPlace::Kind::kPackedAsFloat : ColorPlace::Kind::kPacked;
      layout.color.at[0] = {.found = true,
                            .column = layout.columns,
                            .offset = by_field ? 0 : layout.row_bytes,
                            .start = by_field ? layout.row_bytes * *header.points : 0};
    }
    layout.columns += field.count;
    layout.row_bytes += field.count * field.size;
    if (layout.columns >= kEndOfCounts || layout.row_bytes >= kEndOfCounts) {
      lines.Fail("a point of {} bytes is absurd", layout.row_bytes);
    }
  }
  layout.color.at[0].stride = by_field ? layout.color.at[0].size : layout.row_bytes;
  for (int axis = 0; axis < 3; ++axis) {
    Coordinate& c = layout.xyz[axis];
    c.stride = by_field ? c.size : layout.row_bytes;
    if (!c.found) {
      lines.Fail("FIELDS has no {}; x, y and z are needed", static_cast<char>('x' + axis));
    }
  }
  return layout;
}

[[noreturn]] void FailTruncated(const LineReader& lines, std::size_t is, std::size_t needed) {
  lines.Fail("the data are {} bytes; the header says {}: the file is truncated, or POINTS is wrong",
             is, needed);
}

std::string Expand(const LineReader& lines, std::string_view body, std::size_t needed) {
  std::uint32_t sizes[2];
  if (body.size() < sizeof(sizes)) FailTruncated(lines, body.size(), sizeof(sizes));
  std::memcpy(sizes, body.data(), sizeof(sizes));
  body.remove_prefix(sizeof(sizes));
  if (sizes[1] != needed) {
    lines.Fail("the compressed data hold {} bytes; the header says {}", sizes[1], needed);
  }
  if (body.size() < sizes[0]) FailTruncated(lines, body.size(), sizes[0]);
  auto expanded = ExpandLzf(body.substr(0, sizes[0]), needed);
  if (!expanded) lines.Fail("the compressed data are broken");
  return std::move(*expanded);
}

}  // namespace

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

CloudFile ReadPcd(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  Header header = ReadHeader(lines);
  Complete(lines, header);
  const std::size_t points = *header.points;
  const Layout layout = FindCoordinates(lines, header, header.data == "binary_compressed");
  const std::size_t needed = points * layout.row_bytes;  // both < 2^31
  const std::string_view body = bytes.substr(lines.position());

  CloudFile cloud;
  cloud.width = static_cast<int>(*header.width);
  cloud.height = static_cast<int>(*header.height);
  cloud.sensor_origin = header.viewpoint;
  if (header.data == "ascii") {
    // Each point takes at least two bytes: absurd counts end here, before memory is asked for.
    if (body.size() + 1 < 2 * points) FailTruncated(lines, body.size(), 2 * points);
    cloud.points =
        DecodeAscii(lines, points, layout.columns, layout.xyz, layout.color, cloud.colors);
  } else if (header.data == "binary") {
    if (body.size() < needed) FailTruncated(lines, body.size(), needed);
    cloud.points = DecodeBinary(body, points, layout.xyz, false);
    cloud.colors = DecodeBinaryColors(body, points, layout.color, false);
  } else {
    const std::string expanded = Expand(lines, body, needed);
    cloud.points = DecodeBinary(expanded, points, layout.xyz, false);
    cloud.colors = DecodeBinaryColors(expanded, points, layout.color, false);
  }
  return cloud;
}

}  // namespace rangegrasp::geometry::internal
