#include "sim/friction.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace rangegrasp::sim {
namespace {

TEST(Friction, StaticIsNeverBelowKinetic) {
  for (const SurfaceFriction& row : FrictionTable()) {
    EXPECT_GE(row.glove.static_mu, row.glove.kinetic_mu) << row.surface;
    EXPECT_GE(row.on_laminate.static_mu, row.on_laminate.kinetic_mu) << row.surface;
    for (const double offset : {-0.15, 0.0, 0.15}) {
      PhysicsOptions options;
      options.static_friction_offset = offset;
      const FrictionPair pair = GloveFriction(row.surface, options);
      EXPECT_GE(pair.static_mu, pair.kinetic_mu) << row.surface << offset;
    }
  }
}

TEST(Friction, OptionsChangeThePair) {
  PhysicsOptions options;
  EXPECT_EQ(GloveFriction("ceramic", options).static_mu, 0.70);
  options.kinetic_only = true;
  EXPECT_EQ(GloveFriction("ceramic", options).static_mu, 0.55);
  options.glove_friction = 0.02;
  EXPECT_EQ(GloveFriction("ceramic", options).static_mu, 0.02);
  EXPECT_EQ(GloveFriction("ceramic", options).kinetic_mu, 0.02);
}

TEST(Friction, AnUnknownSurfaceIsNamedWithTheKnownOnes) {
  try {
    FrictionOf("velvet");
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("velvet"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("cardboard"), std::string::npos);
  }
}

TEST(SlipState, SlidesAboveOneMillimetreASecondUntilItSticks) {
  SlipState state;
  const FrictionPair pair{0.6, 0.5};
  state.Update(0.0009);
  EXPECT_EQ(state.Coefficient(pair), 0.6);
  state.Update(0.0011);
  EXPECT_EQ(state.Coefficient(pair), 0.5);
  state.Update(0.0007);  // still sliding: hysteresis
  EXPECT_EQ(state.Coefficient(pair), 0.5);
  state.Update(-1.0);  // out of touch is not stuck
  EXPECT_EQ(state.Coefficient(pair), 0.5);
  state.Update(0.0004);
  EXPECT_EQ(state.Coefficient(pair), 0.6);
}

}  // namespace
}  // namespace rangegrasp::sim
