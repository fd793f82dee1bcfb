#include "geometry/cloud_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/pattern.h"
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

template <class Read>
void ReadPerField(const LineReader& lines, const WordList& words, Header& header, Read read) {
  if (header.fields.empty()) lines.Fail("{} must come after FIELDS", Quoted(words[0]));
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
    lines.Fail("{} is {}; it must be a whole number from {} to {}", words[0],
               i < words.size() ? Quoted(words[i]) : "missing", min, kEndOfCounts - 1);
  }
  return *value;
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
      lines.Fail("SIZE {} is not one of 1, 2, 4, 8", Quoted(words[i]));
    });
  } else if (key == "TYPE") {
    ReadPerField(lines, words, header, [&](Field& field, std::size_t i) {
      if (words[i] != "F" && words[i] != "U" && words[i] != "I") {
        lines.Fail("TYPE {} is not one of F, U, I", Quoted(words[i]));
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
    const auto place = ParsePoint(std::span(words).subspan(1));
    if (!place) lines.Fail("VIEWPOINT needs seven numbers: x y z and a quaternion");
    if (place->allFinite()) header.viewpoint = place;
  } else if (key == "DATA") {
    header.data = words.size() > 1 ? std::string(words[1]) : "";
    if (header.data != "ascii" && header.data != "binary" && header.data != "binary_compressed") {
      lines.Fail("DATA {} is not one of ascii, binary, binary_compressed", Quoted(header.data));
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

/// Fills in optional values and checks that the numbers are consistent.
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
  if (product >= kEndOfCounts) lines.Fail("POINTS {} is too large", product);
}

/// Whether a field is a packed color; other fields of the same name are not.
bool IsColor(const Field& field) {
  return (field.name == "rgb" || field.name == "rgba") && field.size == 4 && field.count == 1;
}

/// Places of x, y, z and the color: row by row, or, for binary_compressed, field by field.
Layout FindPlaces(const LineReader& lines, const Header& header) {
  Layout layout{.points = *header.points, .by_field = header.data == "binary_compressed"};
  for (const Field& field : header.fields) {
    Place place{{field.size, 'f'},
                layout.columns.size(),
                layout.row_bytes * (layout.by_field ? layout.points : 1)};
    const auto axis = std::ranges::find(kAxes, field.name) - kAxes.begin();
    if (axis < 3) {
      if (field.type != 'F' || field.size < 4 || field.count != 1) {
        lines.Fail("field {} has TYPE {}, SIZE {}, COUNT {}; they must be F, 4 or 8, and 1",
                   field.name, field.type, field.size, field.count);
      }
      layout.xyz[static_cast<std::size_t>(axis)] = place;
    }
    if (IsColor(field)) {
      // In ascii data a word is the number; in binary data the bytes of a float are used unchanged.
      place.type.kind = field.type == 'F' && header.data == "ascii" ? 'f' : 'u';
      layout.color = {place};
    }
    const Type column{field.size, field.type == 'F' ? 'f' : field.type == 'U' ? 'u' : 'i'};
    if (field.name == "label" && field.type != 'F' && field.count == 1) {
      place.type = column;
      layout.label = place;
    }
    layout.row_bytes += field.count * field.size;
    if (layout.row_bytes >= kMaxRow_bytes) {
      lines.Fail("{} bytes per point are too many", layout.row_bytes);
    }
    layout.columns.resize(layout.columns.size() + field.count, column);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (layout.xyz[axis].type.size > 0) continue;
    lines.Fail("FIELDS has no {}; x, y and z are needed", kAxes[axis]);
  }
  return layout;
}

/// Expands LZF data (Lehmann's liblzf format, used by PCD's binary_compressed) to exactly `size`
/// bytes; nullopt if the data are damaged.
std::optional<std::string> ExpandLzf(std::string_view data, std::size_t size) {
  // Three bytes give at most 264: a wrong size is refused before memory is reserved for it.
  constexpr std::size_t kMaxGrowth = 88;
  if (size > kMaxGrowth * data.size()) return std::nullopt;
  std::string out;
  out.reserve(size);
  const auto next = [&data] {
    const auto byte = static_cast<unsigned char>(data.front());
    data.remove_prefix(1);
    return byte;
  };
  while (!data.empty()) {
    const unsigned control = next();
    if (control < 32) {  // a run of control + 1 literal bytes
      const std::size_t run = control + 1;
      if (data.size() < run || size - out.size() < run) return std::nullopt;
      out.append(data.substr(0, run));
      data.remove_prefix(run);
      continue;
    }
    // A copy of earlier output: 3 bits of length (7: one more byte), 13 bits of distance.
    std::size_t length = (control >> 5) + 2;
    const bool longer = control >> 5 == 7;
    if (data.size() < (longer ? 2 : 1)) return std::nullopt;
    if (longer) length += next();
    const std::size_t distance = ((control & 31u) << 8) + next() + 1;
    if (distance > out.size() || size - out.size() < length) return std::nullopt;
    // Source and destination may overlap.
    for (std::size_t i = 0; i < length; ++i) out.push_back(out[out.size() - distance]);
  }
  return out.size() == size ? std::optional(std::move(out)) : std::nullopt;
}

std::string Expand(const LineReader& lines, std::string_view body, std::size_t needed) {
  std::uint32_t sizes[2];
  if (body.size() < sizeof(sizes)) CheckSize(lines, body.size(), sizeof(sizes));
  std::memcpy(sizes, body.data(), sizeof(sizes));
  body.remove_prefix(sizeof(sizes));
  if (sizes[1] != needed) {
    lines.Fail("the compressed data have {} bytes; the header says {}", sizes[1], needed);
  }
  // Older versions of PCL pad the data to a full page of memory.
  if (body.size() < sizes[0]) CheckSize(lines, body.size(), sizes[0]);
  auto expanded = ExpandLzf(body.substr(0, sizes[0]), needed);
  if (!expanded) lines.Fail("the compressed data are damaged");
  return std::move(*expanded);
}

/// Reads the bytes of a PCD file (ascii, binary, binary_compressed).
/// @throws base::InputError naming file and line.
CloudFile ReadPcd(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  Header header = ReadHeader(lines);
  Complete(lines, header);
  const Layout layout = FindPlaces(lines, header);
  const bool ascii = header.data == "ascii";
  // A point of an ascii file takes at least two bytes: absurd counts are rejected here, before
  // memory is allocated. All factors are < 2^31.
  const std::size_t needed = layout.points * (ascii ? 2 : layout.row_bytes);
  const std::string_view body = lines.Rest();

  CloudFile cloud;
  cloud.width = static_cast<int>(*header.width);
  cloud.height = static_cast<int>(*header.height);
  cloud.sensor_origin = header.viewpoint;
  if (layout.by_field) {
    ReadBinaryPoints(Expand(lines, body, needed), layout, false, cloud);
    return cloud;
  }
  if (!ascii || body.size() + 1 < needed) CheckSize(lines, body.size(), needed);
  if (ascii) {
    ReadAsciiPoints(lines, layout, cloud);
    CheckEnd(lines);
  } else {
    ReadBinaryPoints(body, layout, false, cloud);
  }
  return cloud;
}

// ---- NPY: a Python dict as header, then the numbers ----

constexpr std::string_view kNpyMagic = "\x93NUMPY";
constexpr std::size_t kMaxNpyHeader_bytes = 4096;  ///< NumPy writes 118

template <class... Args>
[[noreturn]] void FailNpy(const std::filesystem::path& file, fmt::format_string<Args...> message,
                          Args&&... args) {
  throw base::InputError(file.string() +
                         ": NPY header: " + fmt::format(message, std::forward<Args>(args)...));
}

/// The dict, which follows magic, version and its length; moves `bytes` past it.
std::string NpyHeader(const std::filesystem::path& file, std::string_view& bytes) {
  const auto byte = [&](std::size_t i) {
    return std::size_t{static_cast<unsigned char>(bytes[i])};
  };
  const bool has_version = bytes.size() > kNpyMagic.size() + 4;
  const std::size_t version = has_version ? byte(kNpyMagic.size()) : 0;
  if (version < 1 || version > 3) FailNpy(file, "byte 6: no format version 1, 2 or 3");
  const std::size_t start = version == 1 ? 10 : 12;
  std::size_t length = 0;
  for (std::size_t i = std::min(start, bytes.size()); i-- > 8;) length = length << 8 | byte(i);
  if (length > kMaxNpyHeader_bytes || bytes.size() < start + length) {
    FailNpy(file, "byte 8: the header has {} bytes; the file has {}, and at most {} are allowed",
            length, bytes.size(), kMaxNpyHeader_bytes);
  }
  std::string header(bytes.substr(start, length));
  bytes.remove_prefix(start + length);
  return header;
}

std::string NpyValue(const std::filesystem::path& file, const std::string& header, const char* key,
                     const char* pattern) {
  const auto match = base::FindMatch(header, fmt::format(R"('{}' *: *{})", key, pattern));
  if (match) return match->groups[1];
  FailNpy(file, "no valid '{}' in {}", key, Quoted(header));
}

/// Reads points from an array of N x 3 or H x W x 3 real numbers. @throws base::InputError.
CloudFile ReadNpy(const std::filesystem::path& file, std::string_view bytes) {
  const std::string header = NpyHeader(file, bytes);
  const std::string type = NpyValue(file, header, "descr", "'([^']{1,20})'");
  const auto real = base::FindMatch(type, "^([<>])f([48])$");
  if (!real) {
    FailNpy(file, "'descr' is {}; the numbers must be float32 or float64 (<f4, <f8)", Quoted(type));
  }
  if (NpyValue(file, header, "fortran_order", "(True|False)") == "True") {
    FailNpy(file, "'fortran_order' is True; save numpy.ascontiguousarray(points)");
  }
  const std::string shape = NpyValue(file, header, "shape", R"(\(([0-9 ,]{1,60})\))");
  std::vector<std::size_t> counts;
  for (const std::string& word : base::Split(shape, ',')) {
    const std::string digits = word.substr(std::min(word.find_first_not_of(' '), word.size()));
    if (digits.empty()) continue;  // after the last comma
    counts.push_back(base::NumberFrom<std::size_t>(digits).value_or(kEndOfCounts));
  }
  const auto is_count = [](std::size_t count) { return count > 0 && count < kEndOfCounts; };
  if ((counts.size() != 2 && counts.size() != 3) || counts.back() != 3 ||
      !std::ranges::all_of(counts, is_count)) {
    FailNpy(file, "'shape' is ({}); N x 3 or H x W x 3 are needed", shape);
  }
  const std::size_t size = real->groups[2] == "4" ? 4 : 8;
  Layout layout{.points = counts.size() == 2 ? counts[0] : counts[0] * counts[1],
                .row_bytes = 3 * size};
  for (std::size_t axis = 0; axis < 3; ++axis) layout.xyz[axis] = {{size, 'f'}, 0, axis * size};
  if (layout.points >= kEndOfCounts || bytes.size() != layout.points * layout.row_bytes) {
    FailNpy(file, "'shape' ({}) needs {} bytes of data; there are {}", shape,
            layout.points * layout.row_bytes, bytes.size());
  }
  CloudFile cloud;
  cloud.height = static_cast<int>(counts.size() == 2 ? 1 : counts[0]);
  cloud.width = static_cast<int>(counts[counts.size() - 2]);
  ReadBinaryPoints(bytes, layout, real->groups[1] == ">", cloud);
  return cloud;
}

/// Reads text, one point per line: x, y, z and ignored numbers; "#" begins a comment line.
CloudFile ReadXyz(const std::filesystem::path& file, std::string_view text) {
  LineReader lines(text, file);
  CloudFile cloud;
  std::size_t columns = 0;
  while (const auto line = lines.Next()) {
    const WordList words = Words(*line);
    if (words.empty() || words[0].front() == '#') continue;
    if (words.size() < 3) {
      lines.Fail("{} has {}; x, y and z with blanks between them are needed", Quoted(*line),
                 base::Counted(words.size(), "value"));
    }
    if (columns == 0) columns = words.size();
    if (words.size() != columns) {
      lines.Fail("has {} values; the lines before have {}", words.size(), columns);
    }
    for (const std::string_view word : words) {
      if (!ParseNumber(word)) lines.Fail("{} is not a number", Quoted(word));
    }
    cloud.points.push_back(PointFrom(lines, words));
  }
  cloud.width = static_cast<int>(cloud.points.size());
  return cloud;
}

CloudFile ReadAny(const std::filesystem::path& file, const std::string& bytes) {
  if (IsPly(file, bytes)) return ReadPlyCloud(file, bytes);
  const std::string ending = base::EndingOf(file);
  if (bytes.starts_with(kNpyMagic)) return ReadNpy(file, bytes);
  if (ending == ".npy") {
    throw base::InputError(file.string() + ": byte 0: an NPY file starts with \\x93NUMPY");
  }
  if (ending == ".xyz" || ending == ".txt") return ReadXyz(file, bytes);
  constexpr std::size_t kHeader = 4096;
  if (ending != ".pcd" && bytes.substr(0, kHeader).find("FIELDS") == std::string::npos) {
    throw base::InputError(file.string() +
                           ": is no cloud: .pcd, .ply, .npy and .xyz (or .txt: x y z) are read");
  }
  return ReadPcd(file, bytes);
}

/// Scales the points. Rows keep their positions, but a point is either finite or all NaN.
void Normalize(const std::filesystem::path& file, double unit_m, CloudFile& cloud) {
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    Eigen::Vector3d& p = cloud.points[i];
    p *= unit_m;
    if (!p.allFinite()) {
      p.setConstant(std::numeric_limits<double>::quiet_NaN());
    } else if (p.cwiseAbs().maxCoeff() > kMaxPoint_m) {  // formatting a name costs time
      CheckPlace(file, fmt::format("point {} [m]", i), p, kMaxPoint_m);
    }
  }
  if (!cloud.sensor_origin) return;
  *cloud.sensor_origin *= unit_m;
  CheckPlace(file, "VIEWPOINT [m]", *cloud.sensor_origin, kMaxPoint_m);
}

constexpr char kColor[] = "rgb";

Eigen::Vector3d ViewpointOf(const RangeImage& image) {
  return image.origins_C.empty() ? Eigen::Vector3d::Zero() : Centroid(image.origins_C);
}

std::string PcdBytes(const RangeImage& image, const std::vector<CloudField>& fields) {
  std::string names, sizes, types, counts;
  for (const CloudField& field : fields) {
    names += " " + field.name;
    sizes += " 4";
    types += " U";
    counts += " 1";
  }
  const Eigen::Vector3d origin = ViewpointOf(image);
  std::string bytes = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z{}\n"
      "SIZE 4 4 4{}\nTYPE F F F{}\nCOUNT 1 1 1{}\nWIDTH {}\nHEIGHT {}\n"
      "VIEWPOINT {:f} {:f} {:f} 1 0 0 0\nPOINTS {}\nDATA binary\n",
      names, sizes, types, counts, image.samples, image.profiles, origin.x(), origin.y(),
      origin.z(), image.points_C.size());
  for (std::size_t i = 0; i < image.points_C.size(); ++i) {
    AppendPoint(image.points_C[i], bytes);
    for (const CloudField& field : fields) AppendRaw(field.values[i], bytes);
  }
  return bytes;
}

std::string PlyBytes(const RangeImage& image, const std::vector<CloudField>& fields) {
  const Indices measured =
      PositionsWhere(image.points_C, [](const Eigen::Vector3d& p) { return p.allFinite(); });
  std::string bytes = PlyVertexHeader(measured.size());
  for (const CloudField& field : fields) {
    bytes += field.name == kColor ? kPlyColor : "property uint " + field.name + "\n";
  }
  if (!image.origins_C.empty()) {
    const Eigen::Vector3d origin = ViewpointOf(image);
    bytes += fmt::format("comment viewpoint {:f} {:f} {:f}\n", origin.x(), origin.y(), origin.z());
  }
  bytes += "end_header\n";
  for (const std::uint32_t i : measured) {
    AppendPoint(image.points_C[i], bytes);
    for (const CloudField& field : fields) {
      const std::uint32_t value = field.values[i];
      if (field.name == kColor) {
        for (const int shift : {16, 8, 0}) bytes.push_back(static_cast<char>(value >> shift));
      } else {
        AppendRaw(value, bytes);
      }
    }
  }
  return bytes;
}

}  // namespace
}  // namespace rangegrasp::geometry::internal

namespace rangegrasp::geometry {

CloudFile ReadCloud(const std::filesystem::path& file, double unit_m) {
  if (!(unit_m > 0.0) || !std::isfinite(unit_m)) {
    throw std::invalid_argument("ReadCloud: unit_m must be a finite number > 0");
  }
  const std::string bytes = base::ReadNonEmptyFile(file);
  CloudFile cloud = internal::ReadAny(file, bytes);
  internal::Normalize(file, unit_m, cloud);
  if (std::ranges::none_of(cloud.points, [](const auto& p) { return p.allFinite(); })) {
    throw base::InputError(
        fmt::format("{}: none of its {} points is finite", file.string(), cloud.points.size()));
  }
  return cloud;
}

CloudField ColorField(const std::vector<Rgb>& colors) {
  CloudField field{internal::kColor, {}};
  for (const auto& [red, green, blue] : colors) {
    field.values.push_back(std::uint32_t{red} << 16 | std::uint32_t{green} << 8 | blue);
  }
  return field;
}

void WriteCloud(const std::filesystem::path& file, const RangeImage& image,
                const std::vector<CloudField>& fields) {
  for (const CloudField& field : fields) {
    if (field.values.size() == image.points_C.size()) continue;
    throw std::invalid_argument(
        fmt::format("WriteCloud: field {} has {} values; the image has {} points", field.name,
                    field.values.size(), image.points_C.size()));
  }
  base::WriteFile(file, base::EndingOf(file) == ".ply" ? internal::PlyBytes(image, fields)
                                                       : internal::PcdBytes(image, fields));
}

}  // namespace rangegrasp::geometry
