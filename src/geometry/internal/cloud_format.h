#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/cloud_file.h"
#include "geometry/internal/polygon_soup.h"
#include "geometry/point_cloud.h"

/// What the readers and writers of PCD and PLY share.

namespace rangegrasp::geometry::internal {

/// No count or size in a header may reach this: sums and products of them stay far from overflow.
constexpr std::size_t kEndOfCounts = std::size_t{1} << 31;
/// A header with more lines is none: written ones have about ten, and comments some more.
constexpr std::size_t kMaxHeaderLines = 1000;

/// Splits a text into lines and counts them for messages.
class LineReader {
 public:
  LineReader(std::string_view text, std::filesystem::path file)
      : text_(text), file_(std::move(file)) {}

  /// The next line without its end; nullopt at the end of the text.
  std::optional<std::string_view> Next();
  /// Bytes consumed so far.
  std::size_t position() const { return position_; }
  /// @throws base::InputError "file:line: message", the message formatted as fmt::format does.
  template <class... Args>
  [[noreturn]] void Fail(fmt::format_string<Args...> message, Args&&... args) const {
    Throw(fmt::format(message, std::forward<Args>(args)...));
  }

 private:
  [[noreturn]] void Throw(const std::string& message) const;

  std::string_view text_;
  std::filesystem::path file_;
  std::size_t position_ = 0;
  std::size_t line_ = 0;
};

/// The words of a line.
using WordList = std::vector<std::string_view>;
WordList Words(std::string_view line);
/// A number, "nan" among them; nullopt if the word is anything else.
std::optional<double> ParseNumber(std::string_view word);
/// The point that the first three words are, which may be nan.
/// @throws base::InputError naming file and line if one is no number.
Eigen::Vector3d PointFrom(const LineReader& lines, std::span<const std::string_view> words);
/// A word for a message: shortened, without unprintable bytes, in quotes.
std::string Quoted(std::string_view word);

/// Where one coordinate of a point stands.
struct Coordinate {
  bool found = false;
  std::size_t column = 0;  ///< in an ascii row
  std::size_t offset = 0;  ///< [bytes] from the row's start in binary data
  std::size_t stride = 0;  ///< [bytes] from one point to the next
  std::size_t start = 0;   ///< [bytes] of the first point's row
  std::size_t size = 4;    ///< [bytes]: 4 float, 8 double
};

/// Where a point's color stands.
struct ColorPlace {
  enum class Kind {
    kNone,
    kPacked,         ///< a whole number of 4 bytes: blue, green, red from the lowest on
    kPackedAsFloat,  ///< the same bytes as a float's: what PCL writes
    kChannels        ///< red, green and blue, of a byte each
  };
  Kind kind = Kind::kNone;
  Coordinate at[3];  ///< the first one alone where they are packed
};

/// Binary colors; `data` must hold them all. None where the file has none.
std::vector<Rgb> DecodeBinaryColors(std::string_view data, std::size_t points,
                                    const ColorPlace& place, bool swap_bytes);
/// Binary points; `data` must hold them all.
Points DecodeBinary(std::string_view data, std::size_t points, const Coordinate (&xyz)[3],
                    bool swap_bytes);
/// One row of words a point. @param colors  receives their colors, if the file has any
Points DecodeAscii(LineReader& lines, std::size_t points, std::size_t columns,
                   const Coordinate (&xyz)[3], const ColorPlace& place, std::vector<Rgb>& colors);

/// Appends the bytes of a number as they are in memory.
template <class T>
void AppendRaw(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}
/// The number whose bytes stand there, turned round if `swap_bytes`.
template <class T>
double LoadAs(const char* bytes, bool swap_bytes) {
  char copy[sizeof(T)];
  std::memcpy(copy, bytes, sizeof(T));
  if (swap_bytes) std::reverse(copy, copy + sizeof(T));
  T value;
  std::memcpy(&value, copy, sizeof(T));
  return static_cast<double>(value);
}
/// Appends x, y and z in single precision.
void AppendPoint(const Eigen::Vector3d& p, std::string& bytes);

/// Whether the bytes start as a PLY file does.
bool IsPly(std::string_view bytes);

/// The header of a binary little-endian PLY up to its vertices' x, y and z (float); further
/// properties and end_header are the caller's.
std::string PlyVertexHeader(std::size_t vertices);

/// Checks what stands before the data of a PLY, in full. @return how many faces it declares.
/// @throws base::InputError naming file and line: an unknown key or type, no x, y and z, no end,
/// more elements than the data can hold.
std::size_t CheckPlyHeader(const std::filesystem::path& file, std::string_view bytes);

/// Reads the faces too: lists vertex_indices or vertex_index of the element face.
/// @throws base::InputError naming file and line, also a list that the file cannot hold and a
/// vertex that is not there.
PolygonSoup ReadPlyPolygons(const std::filesystem::path& file, std::string_view bytes);

/// Reads the vertices of a PLY file (ascii, binary of either byte order).
/// @throws base::InputError naming file and line.
CloudFile ReadPlyCloud(const std::filesystem::path& file, std::string_view bytes);

}  // namespace rangegrasp::geometry::internal
