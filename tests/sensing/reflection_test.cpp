#include "sensing/internal/reflection.h"

#include <gtest/gtest.h>

#include <array>

#include "base/units.h"

namespace rangegrasp::sensing::internal {
namespace {

using base::Deg;

TEST(IncidenceLoss, RisesFromSixtyToEightyDegrees) {
  const LineScannerOptions options;
  EXPECT_EQ(IncidenceLoss(options, 0.0), 0.0);
  EXPECT_EQ(IncidenceLoss(options, Deg(60.0)), 0.0);
  EXPECT_NEAR(IncidenceLoss(options, Deg(65.0)), 0.25, 1e-12);
  EXPECT_NEAR(IncidenceLoss(options, Deg(70.0)), 0.5, 1e-12);
  EXPECT_NEAR(IncidenceLoss(options, Deg(80.0)), 1.0, 1e-12);
  EXPECT_EQ(IncidenceLoss(options, Deg(90.0)), 1.0);
}

TEST(AlbedoLoss, DarkSurfacesLoseHalfToNineTenths) {
  EXPECT_EQ(AlbedoLoss(0.7), 0.0);
  EXPECT_EQ(AlbedoLoss(0.10), 0.0);
  EXPECT_NEAR(AlbedoLoss(0.05), 0.5, 1e-12);
  EXPECT_NEAR(AlbedoLoss(0.0), 0.9, 1e-12);
  EXPECT_NEAR(AlbedoLoss(0.075), 0.25, 1e-12);  // linear between
  EXPECT_NEAR(AlbedoLoss(0.025), 0.7, 1e-12);
  for (double a = 0.0; a < 0.2; a += 0.001) EXPECT_GE(AlbedoLoss(a), AlbedoLoss(a + 0.001));
}

TEST(GlossLoss, OnlyNearTheMirrorDirection) {
  const LineScannerOptions options;
  EXPECT_EQ(GlossLoss(options, 0.6, Deg(4.9)), 0.6);
  EXPECT_EQ(GlossLoss(options, 0.6, Deg(5.1)), 0.0);
}

TEST(SampleLoss, DarknessAndClarityAreIndependent) {
  EXPECT_NEAR(SampleLoss(0.05, 0.2), 1.0 - 0.5 * 0.8, 1e-12);
  EXPECT_EQ(SampleLoss(0.7, 0.0), 0.0);
}

TEST(PatchLoss, IncidenceAndGlossAreIndependent) {
  const LineScannerOptions options;
  EXPECT_NEAR(PatchLoss(options, 0.4, {Deg(70.0), Deg(1.0)}), 1.0 - 0.5 * 0.6, 1e-12);
  EXPECT_EQ(PatchLoss(options, 0.4, {}), 0.0);
}

// sRGB: half of the light is 188 of 255.
TEST(PrintAlbedo, IsLinearInTheLightOfTheRedChannel) {
  EXPECT_NEAR(PrintAlbedo(0), 0.04, 1e-12);
  EXPECT_NEAR(PrintAlbedo(255), 0.85, 1e-12);
  EXPECT_NEAR(PrintAlbedo(188), 0.04 + 0.81 * 0.503, 1e-3);
  for (int red = 0; red < 255; ++red) {
    EXPECT_LT(PrintAlbedo(static_cast<std::uint8_t>(red)),
              PrintAlbedo(static_cast<std::uint8_t>(red + 1)));
  }
}

TEST(BrightestBlob, IsTheCentroidOfWhatLiesWithinOneWidth) {
  std::array<Glint, 3> glints = {{{3.0, 2.0, 0}, {1.0, 1.0, 1}, {2.0, 1.0, 2}}};
  const Blob blob = BrightestBlob(glints, 1.0);
  EXPECT_NEAR(blob.column_px, 9.0 / 4.0, 1e-12);
  EXPECT_NEAR(blob.brightness, 4.0, 1e-12);
  EXPECT_EQ(blob.source, 0u);
}

TEST(BrightestBlob, OfTwoPeaksTheBrighterWins) {
  std::array<Glint, 4> glints = {{{0.0, 1.0, 0}, {0.5, 1.0, 1}, {9.0, 1.5, 2}, {9.5, 1.0, 3}}};
  const Blob blob = BrightestBlob(glints, 2.0);
  EXPECT_NEAR(blob.column_px, (9.0 * 1.5 + 9.5) / 2.5, 1e-12);
  EXPECT_EQ(blob.source, 2u);
}

TEST(BrightestBlob, OfEqualPeaksTheFirstInTheImageWins) {
  std::array<Glint, 2> glints = {{{9.0, 1.0, 0}, {0.0, 1.0, 1}}};
  EXPECT_EQ(BrightestBlob(glints, 2.0).source, 1u);
}

TEST(BrightestBlob, WithoutLightThereIsNone) { EXPECT_EQ(BrightestBlob({}, 1.0).brightness, 0.0); }

}  // namespace
}  // namespace rangegrasp::sensing::internal
