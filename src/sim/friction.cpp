#include "sim/friction.h"

#include <cmath>

namespace rangegrasp::sim {

namespace {

// In the proportion of the table's two numbers.
FrictionPair PairOf(const GloveRange& range, double static_mu) {
  return {static_mu, static_mu * range.kinetic / range.middle};
}

}  // namespace

FrictionPair DrawnFriction(const GloveRange& range, double u) {
  const double width = range.high - range.low;
  const double at_mode = (range.middle - range.low) / width;
  const double mu = u < at_mode
                        ? range.low + std::sqrt(u * width * (range.middle - range.low))
                        : range.high - std::sqrt((1.0 - u) * width * (range.high - range.middle));
  return PairOf(range, mu);
}

FrictionPair GloveFriction(const GloveRange& range, const PhysicsOptions& options, double u) {
  if (options.glove_friction) return {*options.glove_friction, *options.glove_friction};
  switch (options.friction) {
    case FrictionChoice::kDrawn:
      return DrawnFriction(range, u);
    case FrictionChoice::kLow:
      return PairOf(range, range.low);
    case FrictionChoice::kHigh:
      return PairOf(range, range.high);
    case FrictionChoice::kKinetic:
      return {range.kinetic, range.kinetic};
    case FrictionChoice::kMiddle:
      break;
  }
  return PairOf(range, range.middle);
}

FrictionPair GloveFriction(const GloveRange& range, const PhysicsOptions& options) {
  PhysicsOptions middle = options;
  if (middle.friction == FrictionChoice::kDrawn) middle.friction = FrictionChoice::kMiddle;
  return GloveFriction(range, middle, 0.0);
}

}  // namespace rangegrasp::sim
