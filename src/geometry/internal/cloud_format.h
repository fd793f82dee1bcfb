#pragma once

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/cloud_file.h"
#include "geometry/internal/polygon_soup.h"

/// What the readers and writers of PCD and PLY share.

namespace rangegrasp::geometry::internal {

/// No count or size in a header may reach this: sums and products of them stay far from overflow.
constexpr std::size_t kEndOfCounts = std::size_t{1} << 31;
/// Of a point in a header: the longest known, a histogram of shape, has 1.2 kB.
constexpr std::size_t kMaxRow_bytes = std::size_t{1} << 20;
/// Beyond, the file is damaged or has another unit: grids and fits would take all memory for it.
constexpr double kMaxPoint_m = 1e4;
/// The same of a mesh, whose unit is not known when it is read: survey coordinates in mm.
constexpr double kMaxVertex = 1e10;
/// A header with more lines is none: written ones have about ten, and comments some more.
constexpr std::size_t kMaxHeaderLines = 1000;

/// Splits a text into lines and counts them for messages.
class LineReader {
 public:
  LineReader(std::string_view text, std::filesystem::path file)
      : text_(text), file_(std::move(file)) {}

  /// The next line without its end; nullopt at the end of the text.
  std::optional<std::string_view> Next();
  std::string_view Rest() const { return text_.substr(position_); }
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
/// @throws base::InputError naming the file and `what`, if a coordinate of p is not finite or
/// beyond `max`.
void CheckPlace(const std::filesystem::path& file, const std::string& what,
                const Eigen::Vector3d& p, double max);
/// A word for a message: shortened, without unprintable bytes, in quotes.
std::string Quoted(std::string_view word);

/// Of a number: its bytes, and 'f' real, 'i' whole, 'u' whole without a sign.
struct Type {
  std::size_t size = 0;
  char kind = 'f';
};

/// Where one value of each point stands.
struct Place {
  Type type;               ///< of size 0: the file has no such value
  std::size_t column = 0;  ///< in a row of words
  std::size_t start = 0;   ///< [bytes] of the first point's in binary data
};

constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};

/// How the points of a file stand one after the other.
struct Layout {
  std::size_t points = 0;
  std::array<Place, 3> xyz{};
  /// One that packs blue, green and red from its lowest byte on (whole, or as the same bytes of a
  /// float: what PCL writes), or red, green and blue of a byte each; none without colors.
  std::vector<Place> color{};
  std::optional<Place> label{};
  std::vector<Type> columns{};  ///< of a row of words
  std::size_t row_bytes = 0;    ///< of a point in binary data
  bool by_field = false;        ///< the values of one field stand together, not those of one point
};

/// Reads rows of words, one a point, into a cloud's points and colors: as many values as columns,
/// each a number of its column's type.
void ReadAsciiPoints(LineReader& lines, const Layout& layout, CloudFile& cloud);
/// Fails unless only blank lines are left of the text.
void CheckEnd(LineReader& lines);
/// Fails unless the data are exactly as many bytes as the header says.
void CheckSize(const LineReader& lines, std::size_t is, std::size_t needed);
/// The same of binary data, which must hold them all.
void ReadBinaryPoints(std::string_view data, const Layout& layout, bool swap_bytes,
                      CloudFile& cloud);

/// Appends the bytes of a number as they are in memory.
template <class T>
void AppendRaw(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}
/// Appends x, y and z in single precision.
void AppendPoint(const Eigen::Vector3d& p, std::string& bytes);

bool IsPly(std::string_view bytes);

constexpr const char* kPlyColor = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
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
