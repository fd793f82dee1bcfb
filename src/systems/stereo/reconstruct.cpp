#include "stereo/reconstruct.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "base/statistics.h"
#include "base/units.h"
#include "stereo/internal/open_cv.h"

namespace rangegrasp::stereo {
namespace {

using base::kMm;

// Reads the side of a window, which must be odd.
void ReadWindow(base::YamlMap& map, const char* key, int& value, int low, int high,
                const char* doc) {
  map.Read(key, value, low, high, doc);
  if (value % 2 == 0) map.Fail(key, "must be odd: a window has a middle");
}

void ReadMatch(base::YamlMap& map, MatchOptions& o) {
  map.Read("matching", o.method, "stereo matching method; the dissertation uses block matching");
  map.Read("shrink", o.shrink, 1, 8,
           "pictures are reduced by this factor before matching; the following keys are in reduced "
           "pixels");
  ReadWindow(map, "block_window_px", o.block_window_px, 5, 255,
             "block: side of the matching window, odd");
  ReadWindow(map, "semi_global_window_px", o.semi_global_window_px, 1, 15,
             "semi_global: side of the matching window, odd");
  map.Read("uniqueness_percent", o.uniqueness_percent, 0, 100,
           "minimum relative difference between the best and the second best match");
  map.Read("max_left_right_px", o.max_left_right_px, -1, 100,
           "maximum difference between left-to-right and right-to-left matches; -1: not checked; "
           "semi_global takes 0 for 1");
  map.Read("min_patch_px", o.min_patch_px, 0, 1000000, "minimum size of a patch of matches");
  map.Read("consensus_share", o.consensus_share, 0.0, 1.0,
           "minimum share of the surrounding pixels of similar colour that have the same "
           "disparity; 0: not checked");
  map.Read("min_edges", o.min_edges, 0.0, 100.0,
           "minimum number of edge pixels of a patch, relative to its width; 0: not checked");
}

constexpr double kNoDepth = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNoiseDeviations = 3.0;

/// Minimum relative difference of blue to red and green in a blue pixel: more than the effect of
/// noise in a grey one. Larger: shadows on the table remain; smaller: grey objects are removed.
constexpr double kBlueShare = 0.15;
/// The same, absolute [of 255]: in nearly black pixels, noise alone gives large shares.
constexpr int kBlueLevels = 12;
/// Side of the window whose majority decides whether a pixel is blue.
constexpr int kBlueWindow_px = 5;
/// A sample is the mean of the disparities near their median. Minimum share of its pixels that
/// agree; larger: fewer samples that mix two surfaces.
constexpr double kMinShare = 0.5;
constexpr double kMaxSpread_px = 1.0;

/// Brightness of the kept pixels, black elsewhere.
image::Grey8 BrightnessOf(const image::Image& picture, const Mask& kept) {
  image::Grey8 grey;
  cv::Mat room = internal::Room(picture.width, picture.height, grey);
  cv::cvtColor(internal::View(picture), room, cv::COLOR_RGB2GRAY);
  room.setTo(0, internal::View(kept) == 0);
  return grey;
}

Mask KeptPixels(const image::Image& picture, const ReconstructOptions& options) {
  if (!options.remove_blue) return WithoutBlue(picture, 1.0, 255, 1);  // nothing is that blue
  return WithoutBlue(picture, kBlueShare, kBlueLevels, kBlueWindow_px);
}

/// A range of depths [m] or disparities [px]; without values if high is not above low.
struct Range {
  double low = 0.0;
  double high = 0.0;
  bool Any() const { return high > low; }
};

/// Range of t in which one coordinate of origin + t direction lies between low and high.
Range Between(double origin, double direction, double low, double high) {
  if (direction == 0.0) {
    return low <= origin && origin <= high ? Range{0.0, kInfinity} : Range{};
  }
  const double a = (low - origin) / direction, b = (high - origin) / direction;
  return {std::min(a, b), std::max(a, b)};
}

/// Depths at which the ray of a pixel of the left rectified camera is inside the volume.
Range Inside(const Volume& volume, const RectifiedCameras& cameras, double x, double y) {
  const base::Pose X_VS = volume.X_WV.inverse() * cameras.X_WS;
  const Eigen::Vector3d o = X_VS.translation();
  const Eigen::Vector3d d =  // of depth 1, so that lengths along it are depths
      X_VS.rotation() * cameras.RayAt(x, y);
  const double a = d.head<2>().squaredNorm();
  const double b = d.head<2>().dot(o.head<2>());
  const double c = o.head<2>().squaredNorm() - volume.radius_m * volume.radius_m;
  Range round{0.0, c <= 0.0 ? kInfinity : 0.0};  // of a ray along the axis
  if (a > 0.0) {
    const double discriminant = b * b - a * c;
    if (!(discriminant > 0.0)) return {};
    round = {(-b - std::sqrt(discriminant)) / a, (-b + std::sqrt(discriminant)) / a};
  }
  const Range level = Between(o.z(), d.z(), 0.0, volume.height_m);
  return {std::max({round.low, level.low, 0.0}), std::min(round.high, level.high)};
}

// Mean of those values that are near their median; nullopt if there are too few.
std::optional<double> CommonValue(const std::vector<float>& values, int min_count,
                                  double max_spread) {
  if (values.empty() || std::cmp_less(values.size(), min_count)) return std::nullopt;
  const double median = base::UpperMedianOf(values);
  double sum = 0.0;
  int count = 0;
  for (const float value : values) {
    if (std::abs(value - median) > max_spread) continue;
    sum += value;
    ++count;
  }
  if (count < min_count) return std::nullopt;
  return sum / count;
}

/// The samples of a picture: squares of step_px pixels, and the disparities that each may have.
class Grid {
 public:
  Grid(const RectifiedCameras& cameras, const ReconstructOptions& options)
      : step_px(options.step_px), rows(cameras.height / step_px), columns(cameras.width / step_px) {
    // Noise may move a measured point of the volume this far outside.
    const double slack_px = kNoiseDeviations * options.disparity_sigma_px;
    const Range all{cameras.DisparityAt(options.far_m), cameras.DisparityAt(options.near_m)};
    searches_.assign(IndexOf(0, rows), all);
    if (!options.volume) return;
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        const Range depths = Inside(*options.volume, cameras, MiddleOf(column), MiddleOf(row));
        Range& search = searches_[IndexOf(column, row)];
        if (!depths.Any()) {
          search = {};
          continue;
        }
        search.low = std::max(search.low, cameras.DisparityAt(depths.high) - slack_px);
        search.high = std::min(search.high, cameras.DisparityAt(depths.low) + slack_px);
      }
    }
  }

  double MiddleOf(int sample) const { return sample * step_px + 0.5 * (step_px - 1); }
  std::size_t IndexOf(int column, int row) const { return image::IndexAt(column, row, columns); }
  const Range& SearchOf(int column, int row) const { return searches_[IndexOf(column, row)]; }
  double MaxDisparity() const {
    double max_px = 0.0;
    for (const Range& search : searches_) {
      if (search.Any()) max_px = std::max(max_px, search.high);
    }
    return max_px;
  }
  cv::Rect PixelsOf(int column, int row) const {
    return {column * step_px, row * step_px, step_px, step_px};
  }
  /// The pixels of a mask whose sample has disparities to search.
  Mask Searched(const Mask& mask) const {
    Mask searched;
    cv::Mat room = internal::Room(mask.width, mask.height, searched);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        if (!SearchOf(column, row).Any()) continue;
        const cv::Rect pixels = PixelsOf(column, row);
        internal::View(mask)(pixels).copyTo(room(pixels));
      }
    }
    return searched;
  }

  const int step_px;
  const int rows;
  const int columns;

 private:
  std::vector<Range> searches_;
};

// The blue pixels that show the table: those in large patches.
cv::Mat TablePixels(const image::Image& picture, const Mask& kept, int min_px) {
  cv::Mat black, patches, statistics, centers;
  cv::inRange(internal::View(picture), cv::Scalar::all(0), cv::Scalar::all(0), black);
  cv::Mat table = (internal::View(kept) == 0) & (black == 0);
  cv::connectedComponentsWithStats(table, patches, statistics, centers, /*connectivity=*/4);
  for (int y = 0; y < table.rows; ++y) {
    for (int x = 0; x < table.cols; ++x) {
      const int area = statistics.at<int>(patches.at<int>(y, x), cv::CC_STAT_AREA);
      if (area < min_px) table.at<std::uint8_t>(y, x) = 0;
    }
  }
  return table;
}

class Sampler {
 public:
  Sampler(const Rectifier& rectifier, const Grid& grid, const ReconstructOptions& options,
          Reconstruction& into)
      : rectifier_(rectifier), cameras_(rectifier.cameras()), grid_(grid), o_(options), r_(into) {
    if (o_.table_W && o_.remove_blue) {
      table_ = TablePixels(r_.rectified.left, r_.kept, o_.min_table_px);
    }
  }

  void Run() {
    auto& image = r_.view.image;
    image.profiles = grid_.rows;
    image.samples = grid_.columns;
    image.origins_C = {cameras_.X_WS.translation()};
    for (int row = 0; row < grid_.rows; ++row) {
      for (int column = 0; column < grid_.columns; ++column) Add(column, row);
    }
    r_.view.X_CV = cameras_.X_WS;
    r_.view.spacing_m = geometry::MedianSpacing(image);
  }

 private:
  void Add(int column, int row) {
    const double x = grid_.MiddleOf(column), y = grid_.MiddleOf(row);
    Eigen::Vector3d p_W = Eigen::Vector3d::Constant(kNoDepth);
    double noise_m = kNoDepth;
    if (const auto disparity = DisparityOf(column, row)) {
      p_W = cameras_.Triangulate(x, y, *disparity);
      const double depth_m = cameras_.f * cameras_.baseline_m / *disparity;
      const double ray_m = (p_W - cameras_.X_WS.translation()).norm();
      noise_m = cameras_.DepthPerPixel(depth_m) * o_.disparity_sigma_px * ray_m / depth_m;
    } else if (IsTable(column, row)) {
      p_W = OnTable(x, y);
      noise_m = 0.0;
    }
    r_.view.image.points_C.push_back(p_W);
    r_.view.noise_m.push_back(static_cast<float>(noise_m));
    r_.left_pixel.push_back(rectifier_.LeftSource(x, y).cast<float>());
  }

  std::optional<double> DisparityOf(int column, int row) {
    const Range& search = grid_.SearchOf(column, row);
    if (!search.Any()) return std::nullopt;
    std::vector<float> values;
    for (const float d :
         cv::Mat_<float>(internal::View(r_.disparity)(grid_.PixelsOf(column, row)))) {
      if (!std::isnan(d)) values.push_back(d);
    }
    const auto value = CommonValue(values, min_count_, kMaxSpread_px);
    if (value && (*value < search.low || *value > search.high)) return std::nullopt;
    return value;
  }

  // True if most of a sample's pixels have the table's colour.
  bool IsTable(int column, int row) const {
    return !table_.empty() && cv::countNonZero(table_(grid_.PixelsOf(column, row))) >= min_count_;
  }

  Eigen::Vector3d OnTable(double x, double y) const {
    const Eigen::Vector3d origin_W = cameras_.X_WS.translation();
    const Eigen::Vector3d ray_W = cameras_.X_WS.rotation() * cameras_.RayAt(x, y);
    const double along = -o_.table_W->Distance(origin_W) / o_.table_W->normal.dot(ray_W);
    if (!(along > 0.0)) return Eigen::Vector3d::Constant(kNoDepth);
    return origin_W + along * ray_W;
  }

  const Rectifier& rectifier_;
  const RectifiedCameras& cameras_;
  const Grid& grid_;
  const ReconstructOptions& o_;
  Reconstruction& r_;
  const int min_count_ =
      static_cast<int>(std::max(1.0, std::ceil(kMinShare* o_.step_px* o_.step_px)));
  cv::Mat table_;
};

}  // namespace

Mask WithoutBlue(const image::Image& picture, double blue_share, int blue_levels, int window_px) {
  Mask mask;
  const cv::Mat room = internal::Room(picture.width, picture.height, mask);
  for (std::size_t i = 0; i < mask.grey.size(); ++i) {
    const int red = picture.rgb[3 * i], green = picture.rgb[3 * i + 1],
              blue = picture.rgb[3 * i + 2];
    const int other = std::max(red, green);
    const bool dominant = other < (1.0 - blue_share) * blue && other < blue - blue_levels;
    const bool black = other == 0 && blue == 0;  // the camera saw nothing there, or not enough
    mask.grey[i] = dominant || black ? 0 : 255;
  }
  if (window_px > 1) cv::medianBlur(room, room, window_px);
  return mask;
}

Reconstruction Reconstruct(const image::Image& left, const image::Image& right,
                           const Rectifier& rectifier, const ReconstructOptions& options) {
  const internal::SingleThread single;
  Reconstruction result;
  result.rectified = rectifier.Apply(left, right);
  result.kept = KeptPixels(result.rectified.left, options);
  const RectifiedCameras& cameras = rectifier.cameras();
  const Grid grid(cameras, options);
  const double max_px = grid.MaxDisparity();
  if (max_px == 0.0) {
    throw base::InputError(
        "the stereo camera does not see the volume for reconstruction: no pixel's ray meets it");
  }
  const Mask right_kept = KeptPixels(result.rectified.right, options);
  result.disparity =
      Match(BrightnessOf(result.rectified.left, result.kept),
            BrightnessOf(result.rectified.right, right_kept), grid.Searched(result.kept),
            result.rectified.left, cameras.DisparityAt(options.far_m), max_px, options.match);
  Sampler(rectifier, grid, options, result).Run();
  return result;
}

void ReadReconstructOptions(base::YamlMap& map, ReconstructOptions& o) {
  ReadMatch(map, o.match);
  map.Read("remove_blue", o.remove_blue,
           "remove blue pixels before matching: they belong to the table");
  map.Read("step_px", o.step_px, 1, 64, "distance in pixels between samples in both directions");
  map.ReadScaled("height_mm", o.volume_height_m, kMm, 10.0, 1e4,
                 "maximum height above the workspace for reconstruction");
  map.ReadScaled("near_mm", o.near_m, kMm, 10.0, 1e5, "minimum depth");
  map.ReadScaled("far_mm", o.far_m, kMm, 10.0, 1e5, "maximum depth");
  map.Read("disparity_sigma_px", o.disparity_sigma_px, 0.0, 100.0,
           "standard deviation of a disparity, from which the noise of a sample is computed");
  if (o.near_m >= o.far_m)
    map.Fail(map.Has("near_mm") ? "near_mm" : "far_mm", "near_mm must be below far_mm");
  map.Finish();
}

}  // namespace rangegrasp::stereo
