#include "stereo/reconstruct.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "geometry/range_image.h"
#include "stereo/internal/open_cv.h"

namespace rangegrasp::stereo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint8_t kKept = 255;

void CheckOptions(const ReconstructOptions& o) {
  if (o.step_px < 1) throw std::invalid_argument(fmt::format("step_px {}: at least 1", o.step_px));
  if (!(o.near_m > 0.0 && o.far_m > o.near_m)) {
    throw std::invalid_argument(
        fmt::format("depths from {} to {} m: ascending from above 0", o.near_m, o.far_m));
  }
  if (o.blue_window_px < 1 || o.blue_window_px % 2 == 0) {
    throw std::invalid_argument(fmt::format("blue_window_px {}: odd", o.blue_window_px));
  }
}

image::Grey8 Brightness(const image::Image& picture, const Mask& kept) {
  image::Grey8 grey{picture.width, picture.height, std::vector<std::uint8_t>(kept.grey.size())};
  cv::Mat room(picture.height, picture.width, CV_8UC1, grey.grey.data());
  cv::cvtColor(internal::View(picture), room, cv::COLOR_RGB2GRAY);
  for (std::size_t i = 0; i < grey.grey.size(); ++i) {
    if (kept.grey[i] == 0) grey.grey[i] = 0;
  }
  return grey;
}

// Black pixels tell nothing: the camera saw nothing there, or not enough.
bool SawSomething(const image::Image& picture, std::size_t at) {
  const std::uint8_t* pixel = picture.rgb.data() + 3 * at;
  return pixel[0] != 0 || pixel[1] != 0 || pixel[2] != 0;
}

Mask KeptPixels(const image::Image& picture, const ReconstructOptions& options) {
  if (options.remove_blue) {
    return WithoutBlue(picture, options.blue_share, options.blue_window_px);
  }
  Mask mask{picture.width, picture.height, std::vector<std::uint8_t>(picture.rgb.size() / 3)};
  for (std::size_t i = 0; i < mask.grey.size(); ++i) {
    mask.grey[i] = SawSomething(picture, i) ? kKept : 0;
  }
  return mask;
}

// Mean of those values that are near their median; nullopt if there are too few. Reorders them.
std::optional<double> CommonValue(std::vector<float>& values, std::size_t min_count,
                                  double max_spread) {
  if (values.size() < min_count || values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  const double median = *middle;
  double sum = 0.0;
  std::size_t count = 0;
  for (const float value : values) {
    if (std::abs(value - median) > max_spread) continue;
    sum += value;
    ++count;
  }
  if (count < min_count) return std::nullopt;
  return sum / static_cast<double>(count);
}

class Sampler {
 public:
  Sampler(const Rectifier& rectifier, const ReconstructOptions& options, Reconstruction& into)
      : rectifier_(rectifier), cameras_(rectifier.cameras()), o_(options), r_(into) {}

  void Run() {
    auto& image = r_.view.image;
    image.profiles = cameras_.height / o_.step_px;
    image.samples = cameras_.width / o_.step_px;
    image.origins_C = {cameras_.X_WS.translation()};
    for (int row = 0; row < image.profiles; ++row) {
      for (int column = 0; column < image.samples; ++column) Add(column, row);
    }
    r_.view.X_CV = cameras_.X_WS;
    r_.view.spacing_m = geometry::MedianSpacing(image);
  }

 private:
  void Add(int column, int row) {
    const double x = column * o_.step_px + 0.5 * (o_.step_px - 1);
    const double y = row * o_.step_px + 0.5 * (o_.step_px - 1);
    Eigen::Vector3d p_W = Eigen::Vector3d::Constant(kNaN);
    double noise_m = kNaN;
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
    values_.clear();
    ForPixels(column, row, [&](std::size_t at) {
      if (!std::isnan(r_.disparity.grey[at])) values_.push_back(r_.disparity.grey[at]);
    });
    const auto value = CommonValue(values_, MinCount(), o_.max_spread_px);
    if (value &&
        (*value < cameras_.DisparityAt(o_.far_m) || *value > cameras_.DisparityAt(o_.near_m))) {
      return std::nullopt;
    }
    return value;
  }

  // Whether most of a sample's pixels were removed for their colour.
  bool IsTable(int column, int row) const {
    if (!o_.table_W || !o_.remove_blue) return false;
    std::size_t removed = 0;
    ForPixels(column, row, [&](std::size_t at) {
      removed += r_.kept.grey[at] == 0 && SawSomething(r_.rectified.left, at) ? 1 : 0;
    });
    return removed >= MinCount();
  }

  Eigen::Vector3d OnTable(double x, double y) const {
    const Eigen::Vector3d origin_W = cameras_.X_WS.translation();
    const Eigen::Vector3d ray_W =
        cameras_.X_WS.rotation() *
        Eigen::Vector3d((x - cameras_.cx) / cameras_.f, (y - cameras_.cy) / cameras_.f, 1.0);
    const double along = -o_.table_W->Distance(origin_W) / o_.table_W->normal.dot(ray_W);
    if (!(along > 0.0)) return Eigen::Vector3d::Constant(kNaN);
    return origin_W + along * ray_W;
  }

  void ForPixels(int column, int row, const auto& action) const {
    for (int y = row * o_.step_px; y < (row + 1) * o_.step_px; ++y) {
      for (int x = column * o_.step_px; x < (column + 1) * o_.step_px; ++x) {
        action(static_cast<std::size_t>(y) * static_cast<std::size_t>(cameras_.width) +
               static_cast<std::size_t>(x));
      }
    }
  }

  std::size_t MinCount() const {
    return static_cast<std::size_t>(
        std::max(1.0, std::ceil(o_.min_share * o_.step_px * o_.step_px)));
  }

  const Rectifier& rectifier_;
  const RectifiedCameras& cameras_;
  const ReconstructOptions& o_;
  Reconstruction& r_;
  std::vector<float> values_;
};

}  // namespace

Mask WithoutBlue(const image::Image& picture, double blue_share, int window_px) {
  Mask mask{picture.width, picture.height, {}};
  mask.grey.resize(picture.rgb.size() / 3);
  for (std::size_t i = 0; i < mask.grey.size(); ++i) {
    const int red = picture.rgb[3 * i], green = picture.rgb[3 * i + 1],
              blue = picture.rgb[3 * i + 2];
    const bool dominant = std::max(red, green) < (1.0 - blue_share) * blue;
    mask.grey[i] = dominant || !SawSomething(picture, i) ? 0 : kKept;
  }
  if (window_px > 1) {
    cv::Mat room(mask.height, mask.width, CV_8UC1, mask.grey.data());
    cv::medianBlur(room, room, window_px);
  }
  return mask;
}

Reconstruction Reconstruct(const image::Image& left, const image::Image& right,
                           const Rectifier& rectifier, const ReconstructOptions& options) {
  CheckOptions(options);
  const internal::SingleThread single;
  Reconstruction result;
  result.rectified = rectifier.Apply(left, right);
  result.kept = KeptPixels(result.rectified.left, options);
  const RectifiedCameras& cameras = rectifier.cameras();
  result.disparity = Match(
      Brightness(result.rectified.left, result.kept),
      Brightness(result.rectified.right, KeptPixels(result.rectified.right, options)), result.kept,
      cameras.DisparityAt(options.far_m), cameras.DisparityAt(options.near_m), options.match);
  Sampler(rectifier, options, result).Run();
  return result;
}

}  // namespace rangegrasp::stereo
