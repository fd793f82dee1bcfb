#include "seam/profile_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>
#include <stdexcept>
#include <string_view>

#include "core/error.h"
#include "core/file.h"
#include "core/number.h"
#include "image/pgm.h"
#include "image/png.h"

namespace rangegrasp::seam {
namespace {

using core::InputError;

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
// Lines beyond are no profiles (a wrong file, a stuck pipe) and must not fill the memory.
constexpr std::size_t kLongestLine = std::size_t{4} << 20U;
constexpr std::string_view kBlanks = " \t";
// Whole rows that tell how wide the others are.
constexpr std::size_t kRowsOfWidth = 3;
// Damaged rows before them are not held back for ever.
constexpr std::size_t kMaxHeld = 16;

void Check(const ProfileFileOptions& options) {
  const auto check = [](bool good, const char* what) {
    if (!good) throw std::invalid_argument(std::string("profile file: ") + what);
  };
  check(options.columns >= 0, "columns must not be negative");
  check(options.unit_m > 0.0, "unit_m must be above 0");
  check(options.image_unit_m > 0.0, "image_unit_m must be above 0");
  check(options.rate_hz > 0.0, "rate_hz must be above 0");
  check(options.min_height_m < options.max_height_m, "min_height_m must be below max_height_m");
}

// A piece of a file for a message: short, and nothing that a terminal would obey.
std::string Quoted(std::string_view text) {
  // Characters: enough for a number with all its digits.
  constexpr std::size_t kMaxShown = 24;
  std::string shown(text.substr(0, kMaxShown));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return "'" + shown + (text.size() > kMaxShown ? "..." : "") + "'";
}

std::string_view Trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

enum class LineRead { kWhole, kTooLong, kEnd };

// The next line without its end (LF or CRLF).
LineRead ReadLine(std::istream& in, std::string& line) {
  line.clear();
  bool any = false;
  bool too_long = false;
  std::streambuf* buffer = in.rdbuf();
  for (int c = buffer->sbumpc(); c != std::char_traits<char>::eof(); c = buffer->sbumpc()) {
    any = true;
    if (c == '\n') break;
    if (line.size() < kLongestLine) {
      line.push_back(static_cast<char>(c));
    } else {
      too_long = true;
    }
  }
  if (!any) return LineRead::kEnd;
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return too_long ? LineRead::kTooLong : LineRead::kWhole;
}

// Fields between semicolons, else commas, else runs of blanks.
std::vector<std::string_view> Split(std::string_view line) {
  std::vector<std::string_view> fields;
  char separator = ' ';
  if (line.find(',') != std::string_view::npos) separator = ',';
  if (line.find(';') != std::string_view::npos) separator = ';';
  if (separator == ' ') {
    for (std::size_t end = 0;;) {
      const std::size_t begin = line.find_first_not_of(kBlanks, end);
      if (begin == std::string_view::npos) return fields;
      end = std::min(line.find_first_of(kBlanks, begin), line.size());
      fields.push_back(line.substr(begin, end - begin));
    }
  }
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    fields.push_back(Trimmed(line.substr(begin, end - begin)));
    if (end == line.size()) return fields;
    begin = end + 1;
  }
}

bool IsNoValue(std::string_view field) {
  if (field.empty() || field == "-") return true;
  return field.size() == 3 && (field[0] == 'n' || field[0] == 'N') &&
         (field[1] == 'a' || field[1] == 'A') && (field[2] == 'n' || field[2] == 'N');
}

// A field's number; nullopt if it is none, or one that no double holds.
std::optional<double> Number(std::string_view field) {
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  const auto number = core::NumberFrom<double>(field);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

bool InRange(double height_m, const ProfileFileOptions& options) {
  return height_m >= options.min_height_m && height_m <= options.max_height_m;
}

std::string RangeFault(const std::string& value, double unit, double zero,
                       const ProfileFileOptions& options) {
  return fmt::format("{} is out of range; it must be from {:.6g} to {:.6g}", value,
                     options.min_height_m / unit + zero, options.max_height_m / unit + zero);
}

// The fields' heights; what is wrong with them is returned.
std::string ParseFields(const std::vector<std::string_view>& fields,
                        const ProfileFileOptions& options, std::vector<float>& height_m) {
  height_m.assign(fields.size(), kMissing);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (IsNoValue(fields[i])) continue;
    const std::string where = fmt::format("column {}: ", i + 1);
    const auto number = Number(fields[i]);
    if (!number) {
      return where + Quoted(fields[i]) + " is not a number; no value is nan, - or nothing";
    }
    const double height = *number * options.unit_m;
    if (!InRange(height, options)) {
      return where + RangeFault(Quoted(fields[i]), options.unit_m, 0.0, options);
    }
    height_m[i] = static_cast<float>(height);
  }
  return {};
}

std::string WidthFault(std::size_t columns, int expected) {
  return fmt::format("has {} columns instead of {}", columns, expected);
}

// One line's heights; what is wrong with it is returned. `expected` 0: as many as there are.
std::string ParseLine(std::string_view line, int expected, const ProfileFileOptions& options,
                      std::vector<float>& height_m) {
  std::vector<std::string_view> fields = Split(line);
  const auto columns = static_cast<std::size_t>(expected);
  // A separator at the line's end begins no further field.
  if (fields.size() > 1 && fields.back().empty() &&
      (expected == 0 || fields.size() == columns + 1)) {
    fields.pop_back();
  }
  if (expected != 0 && fields.size() != columns) return WidthFault(fields.size(), expected);
  return ParseFields(fields, options, height_m);
}

void MarkDamaged(ProfileRow& row, const std::string& fault) {
  row.profile = {};
  row.fault = fmt::format("row {}{}{}{}", row.row,
                          row.line != row.row ? fmt::format(" (line {})", row.line) : "",
                          fault.starts_with("column") ? ", " : " ", fault);
}

std::ifstream Open(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    throw InputError(file.string() + ": is a folder, not a file of profiles");
  }
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file.string() + ": cannot be read");
  return in;
}

std::vector<Profile> ReadCsv(const std::filesystem::path& file, const ProfileFileOptions& options) {
  std::ifstream in = Open(file);
  ProfileStream stream(in, options);
  std::vector<Profile> profiles;
  while (auto row = stream.Next()) {
    if (!row->fault.empty()) throw InputError(file.string() + ": " + row->fault);
    profiles.push_back(std::move(row->profile));
  }
  if (profiles.empty()) throw InputError(file.string() + ": holds no profile");
  return profiles;
}

Profile ProfileOf(std::span<const std::uint16_t> grey, std::size_t row,
                  const ProfileFileOptions& options) {
  Profile profile;
  profile.time_s = static_cast<double>(row) / options.rate_hz;
  profile.height_m.assign(grey.size(), kMissing);
  for (std::size_t i = 0; i < grey.size(); ++i) {
    if (grey[i] == 0) continue;
    const double height = (grey[i] - options.image_zero) * options.image_unit_m;
    if (!InRange(height, options)) {
      throw InputError(fmt::format("row {}, column {}: grey level {}", row + 1, i + 1,
                                   RangeFault(fmt::format("{}", grey[i]), options.image_unit_m,
                                              options.image_zero, options)));
    }
    profile.height_m[i] = static_cast<float>(height);
  }
  return profile;
}

std::vector<Profile> ProfilesOf(const image::Grey16& image, const ProfileFileOptions& options) {
  const auto columns = static_cast<std::size_t>(image.width);
  if (options.columns != 0 && image.width != options.columns) {
    throw InputError(WidthFault(columns, options.columns));
  }
  std::vector<Profile> profiles;
  for (std::size_t row = 0; row < static_cast<std::size_t>(image.height); ++row) {
    profiles.push_back(
        ProfileOf(std::span(image.grey).subspan(row * columns, columns), row, options));
  }
  return profiles;
}

std::vector<Profile> ReadImage(const std::filesystem::path& file, bool png,
                               const ProfileFileOptions& options) {
  std::ifstream in = Open(file);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  try {
    return ProfilesOf(png ? image::DecodePng<image::Grey16>(bytes) : image::DecodePgm(bytes),
                      options);
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

void AppendNumber(std::string& text, double number) {
  char digits[400];  // of the largest double
  auto* end =
      std::to_chars(std::begin(digits), std::end(digits), number, std::chars_format::fixed, 6).ptr;
  while (end[-1] == '0') --end;
  if (end[-1] == '.') --end;
  const std::string_view shown(digits, static_cast<std::size_t>(end - digits));
  text += shown == "-0" ? "0" : shown;
}

std::string CsvOf(const std::vector<Profile>& profiles, const ProfileFileOptions& options) {
  std::string text;
  for (const Profile& profile : profiles) {
    for (std::size_t i = 0; i < profile.height_m.size(); ++i) {
      if (i > 0) text += ',';
      const auto height = static_cast<double>(profile.height_m[i]);
      if (std::isfinite(height)) {
        AppendNumber(text, height / options.unit_m);
      } else {
        text += "nan";
      }
    }
    text += '\n';
  }
  return text;
}

// The grey level of a height; 0 is no value, so what would fall on it takes the next one.
std::uint16_t GreyOf(float height_m, const ProfileFileOptions& options) {
  if (!std::isfinite(height_m)) return 0;
  const double grey =
      std::round(static_cast<double>(height_m) / options.image_unit_m + options.image_zero);
  if (!(grey >= 0.0 && grey <= 65535.0)) {
    throw InputError(fmt::format("height {:.6g} m does not fit into 16 bits of {:.6g} m", height_m,
                                 options.image_unit_m));
  }
  return static_cast<std::uint16_t>(std::max(grey, 1.0));
}

image::Grey16 ImageOf(const std::vector<Profile>& profiles, const ProfileFileOptions& options) {
  const std::size_t columns = profiles[0].height_m.size();
  image::Grey16 image{static_cast<int>(columns), static_cast<int>(profiles.size()), {}};
  image.grey.reserve(profiles.size() * columns);
  for (std::size_t row = 0; row < profiles.size(); ++row) {
    for (std::size_t i = 0; i < columns; ++i) {
      try {
        image.grey.push_back(GreyOf(profiles[row].height_m[i], options));
      } catch (const InputError& error) {
        throw InputError(fmt::format("row {}, column {}: {}", row + 1, i + 1, error.what()));
      }
    }
  }
  return image;
}

void CheckShape(const std::vector<Profile>& profiles) {
  if (profiles.empty()) throw InputError("there is no profile to write");
  const std::size_t columns = profiles[0].height_m.size();
  if (columns == 0) throw InputError("row 1 has no columns");
  for (std::size_t row = 0; row < profiles.size(); ++row) {
    if (profiles[row].height_m.size() == columns) continue;
    throw InputError(
        fmt::format("row {} {}", row + 1,
                    WidthFault(profiles[row].height_m.size(), static_cast<int>(columns))));
  }
}

std::string BytesOf(const std::vector<Profile>& profiles, const std::string& ending,
                    const ProfileFileOptions& options) {
  CheckShape(profiles);
  if (ending == ".csv" || ending == ".txt") return CsvOf(profiles, options);
  if (ending == ".png") return image::EncodePng(ImageOf(profiles, options));
  if (ending == ".pgm") return image::EncodePgm(ImageOf(profiles, options));
  throw InputError("unknown ending '" + ending + "'; profiles are .csv, .txt, .png or .pgm");
}

}  // namespace

ProfileStream::ProfileStream(std::istream& in, const ProfileFileOptions& options)
    : in_(in), options_(options) {
  Check(options);
}

std::optional<ProfileRow> ProfileStream::Next() {
  if (options_.columns == 0 && held_.empty()) FixWidth();
  if (held_.empty()) return Read();
  ProfileRow row = std::move(held_.front());
  held_.pop_front();
  return row;
}

// Two whole rows of one width settle it; of three different ones, and at the end, the first row's.
void ProfileStream::FixWidth() {
  std::vector<std::size_t> widths;
  while (options_.columns == 0 && held_.size() < kMaxHeld) {
    auto row = Read();
    if (!row) break;
    held_.push_back(std::move(*row));
    if (!held_.back().fault.empty()) continue;
    const std::size_t width = held_.back().profile.height_m.size();
    const bool again = std::ranges::find(widths, width) != widths.end();
    widths.push_back(width);
    if (again) options_.columns = static_cast<int>(width);
    if (widths.size() == kRowsOfWidth) break;
  }
  if (options_.columns == 0 && !widths.empty()) options_.columns = static_cast<int>(widths[0]);
  for (ProfileRow& row : held_) {
    const std::size_t width = row.profile.height_m.size();
    if (!row.fault.empty() || width == static_cast<std::size_t>(options_.columns)) continue;
    MarkDamaged(row, WidthFault(width, options_.columns));
  }
}

std::optional<ProfileRow> ProfileStream::Read() {
  std::string text;
  while (true) {
    const LineRead read = ReadLine(in_, text);
    if (read == LineRead::kEnd) return std::nullopt;
    ++line_;
    std::string_view line = text;
    if (line_ == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
    line = Trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    ProfileRow row;
    row.row = ++row_;
    row.line = line_;
    std::string fault = "is longer than a profile can be";
    if (read == LineRead::kWhole) {
      fault = ParseLine(line, options_.columns, options_, row.profile.height_m);
    }
    if (!fault.empty()) {
      MarkDamaged(row, fault);
      return row;
    }
    row.profile.time_s = static_cast<double>(row_ - 1) / options_.rate_hz;
    return row;
  }
}

std::vector<Profile> ReadProfiles(const std::filesystem::path& file,
                                  const ProfileFileOptions& options) {
  Check(options);
  const std::string ending = core::EndingOf(file);
  if (ending == ".csv" || ending == ".txt") return ReadCsv(file, options);
  if (ending == ".png" || ending == ".pgm") return ReadImage(file, ending == ".png", options);
  throw InputError(file.string() + ": unknown ending '" + ending +
                   "'; profiles are .csv, .txt, .png or .pgm");
}

void WriteProfiles(const std::vector<Profile>& profiles, const std::filesystem::path& file,
                   const ProfileFileOptions& options) {
  Check(options);
  std::string bytes;
  try {
    bytes = BytesOf(profiles, core::EndingOf(file), options);
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  core::WriteFile(file, bytes);
}

}  // namespace rangegrasp::seam
