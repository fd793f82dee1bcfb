#pragma once

#include <numbers>

namespace rangegrasp::base {

constexpr double kPi = std::numbers::pi;

/// Radians from degrees.
constexpr double Deg(double degrees) { return degrees * kPi / 180.0; }
/// Degrees from radians.
constexpr double ToDeg(double radians) { return radians * 180.0 / kPi; }
/// One millimetre [m], one degree [rad]: the units of hand-written files.
constexpr double kMm = 1e-3;
constexpr double kDeg = kPi / 180.0;
/// Conversion factor from metres to millimetres.
constexpr double kMmPerM = 1e3;
/// Standard gravity [m/s^2].
constexpr double kGravity = 9.81;

}  // namespace rangegrasp::base
