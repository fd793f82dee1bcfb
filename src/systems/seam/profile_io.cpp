#include "seam/profile_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <deque>
#include <fstream>
#include <limits>
#include <numeric>
#include <sstream>

#include "base/error.h"
#include "base/file.h"
#include "base/image/image.h"
#include "base/units.h"
#include "seam/internal/profile_rows.h"
#include "seam/internal/tiff_file.h"

namespace rangegrasp::seam {
namespace {

using base::InputError;

bool IsText(const std::string& ending) { return ending == ".csv" || ending == ".txt"; }

std::string UnknownEnding(const std::string& ending, const char* known) {
  return "unknown ending '" + ending + "'; profiles are " + known;
}

// ---- images: a row is a profile ----

// Throws at the first pixel that is out of range.
template <typename Pixel>
std::vector<RawRow> RowsOf(const image::Grey<Pixel>& image, const HeightScale& scale,
                           const ProfileFileOptions& options) {
  const auto columns = static_cast<std::size_t>(image.width);
  if (options.columns != 0 && image.width != options.columns) {
    throw InputError(WidthFault(columns, options.columns));
  }
  std::vector<RawRow> rows(static_cast<std::size_t>(image.height));
  for (std::size_t i = 0; i < image.grey.size(); ++i) {
    const std::size_t number = i / columns + 1;
    RawRow& row = rows[number - 1];
    row.row = row.line = number;
    row.width = columns;
    const auto level = static_cast<double>(image.grey[i]);
    try {
      row.height_m.push_back(HeightOf(level, scale, options));
    } catch (const InputError& error) {
      throw InputError(fmt::format(
          "row {}, column {}: level {:.7g} {}; otherwise give image_scale_mm and image_offset_mm "
          "(--image-scale, --image-offset; now {:g} mm, {:g} mm)",
          number, i % columns + 1, level, error.what(), scale.unit_m * base::kMmPerM,
          (0.0 - scale.zero * scale.unit_m) * base::kMmPerM));
    }
  }
  return rows;
}

std::vector<RawRow> RowsOfTiff(const std::filesystem::path& file,
                               const ProfileFileOptions& options) {
  const image::Tiff tiff = image::ReadTiff(file);
  HeightScale scale = options.grey;
  if (tiff.pixel == image::TiffPixel::kSigned16) scale = options.signed_grey;
  if (tiff.pixel == image::TiffPixel::kFloat32) scale = options.real;
  // Rounded to float as in the file: float cannot represent -999.9999 exactly.
  for (double& none : scale.no_values) none = static_cast<float>(none);
  return RowsOf(tiff.picture, scale, options);
}

// ---- writing ----

// "1.25", "3", "nan".
std::string NumberText(double number) {
  if (!std::isfinite(number)) return "nan";
  std::string text = fmt::format("{:.6f}", number);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

// ---- the even grid, and times ----

// Maximum distance of neighboring points, relative to the usual one. Points with missing ones
// between them are further apart; points on slopes that a sensor sees are closer.
constexpr double kGap = 1.5;
// A column takes the height of a point at most half a point distance away, plus rounding errors.
constexpr double kNear = 0.5 * (1.0 + 1e-9);
// More columns in a line indicate a wrong unit or an outlier in x.
constexpr double kMaxGridColumns = 65536.0;

// Default of max_gap_s, relative to the time between the first two rows. The monitor also treats
// this many consecutive unusable profiles as an outage.
constexpr double kGapRows = 10.0;

struct GridPoint {
  double x_m;
  float height_m;
};

// The points with a height, sorted by x.
std::vector<GridPoint> PointsOf(const RawRow& row) {
  std::vector<GridPoint> points;
  for (std::size_t i = 0; i < row.x_m.size(); ++i) {
    if (!std::isfinite(row.x_m[i]) || !std::isfinite(row.height_m[i])) continue;
    points.push_back({row.x_m[i], row.height_m[i]});
  }
  std::ranges::stable_sort(points, {}, &GridPoint::x_m);
  return points;
}

// Mean distance of neighboring points without gaps. Unlike a median, it causes no shift along the
// line if x is rounded to a few digits. 0 if there are fewer than two places.
double UsualDistance(const std::vector<GridPoint>& points) {
  std::vector<double> distances;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double distance = points[i].x_m - points[i - 1].x_m;
    if (distance > 0.0) distances.push_back(distance);
  }
  if (distances.empty()) return 0.0;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::ranges::nth_element(distances, middle);
  const double longest = kGap * *middle;
  std::erase_if(distances, [longest](double distance) { return distance > longest; });
  return std::accumulate(distances.begin(), distances.end(), 0.0) /
         static_cast<double>(distances.size());
}

// The grid that contains all points with a height. If columns_per_m is 0, its pitch is the usual
// distance of neighboring points. Nullopt if no row has two points.
std::optional<ProfileGrid> GridOf(const std::deque<RawRow>& rows, double columns_per_m) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  double pitch = columns_per_m > 0.0 ? 1.0 / columns_per_m : 0.0;
  for (const RawRow& row : rows) {
    const auto points = PointsOf(row);
    if (points.size() < 2) continue;
    low = std::min(low, points.front().x_m);
    high = std::max(high, points.back().x_m);
    if (pitch == 0.0) pitch = UsualDistance(points);
  }
  if (!(pitch > 0.0) || !(high > low)) return std::nullopt;
  const double columns = std::round((high - low) / pitch) + 1.0;
  if (columns > kMaxGridColumns) {
    throw InputError(fmt::format(
        "x from {:.6g} to {:.6g} m with {:.6g} columns per metre gives {:.0f} columns; "
        "at most {:.0f} are allowed; for another unit use unit_mm (--unit um or --unit m), "
        "for a missing value among x no_values (--no-value)",
        low, high, 1.0 / pitch, columns, kMaxGridColumns));
  }
  return ProfileGrid{low, pitch, static_cast<std::size_t>(columns)};
}

// A row's heights at the columns of a grid, linear between neighboring points. Gaps (kGap) and
// unmeasured columns stay empty.
std::vector<float> OnGrid(const RawRow& row, const ProfileGrid& grid) {
  std::vector<float> heights(grid.columns, std::numeric_limits<float>::quiet_NaN());
  const auto points = PointsOf(row);
  const double typical = UsualDistance(points);
  const double near = kNear * std::max(typical, grid.pitch_m);
  std::size_t next = 0;  // the first point at or beyond the column
  for (std::size_t column = 0; column < grid.columns; ++column) {
    const double x = grid.first_m + static_cast<double>(column) * grid.pitch_m;
    while (next < points.size() && points[next].x_m < x) ++next;
    const GridPoint* right = next < points.size() ? &points[next] : nullptr;
    const GridPoint* left = next > 0 ? &points[next - 1] : nullptr;
    if (left != nullptr && right != nullptr && right->x_m - left->x_m <= kGap * typical) {
      const double share = (x - left->x_m) / (right->x_m - left->x_m);
      heights[column] = static_cast<float>((1.0 - share) * static_cast<double>(left->height_m) +
                                           share * static_cast<double>(right->height_m));
    } else if (right != nullptr && right->x_m - x <= near) {
      heights[column] = right->height_m;
    } else if (left != nullptr && x - left->x_m <= near) {
      heights[column] = left->height_m;
    }
  }
  return heights;
}

// Number of valid rows with x that determine the grid of a stream, and maximum number of rows read
// to find them.
constexpr std::size_t kRowsOfGrid = 3;
constexpr std::size_t kMaxHeld = 16;

// Converts rows to profiles, in order: resamples them to the even grid and sets their times.
class ProfileRows {
 public:
  ProfileRows(RowSource source, const ProfileFileOptions& options)
      : source_(std::move(source)), options_(options) {}

  // Reads the first row and, if it has x, the rows that determine the grid.
  void Hold(std::size_t rows_with_x, std::size_t max_rows) {
    std::size_t with_x = 0;
    while (held_.size() < max_rows && with_x < rows_with_x) {
      auto row = source_();
      if (!row) break;
      const bool whole = row->fault.empty();
      with_x += whole && !row->x_m.empty() ? 1 : 0;
      begun_ = begun_ || whole;
      held_.push_back(std::move(*row));
      if (with_x == 0) break;
    }
    if (!grid_) grid_ = GridOf(held_, options_.columns_per_m);
    if (with_x > 0) begun_ = grid_.has_value();
  }

  std::optional<ProfileRow> Next() {
    if (!begun_ && held_.empty()) Hold(kRowsOfGrid, kMaxHeld);
    auto row = held_.empty() ? source_() : TakeFirst(held_);
    return row ? std::optional(Finish(std::move(*row))) : std::nullopt;
  }

  const std::optional<ProfileGrid>& grid() const { return grid_; }

 private:
  struct Stamp {
    double time_s = 0.0;
    std::optional<double> position_m;
  };

  ProfileRow Finish(RawRow&& row) {
    const Stamp stamp = StampOf(row);
    const std::string fault = row.fault.empty() ? FaultOf(row, stamp) : "";
    if (!fault.empty()) MarkDamaged(row, fault);
    ProfileRow made{row.row, row.line, {}, row.fault, row.position_m, {}};
    if (!made.fault.empty()) return made;
    if (row.time_s || row.position_m) made.gap_s = GapBefore(stamp);
    last_ = stamp;
    made.profile.time_s = stamp.time_s;
    made.profile.height_m = grid_ ? OnGrid(row, *grid_) : std::move(row.height_m);
    return made;
  }

  Stamp StampOf(const RawRow& row) const {
    Stamp stamp{static_cast<double>(row.row - 1) / options_.rate_hz, row.position_m};
    if (row.position_m) stamp.time_s = *row.position_m / options_.feed_m_per_s;
    if (row.time_s) stamp.time_s = *row.time_s;
    return stamp;
  }

  std::string FaultOf(const RawRow& row, const Stamp& stamp) const {
    if (last_ && stamp.position_m && last_->position_m && *stamp.position_m < *last_->position_m) {
      return fmt::format(
          "is at {:.6g} mm of the path, the previous row at {:.6g} mm; the encoder must not go "
          "back",
          *stamp.position_m * base::kMmPerM, *last_->position_m * base::kMmPerM);
    }
    if (last_ && stamp.time_s < last_->time_s) {
      return fmt::format("has time {:.9g} s, the previous row {:.9g} s; time must not go back",
                         stamp.time_s, last_->time_s);
    }
    return row.x_m.empty() || grid_ ? "" : "has fewer than two points with a height";
  }

  std::optional<double> GapBefore(const Stamp& stamp) {
    if (!last_) return std::nullopt;
    const double passed_s = stamp.time_s - last_->time_s;
    if (max_gap_s_ == 0.0) {
      max_gap_s_ = options_.max_gap_s > 0.0 ? options_.max_gap_s : kGapRows * passed_s;
    }
    if (max_gap_s_ == 0.0 || passed_s <= max_gap_s_) return std::nullopt;
    return passed_s;
  }

  RowSource source_;
  ProfileFileOptions options_;
  std::deque<RawRow> held_;  // read while the grid was unknown
  bool begun_ = false;
  std::optional<ProfileGrid> grid_;
  std::optional<Stamp> last_;  // of the last valid row
  double max_gap_s_ = 0.0;     // 0: not known yet
};

// ---- reading ----

RowSource RowsOf(const std::filesystem::path& file, const ProfileFileOptions& options) {
  const std::string ending = base::EndingOf(file);
  if (!IsText(ending) && !IsImageFile(file)) {
    throw InputError(UnknownEnding(ending, ".csv, .txt, .png, .tif or .tiff"));
  }
  if (const auto why = base::WhyUnfit(file); !why.empty()) throw InputError(why);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(fmt::format("cannot be read: {}", std::strerror(errno)));
  if (IsText(ending)) {
    const auto text = std::make_shared<std::istringstream>(base::ReadAll(in));
    return [text, next = RowsOfText(*text, options)] { return next(); };
  }
  auto rows = std::make_shared<std::vector<RawRow>>(
      ending == ".png"
          ? RowsOf(image::DecodePng<image::Grey16>(base::ReadAll(in)), options.grey, options)
          : RowsOfTiff(file, options));
  return [rows, next = rows->begin()]() mutable -> std::optional<RawRow> {
    return next == rows->end() ? std::nullopt : std::optional(std::move(*next++));
  };
}

}  // namespace

bool IsImageFile(const std::filesystem::path& file) {
  const std::string ending = base::EndingOf(file);
  return ending == ".png" || ending == ".tif" || ending == ".tiff";
}

struct ProfileStream::Impl : ProfileRows {
  using ProfileRows::ProfileRows;
};

ProfileStream::ProfileStream(std::istream& in, const ProfileFileOptions& options)
    : impl_(std::make_unique<Impl>(RowsOfText(in, options), options)) {}
ProfileStream::~ProfileStream() = default;
std::optional<ProfileRow> ProfileStream::Next() { return impl_->Next(); }
std::optional<ProfileGrid> ProfileStream::grid() const { return impl_->grid(); }

ProfileFile ReadProfileFile(const std::filesystem::path& file, const ProfileFileOptions& options) {
  try {
    ProfileRows rows(RowsOf(file, options), options);
    constexpr auto kAll = std::numeric_limits<std::size_t>::max();
    rows.Hold(kAll, kAll);
    ProfileFile read;
    while (auto row = rows.Next()) {
      if (!row->fault.empty()) throw InputError(row->fault);
      read.rows.push_back(std::move(*row));
    }
    if (read.rows.empty()) throw InputError("contains no profile");
    read.grid = rows.grid();
    return read;
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

void WriteProfiles(const std::vector<Profile>& profiles, const std::filesystem::path& file,
                   double unit_m) {
  const std::string ending = base::EndingOf(file);
  if (!IsText(ending)) {
    throw InputError(file.string() + ": " + UnknownEnding(ending, "written as .csv or .txt"));
  }
  std::string text;
  for (const Profile& profile : profiles) {
    for (const float height_m : profile.height_m) {
      text += NumberText(static_cast<double>(height_m) / unit_m) + ',';
    }
    text.back() = '\n';
  }
  base::WriteFile(file, text);
}

}  // namespace rangegrasp::seam
