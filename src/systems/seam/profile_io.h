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
  std::size_t row = 0;   ///< number, from 1
  std::size_t line = 0;  ///< line number in the file, skipped lines included
  Profile profile;       ///< empty if damaged
  std::string fault;     ///< empty if valid; else names the row, the value and what is expected
  std::optional<double> position_m;  ///< encoder position
  std::optional<double> gap_s;       ///< time without a measurement before it, by the file's times
};

/// The even grid onto which profiles with x were resampled, in the sensor's own x.
struct ProfileGrid {
  double first_m = 0.0;  ///< x of the first column
  double pitch_m = 0.0;
  std::size_t columns = 0;

  double Center() const { return first_m + 0.5 * pitch_m * static_cast<double>(columns - 1); }
};

/// Reads a text row by row, also from a pipe. A missing value is an empty field, "nan" or "-".
/// Lines that begin with '#' are skipped, and empty lines if a line is a profile. A separator at a
/// line's end adds no column. Damaged rows count: without a time column, row n has time (n - 1) /
/// rate_hz.
class ProfileStream {
 public:
  ProfileStream(std::istream& in, const ProfileFileOptions& options);
  ~ProfileStream();
  /// Returns nullopt at the end. A damaged row (wrong width, not a number, out of range, back in
  /// time or path) is returned with its fault. If no width is given, the first row, which may be
  /// truncated, waits for the second; with x, for two others, which define the grid.
  /// @throws base::InputError if a column is not in the header, or x give too many columns.
  std::optional<ProfileRow> Next();
  /// The grid, if rows have x; known once the first row was read.
  std::optional<ProfileGrid> grid() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct ProfileFile {
  std::vector<ProfileRow> rows;     ///< all are valid
  std::optional<ProfileGrid> grid;  ///< if they have x
};

/// By its extension: .png, .tif or .tiff.
bool IsImageFile(const std::filesystem::path& file);

/// Reads a whole file: text (.csv, .txt) or an image, one profile per row.
/// @throws base::InputError naming the file, if it is unreadable, has no row or other pixels; and
/// the row, if it is damaged (ProfileStream::Next).
ProfileFile ReadProfileFile(const std::filesystem::path& file, const ProfileFileOptions& options);

/// Writes CSV (.csv, .txt) without times: numbers in `unit_m`, six digits after the point, or
/// "nan".
/// @throws base::InputError for another extension; base::RunError if it cannot be written.
void WriteProfiles(const std::vector<Profile>& profiles, const std::filesystem::path& file,
                   double unit_m = HeightScale{}.unit_m);

}  // namespace rangegrasp::seam
