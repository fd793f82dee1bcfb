#include "geometry/synthetic.h"

#include <gtest/gtest.h>

namespace rangegrasp::synthetic {
namespace {

TEST(Synthetic, AScanHoldsTheTableAndTheSeenSidesOfTheSolids) {
  ScanOptions options;
  options.sigma_m = 0.0;
  const Box box{{0.0, 0.0, 0.05}, {0.06, 0.06, 0.10}, 0.0};
  const Scan scan = MakeScan({box}, options);
  int shadowed = 0;
  for (std::size_t i = 0; i < scan.points_W.size(); ++i) {
    const Eigen::Vector3d& p = scan.points_W[i];
    if (scan.label[i] == -1) {
      EXPECT_EQ(p.z(), 0.0);
      EXPECT_FALSE(std::abs(p.x()) < 0.029 && std::abs(p.y()) < 0.029);  // under the box
      // The shadow of a 0.1 m box seen from (0.8, 0, 0.62) extends to x = -0.03 - 0.83 / 5.2.
      shadowed += p.x() < -0.035 && std::abs(p.y()) < 0.025 ? 1 : 0;
    } else {
      // Only the top and the side towards the sensor are seen; the others are edge-on or face away.
      EXPECT_TRUE(std::abs(p.z() - 0.10) < 1e-9 || std::abs(p.x() - 0.03) < 1e-9);
    }
  }
  EXPECT_EQ(shadowed, 0);
}

TEST(Synthetic, TheSameSeedGivesTheSameScanAndTheOutliersAreThere) {
  ScanOptions options;
  options.outliers = 25;
  const Scan a = MakeScan(MixedObjects(), options);
  const Scan b = MakeScan(MixedObjects(), options);
  EXPECT_EQ(a.points_W, b.points_W);
  EXPECT_EQ(std::count(a.label.begin(), a.label.end(), -2), 25);
  for (int i = 0; i < 5; ++i) EXPECT_GT(std::count(a.label.begin(), a.label.end(), i), 100);
}

}  // namespace
}  // namespace rangegrasp::synthetic
