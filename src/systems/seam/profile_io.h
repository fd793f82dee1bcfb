#pragma once

#include <filesystem>
#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "seam/profile.h"
#include "seam/profile_format.h"

namespace rangegrasp::seam {

/// One row of a stream: a profile, or what is wrong with it.
struct ProfileRow {
  std::size_t row = 0;   ///< from 1
  std::size_t line = 0;  ///< of the file: also counts what is left out
  Profile profile;       ///< empty if damaged
  std::string fault;     ///< empty if whole; else names the row, the value and what would be right
  std::optional<double> position_m;  ///< of the encoder
  std::optional<double> gap_s;       ///< without a measurement before it, by the file's own times
};

/// The even grid that profiles with x were brought onto: x is the sensor's own.
struct ProfileGrid {
  double columns_per_m = 0.0;
  double center_x_m = 0.0;  ///< of the middle between first and last column
};

/// Reads a text row by row as they arrive, so that a pipe can be followed. No value is nothing,
/// "nan" or "-". Lines that begin with '#' are left out, and empty ones where a line is a profile.
/// A separator at a line's end is no column; CRLF and a byte order mark do not matter. Damaged rows
/// take their time too: without a time column, row n is of (n - 1) / rate_hz.
class ProfileStream {
 public:
  ProfileStream(std::istream& in, const ProfileFileOptions& options);
  ~ProfileStream();
  /// nullopt at the end. A damaged row (ragged, not a number, out of range, back in time or path)
  /// is returned with its fault. Where the width is not given, the first row waits for the second,
  /// for it may have been cut off; where there is x, for two others, which define the grid.
  /// @throws base::InputError if a column that is asked for is not in the header, or the x of the
  /// first rows are no line.
  std::optional<ProfileRow> Next();
  /// Once the first row was read: the grid, if rows have x.
  std::optional<ProfileGrid> grid() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Rows of a whole file and their grid, if they have x.
struct ProfileFile {
  std::vector<ProfileRow> rows;  ///< whole ones
  std::optional<ProfileGrid> grid;
};

/// By its ending: .png, .tif or .tiff.
bool IsImageFile(const std::filesystem::path& file);

/// Reads a whole file: text (.csv, .txt) or an image, one profile a row.
/// @throws base::InputError naming the file and the row: unreadable, no row at all, ragged, not a
/// number, out of range, back in time or path, an image of other pixels.
ProfileFile ReadProfileFile(const std::filesystem::path& file, const ProfileFileOptions& options);

/// Writes CSV (.csv, .txt; numbers in `text.scale.unit_m`, six digits after the point, no value is
/// "nan") or a 16-bit image (.png; 0 is no value). Times are not written.
/// @throws base::InputError for another ending, no profile, profiles of different widths, or a
/// height that does not fit into an image; base::RunError if it cannot be written whole.
void WriteProfiles(const std::vector<Profile>& profiles, const std::filesystem::path& file,
                   const ProfileFileOptions& options);

}  // namespace rangegrasp::seam
