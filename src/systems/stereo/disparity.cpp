#include "stereo/disparity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "stereo/internal/open_cv.h"

namespace rangegrasp::stereo {
namespace {

// OpenCV: the number of disparities is a multiple of 16; results are in sixteenths of a pixel.
constexpr int kDisparityStep = 16;
constexpr float kSubpixels = 16.0F;
// Limit of slopes in both matchers' prefilters (OpenCV's default for block matching): neither a
// difference in exposure nor one strong edge in a window dominates.
constexpr int kPrefilterCap = 31;
constexpr int kHalfKept = 128;  // of 255, the mean of a mask over a shrunk pixel
// Costs of a disparity step of one and of a larger one in semi-global matching, in grey levels per
// pixel of the window. Larger: smoother, but steps are lost.
constexpr int kSmallStepCost = 8;
constexpr int kLargeStepCost = 32;
// Minimum texture of a block: the sum of its slopes, limited to the prefilter's 31.
constexpr int kMinTexture = 10;
constexpr int kPatchStep_px = 1;
// Surrounding pixels whose disparity must agree: up to this far away, with this maximum difference
// of each colour channel.
constexpr int kConsensusReach_px = 24;
constexpr int kConsensusLevels = 20;
// Minimum grey level difference of neighbors at an edge: above the noise of a shrunk picture.
constexpr double kEdgeLevels = 5.0;

// Adds a margin for windows at the border, and on the left for the right picture's columns.
cv::Rect Widened(const cv::Rect& kept, int margin, int max_px, const Mask& mask) {
  const cv::Rect wide(kept.x - max_px - margin, kept.y - margin, kept.width + max_px + 2 * margin,
                      kept.height + 2 * margin);
  return wide & cv::Rect(0, 0, mask.width, mask.height);
}

cv::Mat Shrunk(const cv::Mat& picture, int by) {
  if (by == 1) return picture;
  cv::Mat small;  // only of whole squares: others would be shifted
  cv::resize(picture(cv::Rect(0, 0, picture.cols / by * by, picture.rows / by * by)), small,
             cv::Size(picture.cols / by, picture.rows / by), 0.0, 0.0, cv::INTER_AREA);
  return small;
}

cv::Mat SixteenthsOf(const cv::Mat& left, const cv::Mat& right, int min_px, int disparities,
                     const MatchOptions& o) {
  cv::Mat sixteenths;
  if (o.method == MatchMethod::kBlock) {
    const auto matcher = cv::StereoBM::create(disparities, o.block_window_px);
    matcher->setMinDisparity(min_px);
    matcher->setPreFilterCap(kPrefilterCap);
    matcher->setTextureThreshold(kMinTexture);
    matcher->setUniquenessRatio(o.uniqueness_percent);
    matcher->setDisp12MaxDiff(o.max_left_right_px);
    matcher->compute(left, right, sixteenths);
    return sixteenths;
  }
  // This matcher takes a default of its own for a difference of 0 or less.
  const int window = o.semi_global_window_px;
  const int area = window * window;
  const int difference = o.max_left_right_px < 0 ? disparities : std::max(1, o.max_left_right_px);
  const auto matcher = cv::StereoSGBM::create(min_px, disparities, window, kSmallStepCost * area,
                                              kLargeStepCost * area, difference, kPrefilterCap,
                                              o.uniqueness_percent, /*speckleWindowSize=*/0,
                                              /*speckleRange=*/0, cv::StereoSGBM::MODE_HH);
  matcher->compute(left, right, sixteenths);
  return sixteenths;
}

// Pixels where the grey value changes along the row, as needed for a match.
cv::Mat Edges(const cv::Mat& picture) {
  constexpr double kSobelGain = 8.0;  // for a slope of one level per pixel
  cv::Mat grey, slope;
  cv::cvtColor(picture, grey, cv::COLOR_RGB2GRAY);
  cv::Sobel(grey, slope, CV_16S, 1, 0);
  return cv::abs(slope) > kSobelGain * kEdgeLevels;
}

/// The patch around a pixel in which disparities of neighbors differ by at most `step`; marks its
/// pixels as visited.
std::vector<cv::Point> PatchFrom(const cv::Point& first, const cv::Mat& sixteenths, int step,
                                 cv::Mat& visited) {
  const auto at = [&](const cv::Point& p) { return sixteenths.at<std::int16_t>(p); };
  const cv::Rect whole(cv::Point(), sixteenths.size());
  std::vector<cv::Point> patch = {first};
  visited.at<std::uint8_t>(first) = 1;
  for (std::size_t next = 0; next < patch.size(); ++next) {
    const cv::Point p = patch[next];
    for (const cv::Point& to : {cv::Point(p.x - 1, p.y), cv::Point(p.x + 1, p.y),
                                cv::Point(p.x, p.y - 1), cv::Point(p.x, p.y + 1)}) {
      if (!whole.contains(to) || visited.at<std::uint8_t>(to) != 0) continue;
      if (std::abs(at(to) - at(p)) > step) continue;
      visited.at<std::uint8_t>(to) = 1;
      patch.push_back(to);
    }
  }
  return patch;
}

// Removes patches of disparities that are too small or have too few edges.
void FilterPatches(const cv::Mat& edges, int none, const MatchOptions& o, cv::Mat& sixteenths) {
  const int step = kPatchStep_px * static_cast<int>(kSubpixels);
  cv::Mat visited = sixteenths <= none;
  for (int y = 0; y < sixteenths.rows; ++y) {
    for (int x = 0; x < sixteenths.cols; ++x) {
      if (visited.at<std::uint8_t>(y, x) != 0) continue;
      const auto patch = PatchFrom({x, y}, sixteenths, step, visited);
      const auto held = std::ranges::count_if(
          patch, [&](const cv::Point& p) { return edges.at<std::uint8_t>(p) != 0; });
      const auto size = static_cast<double>(patch.size());
      if (size >= o.min_patch_px && static_cast<double>(held) >= o.min_edges * std::sqrt(size)) {
        continue;
      }
      for (const cv::Point& p : patch) {
        sixteenths.at<std::int16_t>(p) = static_cast<std::int16_t>(none);
      }
    }
  }
}

// Removes disparities that surrounding pixels of similar colour do not share.
void KeepConsensus(const cv::Mat& colours, int none, const MatchOptions& o, cv::Mat& sixteenths) {
  constexpr int kCostSteps = 4;           // to either side
  constexpr double kMaxSlope = 1.0 / 16;  // of a disparity along a surface: more is hardly seen
  const int stride = kConsensusReach_px / kCostSteps;
  const double tolerance = kSubpixels * (1.0 + kMaxSlope * kConsensusReach_px);
  const auto like = [](const cv::Vec3b& a, const cv::Vec3b& b) {
    return std::abs(a[0] - b[0]) <= kConsensusLevels && std::abs(a[1] - b[1]) <= kConsensusLevels &&
           std::abs(a[2] - b[2]) <= kConsensusLevels;
  };
  const cv::Mat before = sixteenths.clone();
  for (int y = 0; y < before.rows; ++y) {
    for (int x = 0; x < before.cols; ++x) {
      const std::int16_t own = before.at<std::int16_t>(y, x);
      if (own <= none) continue;
      const auto& colour = colours.at<cv::Vec3b>(y, x);
      int asked = 0, agree = 0;
      for (int v = std::max(y - kCostSteps * stride, y % stride);
           v <= std::min(y + kCostSteps * stride, before.rows - 1); v += stride) {
        for (int u = std::max(x - kCostSteps * stride, x % stride);
             u <= std::min(x + kCostSteps * stride, before.cols - 1); u += stride) {
          if (!like(colour, colours.at<cv::Vec3b>(v, u))) continue;
          const std::int16_t other = before.at<std::int16_t>(v, u);
          ++asked;
          agree += other > none && std::abs(other - own) <= tolerance ? 1 : 0;
        }
      }
      if (agree < o.consensus_share * asked) {
        sixteenths.at<std::int16_t>(y, x) = static_cast<std::int16_t>(none);
      }
    }
  }
}

}  // namespace

Disparity Match(const image::Grey8& left, const image::Grey8& right, const Mask& left_mask,
                const image::Image& whole_left, double min_px, double max_px,
                const MatchOptions& options) {
  Disparity result{left.width, left.height, {}};
  result.grey.assign(left.grey.size(), std::numeric_limits<float>::quiet_NaN());
  const cv::Rect kept = cv::boundingRect(internal::View(left_mask));
  if (kept.empty()) return result;

  const int first = cvFloor(min_px / options.shrink);
  const int range = cvCeil(max_px / options.shrink) - first + 1;
  const int disparities = (range + kDisparityStep - 1) / kDisparityStep * kDisparityStep;
  const int margin =
      options.shrink * std::max(options.block_window_px, options.semi_global_window_px);
  const int reach = options.shrink * (first + disparities);
  const cv::Rect part = Widened(kept, margin, reach, left_mask);
  if (part.width <= reach + margin || part.height <= margin) return result;

  const internal::SingleThread single;
  const auto small = [&](const cv::Mat& picture) { return Shrunk(picture(part), options.shrink); };
  cv::Mat sixteenths = SixteenthsOf(small(internal::View(left)), small(internal::View(right)),
                                    first, disparities, options);
  const int none = (first - 1) * static_cast<int>(kSubpixels);
  // Removed pixels have one colour, match anything and would join patches.
  sixteenths.setTo(none, small(internal::View(left_mask)) < kHalfKept);
  const cv::Mat colours = small(internal::View(whole_left));
  if (options.consensus_share > 0.0) KeepConsensus(colours, none, options, sixteenths);
  FilterPatches(Edges(colours), none, options, sixteenths);
  const float pixels = static_cast<float>(options.shrink) / kSubpixels;
  // Pixels beyond the last whole square have no disparity.
  const int height = sixteenths.rows * options.shrink, width = sixteenths.cols * options.shrink;
  for (int y = 0; y < std::min(part.height, height); ++y) {
    const auto* row = sixteenths.ptr<std::int16_t>(y / options.shrink);
    for (int x = 0; x < std::min(part.width, width); ++x) {
      const std::size_t at = image::IndexAt(part.x + x, part.y + y, left.width);
      const std::int16_t value = row[x / options.shrink];
      if (left_mask.grey[at] == 0 || value <= none) continue;
      result.grey[at] = static_cast<float>(value) * pixels;
    }
  }
  return result;
}

}  // namespace rangegrasp::stereo
