#include "perception/find_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/units.h"
#include "geometry/kd_tree.h"
#include "geometry/random_points.h"
#include "geometry/synthetic.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;
using geometry::KdTree;
using geometry::Points;

const Eigen::Vector3d kSensor(0.8, 0.0, 0.62);

/// The scene's table is z = 0 with noise of 0.3 mm along the line of sight (0.18 mm across).
void ExpectTable(const std::optional<Table>& table, const Eigen::Vector3d& up) {
  ASSERT_TRUE(table);
  // The slope's standard error over 2,000 points that spread 0.08 m is 5e-5; trimming at 2 mm and
  // the feet of the objects add some.
  EXPECT_GT(table->plane.normal.dot(up), std::cos(0.004));
  EXPECT_NEAR(table->plane.offset_m, 0.0, 0.0005);
}

class SeededTable : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededTable, ::testing::Range<std::uint64_t>(0, 20));

TEST_P(SeededTable, IsFoundUnderManyObjects) {
  const auto scan = synthetic::MixedScan(GetParam());
  base::Rng rng(GetParam());
  const auto table = FindTable(scan.points_W, kSensor, {}, rng);
  ExpectTable(table, Eigen::Vector3d::UnitZ());
  std::size_t missed = 0;
  for (std::uint32_t i = 0; i < scan.label.size(); ++i) {
    const bool taken = std::binary_search(table->points.begin(), table->points.end(), i);
    missed += scan.label[i] == -1 && !taken ? 1 : 0;
    EXPECT_FALSE(taken && scan.label[i] >= 0 && scan.points_W[i].z() > 0.006);
  }
  EXPECT_EQ(missed, 0u);
}

TEST_P(SeededTable, IsFoundWithStrayPointsUnderIt) {
  auto scan = synthetic::MixedScan(GetParam());
  base::Rng rng(1000 + GetParam());
  const std::size_t strays = 1 + rng.Index(12);
  for (std::size_t i = 0; i < strays; ++i) {
    const double x = rng.Uniform(-0.15, 0.15);
    const double y = rng.Uniform(-0.15, 0.15);
    scan.points_W.emplace_back(x, y, rng.Uniform(-0.12, -0.003));
  }
  const auto table = FindTable(scan.points_W, kSensor, {}, rng);
  ExpectTable(table, Eigen::Vector3d::UnitZ());
  for (std::size_t i = scan.label.size(); i < scan.points_W.size(); ++i) {
    EXPECT_TRUE(std::binary_search(table->points.begin(), table->points.end(), i));  // below it
  }
}

TEST_P(SeededTable, IsFoundInAnyFrame) {
  base::Rng rng(GetParam());
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(rng.Uniform(0.0, 6.0), geometry::samples::RandomDirection(rng))
          .toRotationMatrix();
  auto scan = synthetic::MixedScan(GetParam());
  for (Eigen::Vector3d& p : scan.points_W) p = R * p;
  ExpectTable(FindTable(scan.points_W, R * kSensor, {}, rng), R * Eigen::Vector3d::UnitZ());
}

/// A narrow table round a large box, whose top holds more points than the table.
synthetic::Scan CoveredTable(std::uint64_t seed) {
  synthetic::ScanOptions options;
  options.seed = seed;
  options.step_m = 0.004;
  options.table_half = {0.12, 0.12};
  return synthetic::MakeScan({synthetic::Box{{0.0, 0.0, 0.05}, {0.17, 0.17, 0.10}, 0.0}}, options);
}

TEST_P(SeededTable, ThatIsMostlyCoveredIsFoundAndTheBoxTopIsNot) {
  const auto scan = CoveredTable(GetParam());
  const auto on_table = std::count(scan.label.begin(), scan.label.end(), -1);
  const auto on_top = std::count_if(scan.points_W.begin(), scan.points_W.end(),
                                    [](const auto& p) { return p.z() > 0.098; });
  ASSERT_GT(on_top, on_table);
  base::Rng rng(GetParam());
  ExpectTable(FindTable(scan.points_W, kSensor, {}, rng), Eigen::Vector3d::UnitZ());
}

TEST_P(SeededTable, ThatIsMostlyCoveredIsFoundWithDeepStrayPointsUnderIt) {
  // Strays all round and deep below: no face of the first hull is near the table.
  auto scan = CoveredTable(GetParam());
  base::Rng rng(GetParam());
  for (int i = 0; i < 9; ++i) {
    const double x = 0.13 * (i % 3 - 1) + rng.Uniform(-0.02, 0.02);
    const double y = 0.13 * (i / 3 - 1) + rng.Uniform(-0.02, 0.02);
    scan.points_W.emplace_back(x, y, rng.Uniform(-0.12, -0.06));
  }
  ExpectTable(FindTable(scan.points_W, kSensor, {}, rng), Eigen::Vector3d::UnitZ());
}

TEST(Table, IsFoundByTheDominantPlaneBeforeABackground) {
  auto scan = synthetic::MixedScan(1);
  base::Rng rng(1);
  const std::size_t n = scan.points_W.size() / 2;
  for (std::size_t i = 0; i < n; ++i) {  // a rough wall behind, and below the table's height
    const double y = rng.Uniform(-0.5, 0.5);
    const double z = rng.Uniform(-0.8, 0.3);
    scan.points_W.emplace_back(-1.0 + 0.05 * rng.Normal(), y, z);
  }
  PreprocessOptions options;
  ExpectTable(FindTable(scan.points_W, kSensor, options, rng), Eigen::Vector3d::UnitZ());
  options.up_C = Eigen::Vector3d(0.1, 0.0, 1.0);
  ExpectTable(FindTable(scan.points_W, kSensor, options, rng), Eigen::Vector3d::UnitZ());
}

TEST(Table, IsNotFoundWhereThereIsNone) {
  base::Rng rng(1);
  EXPECT_FALSE(FindTable(Points{}, kSensor, {}, rng));
  EXPECT_FALSE(FindTable(Points(10, {0.0, 0.0, 0.0}), kSensor, {}, rng));
  EXPECT_FALSE(FindTable(geometry::samples::RandomPoints(2000, 0.2, rng), kSensor, {}, rng));
  PreprocessOptions sideways;
  sideways.up_C = Eigen::Vector3d(0.0, 1.0, 0.0);
  EXPECT_FALSE(FindTable(synthetic::MixedScan(1).points_W, kSensor, sideways, rng));
}

TEST(Table, ThatIsEmptyAndFlatIsAllTable) {
  Points points;
  for (int x = 0; x < 30; ++x) {
    for (int y = 0; y < 30; ++y) points.emplace_back(0.004 * x, 0.004 * y, 0.0);
  }
  base::Rng rng(1);
  const auto table = FindTable(points, kSensor, {}, rng);
  ASSERT_TRUE(table);
  EXPECT_NEAR(table->plane.normal.z(), 1.0, 1e-9);
  EXPECT_EQ(table->points.size(), 900u);
}

TEST(Table, ThatIsFlatIsNoneWhereUpIsElsewhere) {
  Points points;
  for (int x = 0; x < 30; ++x) {
    for (int y = 0; y < 30; ++y) points.emplace_back(0.004 * x, 0.004 * y, 0.0);
  }
  base::Rng rng(1);
  PreprocessOptions options;
  options.up_C = Eigen::Vector3d(0.0, 1.0, 0.0);
  EXPECT_FALSE(FindTable(points, kSensor, options, rng));
  options.up_C = Eigen::Vector3d(0.1, 0.0, 1.0);
  EXPECT_TRUE(FindTable(points, kSensor, options, rng));
}

// A wall holds more points than the table; beneath both lies rubble, so that the hull shows
// neither.
TEST(Table, IsFoundAfterAWallThatIsNotUp) {
  base::Rng rng(2);
  Points points;
  for (int x = 0; x < 50; ++x) {
    for (int y = 0; y < 50; ++y) points.emplace_back(0.004 * x - 0.1, 0.004 * y - 0.1, 0.0);
  }
  for (int y = 0; y < 80; ++y) {
    for (int z = 0; z < 50; ++z) points.emplace_back(-0.3, 0.005 * y - 0.2, 0.005 * z - 0.1);
  }
  for (int i = 0; i < 500; ++i) {
    const double x = rng.Uniform(-0.5, 0.3);
    const double y = rng.Uniform(-0.3, 0.3);
    points.emplace_back(x, y, rng.Uniform(-0.5, -0.05));
  }
  PreprocessOptions options;
  options.up_C = Eigen::Vector3d::UnitZ();
  ExpectTable(FindTable(points, kSensor, options, rng), Eigen::Vector3d::UnitZ());
  options.table.dominant_planes = 1;
  EXPECT_FALSE(FindTable(points, kSensor, options, rng));
}

TEST(Table, RefusesBadOptions) {
  base::Rng rng(1);
  PreprocessOptions no_preselection, below, no_up;
  no_preselection.preselection_m = 0.0;
  below.table_clearance_m = -0.001;
  no_up.up_C = Eigen::Vector3d::Zero();
  for (const PreprocessOptions& options : {no_preselection, below, no_up}) {
    EXPECT_THROW(FindTable(Points{}, kSensor, options, rng), std::invalid_argument);
  }
}

}  // namespace
}  // namespace rangegrasp::perception
