#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/io.h"

/// What the readers of PCD and PLY share.
namespace rangegrasp::geometry::internal {

/// Splits a text into lines and counts them for messages.
class LineReader {
 public:
  LineReader(std::string_view text, std::filesystem::path file)
      : text_(text), file_(std::move(file)) {}

  /// The next line without its end; nullopt at the end of the text.
  std::optional<std::string_view> Next();
  /// Bytes consumed so far.
  std::size_t position() const { return position_; }
  /// @throws core::InputError "file:line: message".
  [[noreturn]] void Fail(const std::string& message) const;

 private:
  std::string_view text_;
  std::filesystem::path file_;
  std::size_t position_ = 0;
  std::size_t line_ = 0;
};

/// The words of a line.
std::vector<std::string_view> Words(std::string_view line);
/// A whole non-negative number; nullopt if the word is anything else.
std::optional<std::size_t> ParseCount(std::string_view word);
/// A number, "nan" among them; nullopt if the word is anything else.
std::optional<double> ParseNumber(std::string_view word);
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

/// Binary points; `data` must hold them all.
Points DecodeBinary(std::string_view data, std::size_t points, const Coordinate (&xyz)[3],
                    bool swap_bytes);
/// One row of words a point.
Points DecodeAscii(LineReader& lines, std::size_t points, std::size_t columns,
                   const Coordinate (&xyz)[3]);

/// What stands before the data of a PLY, in full. @return how many faces it declares.
/// @throws core::InputError naming file and line: an unknown key or type, no x, y and z, no end,
/// more elements than the data can hold.
std::size_t CheckPlyHeader(const std::filesystem::path& file, std::string_view bytes);

CloudFile ReadPcd(const std::filesystem::path& file, std::string_view bytes);
CloudFile ReadPlyCloud(const std::filesystem::path& file, std::string_view bytes);

/// Expands LZF data (Lehmann's liblzf format, as PCD's binary_compressed has it) to exactly `size`
/// bytes; nullopt if the data are broken.
std::optional<std::string> ExpandLzf(std::string_view data, std::size_t size);

}  // namespace rangegrasp::geometry::internal
