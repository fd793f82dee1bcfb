#pragma once

#include <deque>
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
  int columns = 0;             ///< expected columns; 0: those of most of the first three whole rows
  double unit_m = 1e-3;        ///< CSV: metres a number; ignored for raw rows
  double image_unit_m = 1e-6;  ///< 16-bit image: metres a grey level; 0 is no value
  double image_zero = 32768;   ///< grey level of height 0
  double rate_hz = 62.0;       ///< profiles a second, > 0: gives each row its time
  double min_height_m = -0.2;  ///< heights outside are out of range
  double max_height_m = 0.2;
};

/// One row of a stream: a profile, or what is wrong with it.
struct ProfileRow {
  std::size_t row = 0;   ///< from 1
  std::size_t line = 0;  ///< of the file: also counts what is left out
  Profile profile;       ///< empty if damaged
  std::string fault;     ///< empty if whole; else names the row, the value and what would be right
};

/// Reads CSV row by row as they arrive (commas, semicolons or blanks; empty, "nan" or "-": no
/// value; empty lines and those that begin with '#' are left out), so that a pipe can be followed.
/// A separator at a line's end is no column, CRLF and a byte order mark do not matter. Damaged rows
/// take their time too: row n is of (n - 1) / rate_hz.
class ProfileStream {
 public:
  ProfileStream(std::istream& in, const ProfileFileOptions& options);
  /// nullopt at the end. A damaged row (ragged, not a number, out of range) is returned with its
  /// fault. Where the width is not given, the first row waits for the second, for it may have been
  /// cut off.
  std::optional<ProfileRow> Next();

 private:
  std::optional<ProfileRow> Read();
  void FixWidth();

  std::istream& in_;
  std::deque<ProfileRow> held_;  // read while the width was unknown
  ProfileFileOptions options_;
  std::size_t row_ = 0;
  std::size_t line_ = 0;
};

/// Reads a whole file: .csv/.txt, or a 16-bit grey .png/.pgm, one profile a row.
/// @throws core::InputError naming the file and the row: unreadable, no row at all, ragged, not a
/// number, out of range, not 16-bit grey; std::invalid_argument if an option is out of range.
std::vector<Profile> ReadProfiles(const std::filesystem::path& file,
                                  const ProfileFileOptions& options);

/// Writes CSV (.csv, .txt; numbers in `unit_m`, six digits after the point, no value is "nan") or a
/// 16-bit image (.png, .pgm). Times are not written.
/// @throws core::InputError for another ending, no profile, profiles of different widths, or a
/// height that does not fit into an image; core::RunError if it cannot be written whole.
void WriteProfiles(const std::vector<Profile>& profiles, const std::filesystem::path& file,
                   const ProfileFileOptions& options);

}  // namespace rangegrasp::seam
