#include "geometry/cloud_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"
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
  std::optional<std::size_t> width, height, points;
  std::optional<Eigen::Vector3d> viewpoint;
  std::string data;
};

/// Calls read(field, i) for each field and its value, words[i].
template <class Read>
void ReadPerField(const LineReader& lines, const WordList& words, Header& header, Read read) {
  if (header.fields.empty()) lines.Fail("{} stands before FIELDS", Quoted(words[0]));
  if (words.size() != header.fields.size() + 1) {
    lines.Fail("{} has {} values; there are {} FIELDS", words[0], words.size() - 1,
               header.fields.size());
  }
  for (std::size_t i = 1; i < words.size(); ++i) read(header.fields[i - 1], i);
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
    ReadPerField(lines, words, header, [&](Field& field, std::size_t i) {
      field.size = CountOf(lines, words, i, 1);
      if (field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8) return;
      lines.Fail("SIZE {} is none of 1, 2, 4, 8", Quoted(words[i]));
    });
  } else if (key == "TYPE") {
    ReadPerField(lines, words, header, [&](Field& field, std::size_t i) {
      if (words[i] != "F" && words[i] != "U" && words[i] != "I") {
        lines.Fail("TYPE {} is none of F, U, I", Quoted(words[i]));
      }
      field.type = words[i][0];
    });
  } else if (key == "COUNT") {
    ReadPerField(lines, words, header,
                 [&](Field& field, std::size_t i) { field.count = CountOf(lines, words, i, 0); });
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
    const Coordinate place{.found = true,
                           .column = layout.columns,
                           .offset = by_field ? 0 : layout.row_bytes,
                           .start = by_field ? layout.row_bytes * *header.points : 0,
                           .size = field.size};
    for (int axis = 0; axis < 3; ++axis) {
      if (field.name != std::string(1, static_cast<char>('x' + axis))) continue;
      if (field.type != 'F' || field.size < 4 || field.count != 1) {
        lines.Fail("field {} is of TYPE {}, SIZE {}, COUNT {}; F, 4 or 8, and 1 are needed",
                   field.name, field.type, field.size, field.count);
      }
      layout.xyz[axis] = place;
    }
    if (IsColor(field)) {
      layout.color.kind =
          field.type == 'F' ? ColorPlace::Kind::kPackedAsFloat : ColorPlace::Kind::kPacked;
      layout.color.at[0] = place;
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

/// Expands LZF data (Lehmann's liblzf format, as PCD's binary_compressed has it) to exactly `size`
/// bytes; nullopt if the data are broken.
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

/// Reads the bytes of a PCD file (ascii, binary, binary_compressed).
/// @throws base::InputError naming file and line.
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

}  // namespace
}  // namespace rangegrasp::geometry::internal

namespace rangegrasp::geometry {
namespace {

/// Rows keep their places, but a point is either finite or NaN as a whole.
void Normalize(CloudFile& cloud, double unit_m) {
  for (Eigen::Vector3d& p : cloud.points) {
    p *= unit_m;
    if (!p.allFinite()) p.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  if (cloud.sensor_origin) *cloud.sensor_origin *= unit_m;
}

void CheckFields(const RangeImage& image, const std::vector<CloudField>& fields) {
  for (const CloudField& field : fields) {
    if (field.values.size() != image.points_C.size()) {
      throw std::invalid_argument(
          fmt::format("WriteCloud: field {} has {} values; the image has {} points", field.name,
                      field.values.size(), image.points_C.size()));
    }
  }
}

constexpr char kColor[] = "rgb";

void AppendChannels(std::uint32_t packed, std::string& bytes) {
  for (const int shift : {16, 8, 0}) bytes.push_back(static_cast<char>(packed >> shift & 0xffu));
}

std::string PcdBytes(const RangeImage& image, const std::vector<CloudField>& fields) {
  std::string names, sizes, types, counts;
  for (const CloudField& field : fields) {
    names += " " + field.name;
    sizes += " 4";
    types += " U";
    counts += " 1";
  }
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  if (!image.origins_C.empty()) origin = Centroid(image.origins_C);
  std::string bytes = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z{}\n"
      "SIZE 4 4 4{}\nTYPE F F F{}\nCOUNT 1 1 1{}\nWIDTH {}\nHEIGHT {}\n"
      "VIEWPOINT {:f} {:f} {:f} 1 0 0 0\nPOINTS {}\nDATA binary\n",
      names, sizes, types, counts, image.samples, image.profiles, origin.x(), origin.y(),
      origin.z(), image.points_C.size());
  for (std::size_t i = 0; i < image.points_C.size(); ++i) {
    internal::AppendPoint(image.points_C[i], bytes);
    for (const CloudField& field : fields) internal::AppendRaw(field.values[i], bytes);
  }
  return bytes;
}

std::string PlyBytes(const RangeImage& image, const std::vector<CloudField>& fields) {
  Indices measured;
  ToCloud(image, &measured);
  std::string bytes = internal::PlyVertexHeader(measured.size());
  for (const CloudField& field : fields) {
    bytes += field.name == kColor
                 ? "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                 : "property uint " + field.name + "\n";
  }
  bytes += "end_header\n";
  for (const std::uint32_t i : measured) {
    internal::AppendPoint(image.points_C[i], bytes);
    for (const CloudField& field : fields) {
      if (field.name == kColor) {
        AppendChannels(field.values[i], bytes);
      } else {
        internal::AppendRaw(field.values[i], bytes);
      }
    }
  }
  return bytes;
}

}  // namespace

CloudFile ReadCloud(const std::filesystem::path& file, double unit_m) {
  if (!(unit_m > 0.0) || !std::isfinite(unit_m)) {
    throw std::invalid_argument("ReadCloud: unit_m must be a finite number > 0");
  }
  const std::string bytes = base::ReadNonEmptyFile(file);
  const bool ply = internal::IsPly(bytes);
  if (!ply && base::EndingOf(file) == ".ply") {
    throw base::InputError(file.string() + ":1: a PLY file starts with the line \"ply\"");
  }
  CloudFile cloud = ply ? internal::ReadPlyCloud(file, bytes) : internal::ReadPcd(file, bytes);
  Normalize(cloud, unit_m);
  const bool any = std::any_of(cloud.points.begin(), cloud.points.end(),
                               [](const Eigen::Vector3d& p) { return p.allFinite(); });
  if (!any) {
    throw base::InputError(
        fmt::format("{}: none of its {} points is finite", file.string(), cloud.points.size()));
  }
  return cloud;
}

CloudField ColorField(const std::vector<Rgb>& colors) {
  CloudField field{kColor, {}};
  for (const auto& [red, green, blue] : colors) {
    field.values.push_back(std::uint32_t{red} << 16 | std::uint32_t{green} << 8 | blue);
  }
  return field;
}

void WriteCloud(const std::filesystem::path& file, const RangeImage& image,
                const std::vector<CloudField>& fields) {
  CheckFields(image, fields);
  base::WriteFile(
      file, base::EndingOf(file) == ".ply" ? PlyBytes(image, fields) : PcdBytes(image, fields));
}

}  // namespace rangegrasp::geometry
