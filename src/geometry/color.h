#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace rangegrasp::geometry {

/// Red, green and blue as pictures hold them (sRGB, 8 bits each).
using Rgb = std::array<std::uint8_t, 3>;

/// The light that such a color stands for, each channel 0..1 (IEC 61966-2-1).
Eigen::Vector3d LightOf(const Rgb& color);
/// The nearest color of a light; what is brighter than 1 is clipped.
Rgb ColorOf(const Eigen::Vector3d& light);

}  // namespace rangegrasp::geometry
