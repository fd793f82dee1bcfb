#include "geometry/mesh_colors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace rangegrasp::geometry {

std::size_t Print::IndexAt(const Eigen::Vector2f& uv) const {
  const auto texel = [](float place, int size) {
    const float wrapped = place - std::floor(place);
    return static_cast<std::size_t>(
        std::min(static_cast<int>(wrapped * static_cast<float>(size)), size - 1));
  };
  return texel(uv.y(), height) * static_cast<std::size_t>(width) + texel(uv.x(), width);
}

std::optional<std::size_t> MeshColors::TexelAt(const Hit& hit) const {
  if (!print) return std::nullopt;
  const auto& [a, b, c] = uv[hit.triangle];
  const Eigen::Vector2f at = (1.0f - hit.second - hit.third) * a + hit.second * b + hit.third * c;
  return at.allFinite() ? std::optional(print->IndexAt(at)) : std::nullopt;
}

std::optional<Rgb> MeshColors::PrintAt(const Hit& hit) const {
  const auto texel = TexelAt(hit);
  return texel ? std::optional(print->texels[*texel]) : std::nullopt;
}

std::optional<Rgb> MeshColors::At(const Hit& hit) const {
  if (const auto printed = PrintAt(hit)) return printed;
  return plain.empty() ? std::nullopt : std::optional(plain[hit.triangle]);
}

}  // namespace rangegrasp::geometry
