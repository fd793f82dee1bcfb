#include "recognition/internal/tone.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace rangegrasp::recognition::internal {
namespace {

/// Added to the light of each channel: some levels of a camera's noise, so that black is grey.
constexpr double kBlack = 0.002;
/// Of the brightness so much counts: half the light makes 0.1, as much as cream from white; black
/// differs from white by 0.4, more than red from orange.
constexpr double kBrightness = 0.15;

std::vector<Eigen::Vector3f> TonesOf(const std::vector<geometry::Rgb>& colors) {
  std::vector<Eigen::Vector3f> tones;
  tones.reserve(colors.size());
  std::ranges::transform(colors, std::back_inserter(tones), ToneOf);
  return tones;
}

}  // namespace

Eigen::Vector3f ToneOf(const geometry::Rgb& color) {
  const Eigen::Vector3d light = geometry::LightOf(color).array() + kBlack;
  const double sum = light.sum();
  return Eigen::Vector3d(light.x() / sum, light.z() / sum, kBrightness * std::log(sum))
      .cast<float>();
}

MeshTones::MeshTones(const geometry::MeshColors& colors)
    : colors_(&colors), plain_(TonesOf(colors.plain)) {
  if (colors.print) print_ = TonesOf(colors.print->texels);
}

Eigen::Vector3f MeshTones::At(const geometry::Hit& hit) const {
  if (const auto texel = colors_->TexelAt(hit)) return print_[*texel];
  if (plain_.empty()) {
    return Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  }
  return plain_[hit.triangle];
}

}  // namespace rangegrasp::recognition::internal
