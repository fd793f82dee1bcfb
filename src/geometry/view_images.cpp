#include "geometry/view_images.h"

#include <cmath>

namespace rangegrasp::geometry {
namespace {

// A camera's points are on the rays of its pixels, except for rounding.
constexpr double kOnRay_px = 0.01;
constexpr std::size_t kMinPoints = 100;

/// Least-squares fit of pixel = slope * ray + offset; nullopt if a pair deviates from it.
struct Line {
  double slope, offset;
};
std::optional<Line> LineThrough(const std::vector<double>& ray, const std::vector<double>& pixel) {
  const auto n = static_cast<Eigen::Index>(ray.size());
  const Eigen::Map<const Eigen::ArrayXd> x(ray.data(), n), y(pixel.data(), n);
  const Eigen::ArrayXd about_mean = x - x.mean();
  const double spread = about_mean.square().sum();
  if (!(spread > 0.0)) return std::nullopt;
  const double slope = (about_mean * y).sum() / spread;
  const double offset = y.mean() - slope * x.mean();
  if ((slope * x + offset - y).abs().maxCoeff() > kOnRay_px) return std::nullopt;
  return Line{slope, offset};
}

}  // namespace

std::optional<ViewImages> ImagesOf(const View& view) {
  const RangeImage& image = view.image;
  const base::Pose X_VC = view.X_CV.inverse();
  ViewImages images;
  images.depth = {image.samples, image.profiles,
                  std::vector<std::uint16_t>(image.points_C.size(), 0)};
  std::vector<double> right, down, column, row;
  for (std::size_t i = 0; i < image.points_C.size(); ++i) {
    if (!image.points_C[i].allFinite()) continue;
    const Eigen::Vector3d p_V = X_VC * image.points_C[i];
    if (!(p_V.z() > 0.0)) return std::nullopt;
    const double depth = std::round(p_V.z() / ViewImages::kDepthUnit_m);
    if (depth <= 65535.0) images.depth.grey[i] = static_cast<std::uint16_t>(depth);
    right.push_back(p_V.x() / p_V.z());
    down.push_back(p_V.y() / p_V.z());
    column.push_back(static_cast<double>(i % static_cast<std::size_t>(image.samples)));
    row.push_back(static_cast<double>(i / static_cast<std::size_t>(image.samples)));
  }
  if (right.size() < kMinPoints) return std::nullopt;
  const auto columns = LineThrough(right, column);
  const auto rows = LineThrough(down, row);
  if (!columns || !rows) return std::nullopt;
  images.fx = columns->slope;
  images.cx = columns->offset;
  images.fy = rows->slope;
  images.cy = rows->offset;
  if (!view.colors.empty()) {
    images.color = {image.samples, image.profiles, {}};
    for (const Rgb& rgb : view.colors) {
      images.color.rgb.insert(images.color.rgb.end(), rgb.begin(), rgb.end());
    }
  }
  return images;
}

std::optional<WrittenImages> WriteImages(const View& view, const std::filesystem::path& folder,
                                         const std::string& stem) {
  auto images = ImagesOf(view);
  if (!images) return std::nullopt;
  WrittenImages written{std::move(*images), stem + "_depth.png", ""};
  image::WritePng(folder / written.depth, written.images.depth);
  if (written.images.color.width > 0) {
    written.color = stem + "_color.png";
    image::WritePng(folder / written.color, written.images.color);
  }
  return written;
}

}  // namespace rangegrasp::geometry
