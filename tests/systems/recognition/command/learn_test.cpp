// What `learn` makes of views of a thing, and what it says of too few of them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/command.h"
#include "geometry/bounds.h"
#include "geometry/cloud_file.h"
#include "geometry/mesh_file.h"
#include "geometry/synthetic.h"
#include "temp_folder.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing_support::RunProgram;

class LearnTest : public testing::Test {
 protected:
  /// A cylinder on a table, seen from 0.8 m aside and 0.62 m above, from that direction.
  std::string View(double direction_rad) const {
    synthetic::ScanOptions options;
    options.sensor_W = {0.8 * std::cos(direction_rad), 0.8 * std::sin(direction_rad), 0.62};
    options.seed = static_cast<std::uint64_t>(1000.0 * direction_rad);
    const auto scan =
        synthetic::MakeScan({synthetic::Cylinder{{0.01, 0.02, 0.06}, 0.035, 0.12}}, options);
    geometry::RangeImage image{.profiles = 1,
                               .samples = static_cast<int>(scan.points_W.size()),
                               .points_C = scan.points_W,
                               .origins_C = {options.sensor_W}};
    const auto file = folder_ / ("view" + std::to_string(options.seed) + ".pcd");
    geometry::WriteCloud(file, image);
    return file.string();
  }
  std::string Mesh() const { return (folder_ / "cylinder.stl").string(); }

  const testing_support::TempFolder folder_;
};

TEST_F(LearnTest, ACylinderFromThreeSidesIsIt) {
  const auto ran = RunProgram({"learn", View(0.0), View(2.1), View(4.2), "-o", Mesh()});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.err, Not(HasSubstr("guessed")));
  const auto mesh = geometry::ReadMesh(Mesh());
  const Eigen::Vector3d size = geometry::BoundsOf(mesh.vertices).sizes();
  EXPECT_NEAR(size.x(), 0.07, 0.003);
  EXPECT_NEAR(size.y(), 0.07, 0.003);
  EXPECT_NEAR(size.z(), 0.12, 0.003);
}

TEST_F(LearnTest, OneSideIsSaidToBeTooLittle) {
  const auto ran = RunProgram({"learn", View(0.0), "-o", Mesh()});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("what was not seen is guessed"));
}

TEST_F(LearnTest, AnEmptyTableIsRefused) {
  const auto view = View(0.0);
  const auto ran = RunProgram(
      {"learn", view, "-o", Mesh(), "--crop", "-0.14", "-0.14", "-0.1", "-0.05", "0.14", "0.3"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr(view + ": 0 points of a thing on the table"));
  EXPECT_FALSE(std::filesystem::exists(Mesh()));
}

}  // namespace
}  // namespace rangegrasp
