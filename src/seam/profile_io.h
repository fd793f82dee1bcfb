#pragma once

#include <filesystem>
#include <functional>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "seam/profile.h"

namespace rangegrasp::seam {

/// How numbers of a file of profiles become heights or rows.
struct ProfileFileOptions {
  int columns = 0;             ///< expected columns; 0: those of the first row
  double unit_m = 1e-3;        ///< CSV: metres a number; ignored for raw rows
  double image_unit_m = 1e-6;  ///< 16-bit image: metres a grey level; 0 is no value
  double image_zero = 32768;   ///< grey level of height 0
  double rate_hz = 62.0;       ///< profiles a second, > 0: gives each row its time
  double min_height_m = -0.2;  ///< heights outside are out of range
  double max_height_m = 0.2;
};

/// One row of a stream: a profile, or what is wrong with it.
struct ProfileRow {
  std::size_t row = 0;  ///< from 1
  Profile profile;      ///< empty if damaged
  std::string fault;    ///< empty if whole; else names the row, the value and what would be right
};

/// Reads CSV row by row as they arrive (commas, semicolons or blanks; empty, "nan" or "-": no
/// value; lines that begin with '#' are left out), so that a pipe can be followed.
class ProfileStream {
 public:
  ProfileStream(std::istream& in, const ProfileFileOptions& options);
  /// nullopt at the end. A damaged row (ragged, not a number, out of range) is returned with its
  /// fault.
  std::optional<ProfileRow> Next();

 private:
  std::istream& in_;
  ProfileFileOptions options_;
  std::size_t row_ = 0;
};

/// Reads a whole file: .csv/.txt, or a 16-bit grey .png/.pgm, one profile a row.
/// @throws core::InputError naming the file and the row: unreadable, no row at all, ragged, not a
/// number, out of range, not 16-bit grey.
std::vector<Profile> ReadProfiles(const std::filesystem::path& file,
                                  const ProfileFileOptions& options);

/// Writes CSV (.csv; numbers in `unit_m`, six significant digits below the unit) or a 16-bit image
/// (.png, .pgm).
/// @throws core::InputError for another ending; core::RunError if it cannot be written whole.
void WriteProfiles(const std::vector<Profile>& profiles, const std::filesystem::path& file,
                   const ProfileFileOptions& options);

}  // namespace rangegrasp::seam
