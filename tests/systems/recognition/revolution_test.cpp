#include "recognition/internal/revolution.h"

#include <gtest/gtest.h>

#include "base/units.h"
#include "perception/raster_scan.h"
#include "recognition/internal/sampled_surface.h"

namespace rangegrasp::recognition::internal {
namespace {

class SeededAxis : public testing::TestWithParam<int> {
 protected:
  base::Pose Drawn() const {
    base::Rng rng(static_cast<std::uint64_t>(GetParam()));
    const Eigen::Quaterniond turn(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal());
    return base::MakePose(turn.normalized().toRotationMatrix(), {rng.Normal(), 0.1, rng.Normal()});
  }
};

// A mug's is that of its body, whatever its handle weighs: 96 sides turn 0.1 mm off a circle.
TEST_P(SeededAxis, OfAMugIsThatOfItsBody) {
  const base::Pose X = Drawn();
  const auto mesh = geometry::Transformed(synthetic::MugMesh(), X);
  const auto axis = AxisOfRevolution(SampledSurface(mesh, 0.003));
  ASSERT_TRUE(axis);
  const Eigen::Vector3d expected = X.linear().col(2);
  EXPECT_GT(std::abs(axis->direction_B.dot(expected)), std::cos(base::Deg(0.3)));
  const Eigen::Vector3d beside = axis->point_B - X * Eigen::Vector3d(0.0, 0.0, 0.047);
  EXPECT_LT((beside - beside.dot(expected) * expected).norm(), 3e-4);
}

TEST_P(SeededAxis, IsNoneOfBoxesAndPrisms) {
  for (const auto& mesh : {synthetic::BoxMesh(0.09, 0.06, 0.135),
                           synthetic::Extrude(synthetic::Regular(3, 0.035), 0.16)}) {
    EXPECT_FALSE(AxisOfRevolution(SampledSurface(geometry::Transformed(mesh, Drawn()), 0.003)));
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, SeededAxis, testing::Range(1, 11));

}  // namespace
}  // namespace rangegrasp::recognition::internal
