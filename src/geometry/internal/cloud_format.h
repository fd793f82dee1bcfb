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

/// Code shared by the readers and writers of PCD and PLY.

namespace rangegrasp::geometry::internal {

/// Every count or size in a header must be below this: sums and products stay far from overflow.
constexpr std::size_t kEndOfCounts = std::size_t{1} << 31;
/// Largest size of a point in a header: the largest known, a shape histogram, has 1.2 kB.
constexpr std::size_t kMaxRow_bytes = std::size_t{1} << 20;
/// Beyond this, the file is damaged or has another unit; grids and fits would take all memory.
constexpr double kMaxPoint_m = 1e4;
/// The same for a mesh, whose unit is unknown when it is read: survey coordinates in mm.
constexpr double kMaxVertex = 1e10;
/// A header with more lines is invalid: real ones have about ten, plus some comments.
constexpr std::size_t kMaxHeaderLines = 1000;

/// Splits a text into lines and counts them for messages.
class LineReader {
 public:
  LineReader(std::string_view text, std::filesystem::path file)
      : text_(text), file_(std::move(file)) {}

  /// The next line without its line break; nullopt at the end of the text.
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
/// Parses a number, including "nan"; nullopt if the word is anything else.
std::optional<double> ParseNumber(std::string_view word);
/// The point given by the first three words, which may be nan; nullopt if they are anything else.
std::optional<Eigen::Vector3d> ParsePoint(std::span<const std::string_view> words);
/// The same for words that must be there.
/// @throws base::InputError naming file and line if one is not a number.
Eigen::Vector3d PointFrom(const LineReader& lines, std::span<const std::string_view> words);
/// @throws base::InputError naming the file and `what` if p is not finite or beyond `max`.
void CheckPlace(const std::filesystem::path& file, const std::string& what,
                const Eigen::Vector3d& p, double max);
/// A word for a message: in quotes, shortened, without unprintable bytes.
std::string Quoted(std::string_view word);

/// Type of a number: size in bytes, and 'f' float, 'i' signed integer, 'u' unsigned integer.
struct Type {
  std::size_t size = 0;
  char kind = 'f';
};

/// The place of one value of each point.
struct Place {
  Type type;               ///< size 0: the file has no such value
  std::size_t column = 0;  ///< index in a row of words
  std::size_t start = 0;   ///< [bytes] of the first point's value in binary data
};

constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};

/// The layout of the points in a file.
struct Layout {
  std::size_t points = 0;
  std::array<Place, 3> xyz{};
  /// One place with packed blue, green, red from the lowest byte on (an integer, or a float with
  /// its bytes, as PCL writes), or three one-byte places red, green, blue; empty without colors.
  std::vector<Place> color{};
  std::optional<Place> label{};
  std::vector<Type> columns{};  ///< types of a row of words
  std::size_t row_bytes = 0;    ///< size of a point in binary data
  bool by_field = false;        ///< the values are grouped by field, not by point
};

/// Reads rows of words, one per point, with one number per column, of the column's type.
void ReadAsciiPoints(LineReader& lines, const Layout& layout, CloudFile& cloud);
/// Fails unless the rest of the text is blank.
void CheckEnd(LineReader& lines);
/// Fails unless the data have exactly as many bytes as the header says.
void CheckSize(const LineReader& lines, std::size_t is, std::size_t needed);
/// Like ReadAsciiPoints for binary data, which must contain all points.
void ReadBinaryPoints(std::string_view data, const Layout& layout, bool swap_bytes,
                      CloudFile& cloud);

/// Appends the bytes of a number in their order in memory.
template <class T>
void AppendRaw(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}
/// Appends x, y and z in single precision.
void AppendPoint(const Eigen::Vector3d& p, std::string& bytes);

/// Whether a file starts as a PLY does.
/// @throws base::InputError naming the file if it does not, although its name ends in .ply.
bool IsPly(const std::filesystem::path& file, std::string_view bytes);

constexpr const char* kPlyColor = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
/// The header of a binary PLY up to its vertices' x, y and z; more properties, end_header follow.
std::string PlyVertexHeader(std::size_t vertices);

/// Checks the whole header of a PLY. @return the number of declared faces
/// @throws base::InputError naming file and line, also for more elements than fit into the data.
std::size_t CheckPlyHeader(const std::filesystem::path& file, std::string_view bytes);

/// Reads vertices and faces: the lists vertex_indices or vertex_index of the element face.
/// @throws base::InputError naming file and line, also for a vertex that does not exist.
PolygonSoup ReadPlyPolygons(const std::filesystem::path& file, std::string_view bytes);

/// Reads the vertices of a PLY file (ascii, binary of either byte order).
/// @throws base::InputError naming file and line.
CloudFile ReadPlyCloud(const std::filesystem::path& file, std::string_view bytes);

}  // namespace rangegrasp::geometry::internal
