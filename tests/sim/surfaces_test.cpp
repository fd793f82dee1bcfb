#include "sim/surfaces.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "base/words.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::sim {
namespace {

constexpr auto kChoices = base::ValuesOf<FrictionChoice>();

PhysicsOptions Choosing(FrictionChoice choice) {
  return {.friction = choice, .glove_friction = {}};
}

const std::vector<Surface>& Shipped() {
  static const std::vector<Surface> surfaces = ReadSurfaces(ShippedSurfaces());
  return surfaces;
}

TEST(Friction, StaticIsNeverBelowKinetic) {
  for (const Surface& row : Shipped()) {
    EXPECT_GE(row.on_laminate.static_mu, row.on_laminate.kinetic_mu) << row.name;
    for (const FrictionChoice choice : kChoices) {
      const FrictionPair pair = GloveFriction(row.glove, Choosing(choice), 0.1);
      EXPECT_GE(pair.static_mu, pair.kinetic_mu) << row.name << base::Word(choice);
    }
  }
}

// Each choice is a separate run: no two choices have the same pair on any surface.
TEST(Friction, EveryChoiceIsAnother) {
  for (const Surface& row : Shipped()) {
    std::set<std::pair<double, double>> pairs;
    for (const FrictionChoice choice : kChoices) {
      const FrictionPair pair = GloveFriction(row.glove, Choosing(choice), 0.1);
      pairs.emplace(pair.static_mu, pair.kinetic_mu);
    }
    EXPECT_EQ(pairs.size(), std::size(kChoices)) << row.name;
  }
}

TEST(Friction, OptionsChangeThePair) {
  const auto glove = [](FrictionChoice choice) {
    return GloveFriction(FindSurface(Shipped(), "ceramic").glove, Choosing(choice), 0.5);
  };
  EXPECT_EQ(glove(FrictionChoice::kMiddle).static_mu, 0.70);
  EXPECT_EQ(glove(FrictionChoice::kMiddle).kinetic_mu, 0.55);
  EXPECT_EQ(glove(FrictionChoice::kLow).static_mu, 0.50);
  EXPECT_DOUBLE_EQ(glove(FrictionChoice::kLow).kinetic_mu, 0.50 * 0.55 / 0.70);
  EXPECT_EQ(glove(FrictionChoice::kHigh).static_mu, 1.00);
  EXPECT_EQ(glove(FrictionChoice::kKinetic).static_mu, 0.55);
  EXPECT_EQ(glove(FrictionChoice::kKinetic).kinetic_mu, 0.55);
  PhysicsOptions options;
  options.glove_friction = 0.02;
  EXPECT_EQ(GloveFriction(FindSurface(Shipped(), "ceramic").glove, options).static_mu, 0.02);
  EXPECT_EQ(GloveFriction(FindSurface(Shipped(), "ceramic").glove, options).kinetic_mu, 0.02);
}

// A triangular distribution over [0.45, 0.8] with its mode at 0.6: its mean is the mean of the
// three values, 3/7 of it lie below the mode, and its ends are reached.
TEST(Friction, DrawnOnesAreTriangularOverTheRange) {
  const GloveRange range = FindSurface(Shipped(), "cardboard").glove;
  constexpr int kDraws = 10000;
  double sum = 0.0;
  int below = 0;
  for (int i = 0; i < kDraws; ++i) {
    const FrictionPair pair = GloveFriction(range, {}, (i + 0.5) / kDraws);
    EXPECT_NEAR(pair.kinetic_mu / pair.static_mu, 0.50 / 0.60, 1e-12);
    sum += pair.static_mu;
    below += pair.static_mu < 0.60 ? 1 : 0;
  }
  EXPECT_NEAR(sum / kDraws, (0.45 + 0.60 + 0.80) / 3.0, 1e-4);
  EXPECT_NEAR(static_cast<double>(below) / kDraws, 3.0 / 7.0, 1e-3);
  EXPECT_DOUBLE_EQ(GloveFriction(range, {}, 0.0).static_mu, 0.45);
  EXPECT_NEAR(GloveFriction(range, {}, 1.0 - 1e-15).static_mu, 0.80, 1e-7);
}

TEST(Friction, AnUnknownSurfaceIsNamedWithTheKnownOnes) {
  const std::string error = testing_support::ErrorOf([] { FindSurface(Shipped(), "velvet"); });
  EXPECT_NE(error.find("velvet"), std::string::npos);
  EXPECT_NE(error.find("cardboard"), std::string::npos);
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
  state.Update(-1.0);  // losing contact is not sticking
  EXPECT_EQ(state.Coefficient(pair), 0.5);
  state.Update(0.0004);
  EXPECT_EQ(state.Coefficient(pair), 0.6);
}

TEST(Surfaces, AreFoundBesideTheObjectFirst) {
  const testing_support::TempFolder folder;
  const std::string pair =
      "  glove: {static: 0.9, from: 0.7, to: 1.2, kinetic: 0.8}\n"
      "  laminate: {static: 0.8, kinetic: 0.7}\n";
  const auto object = folder.Write("objects/duck/duck.xml", "<mujoco/>");
  EXPECT_EQ(SurfaceFiles(object).size(), 1U);
  EXPECT_EQ(FindSurface(SurfacesFor(object), "ceramic").glove.middle, 0.70);
  folder.Write("objects/surfaces.yaml", "rubber:\n" + pair + "ceramic:\n" + pair);
  EXPECT_EQ(FindSurface(SurfacesFor(object), "rubber").glove.high, 1.2);
  EXPECT_EQ(FindSurface(SurfacesFor(object), "ceramic").glove.middle, 0.9);
  EXPECT_EQ(FindSurface(SurfacesFor(object), "cardboard").glove.middle, 0.60);
}

TEST(Surfaces, AFileThatCannotBeReadIsNamedInsteadOfIgnored) {
  const testing_support::TempFolder folder;
  const auto object = folder.Write("duck/duck.xml", "<mujoco/>");
  const auto file = folder / "duck/surfaces.yaml";
  const auto error = [&] { return testing_support::ErrorOf([&] { SurfacesFor(object); }); };
  std::filesystem::create_symlink("missing.yaml", file);
  EXPECT_NE(error().find(file.string() + ": no such file"), std::string::npos) << error();
  std::filesystem::remove(file);
  std::filesystem::create_directory(file);
  EXPECT_NE(error().find(file.string() + ": is a folder"), std::string::npos) << error();
}

}  // namespace
}  // namespace rangegrasp::sim
