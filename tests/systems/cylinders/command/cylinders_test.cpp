// Results and messages of `cylinders` for valid clouds and for clouds with errors.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cylinders/task/tabletop_scan.h"
#include "geometry/cloud_file.h"
#include "geometry/random_points.h"

namespace rangegrasp::testing_support {
namespace {

namespace scans = cylinders::samples;
using testing::HasSubstr;

class CylindersTest : public testing::Test {
 protected:
  /// A standing cylinder of 25.75 x 173 mm at (0, -0.07) and a lying one of 26.75 x 134 mm.
  geometry::RangeImage Image() const {
    base::Rng rng(1);
    const scans::Tabletop tabletop = {{scans::Standing(0.0, -0.07, 0.02575, 0.173),
                                       scans::Lying(0.02, 0.06, 1.2, 0.02675, 0.134)},
                                      {scans::StandingBox(-0.1, 0.0, 0.5, {0.05, 0.06, 0.1})}};
    return scans::Scan(tabletop, {}, rng).views.front().image;
  }
  std::string Write(const std::string& name, const geometry::RangeImage& image) const {
    const auto file = folder_ / name;
    geometry::WriteCloud(file, image);
    return file.string();
  }
  static Ran Cylinders(const std::string& cloud, std::vector<std::string> more) {
    more.insert(more.begin(), {"cylinders", cloud});
    return RunProgram(more);
  }
  void ExpectRefused(const std::string& cloud, const std::vector<std::string>& more,
                     const std::string& says) const {
    ExpectRefusal(Cylinders(cloud, more), says);
  }

  TempFolder folder_;
};

TEST_F(CylindersTest, TellsThePosesOfThoseGiven) {
  const std::string cloud = Write("cloud.pcd", Image());
  const std::string out = folder_ / "out";
  const Ran ran = Succeeded(Cylinders(cloud, {"--cylinder", "25.75,173", "--cylinder", "26.75,134",
                                              "--cylinder", "40,90", "--json", "-o", out}));
  const auto json = nlohmann::json::parse(ran.out);
  EXPECT_TRUE(json["scan_order"]);
  EXPECT_GT(json["edge_points"], 0);
  ASSERT_EQ(json["cylinders"].size(), 2u);
  const auto& standing = json["cylinders"][0];
  EXPECT_EQ(standing["given"], 1);
  EXPECT_FALSE(standing["lies"]);
  EXPECT_NEAR(standing["center_m"][1].get<double>(), -0.07, 0.002);
  EXPECT_NEAR(standing["top_m"][2].get<double>(), 0.173, 0.002);
  EXPECT_NEAR(standing["radius_m"].get<double>(), 0.02575, 0.0005);
  EXPECT_TRUE(json["cylinders"][1]["lies"]);
  EXPECT_FALSE(json["given"][2]["found"]);
  EXPECT_THAT(ran.err, HasSubstr("cylinder 3 (radius 40 mm, height 90 mm) was not found"));
  EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(out) / "cylinders.png"));
  EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(out) / "cylinders.json"));
  const Ran text = Cylinders(cloud, {"--cylinder", "25.75,173", "--cylinder", "40,90"});
  EXPECT_THAT(text.out, HasSubstr("cylinder 1 (radius 25.75 mm, height 173 mm): stands"));
  EXPECT_THAT(text.out, HasSubstr("cylinder 2 (radius 40 mm, height 90 mm): not found"));
}

TEST_F(CylindersTest, SaysThatWithoutScanOrderLineEdgesAreLeftOut) {
  // A PLY has no rows, and the sensor's position must be given.
  const Ran ran = Succeeded(Cylinders(
      Write("cloud.ply", Image()), {"--cylinder", "25.75,173", "--sensor-origin", "0.75,0,0.75"}));
  EXPECT_THAT(ran.err, HasSubstr("no scan order: edges along scan lines are not detected"));
  EXPECT_THAT(ran.out, HasSubstr("stands"));
  EXPECT_THAT(ran.out, HasSubstr(" 0 by scan lines"));
}

TEST_F(CylindersTest, TakesOtherUnitsACropAndTheMethodAsPublished) {
  auto image = Image();
  const std::string cloud = Write("cloud.pcd", image);
  const Ran cropped =
      Succeeded(Cylinders(cloud, {"--cylinder", "25.75,173", "--cylinder", "26.75,134", "--crop",
                                  "-0.3,-0.3,-1,0.3,-0.03,1", "--up", "0,0,1", "--json"}));
  const auto json = nlohmann::json::parse(cropped.out);
  EXPECT_TRUE(json["given"][0]["found"]);
  EXPECT_FALSE(json["given"][1]["found"]);
  const Ran published =
      Succeeded(Cylinders(cloud, {"--cylinder", "25.75,173", "--as-published", "--json"}));
  EXPECT_EQ(nlohmann::json::parse(published.out)["noise_m"], 0.0);
  for (auto& p : image.points_C) p *= 1000.0;
  for (auto& p : image.origins_C) p *= 1000.0;
  const Ran mm =
      Succeeded(Cylinders(Write("mm.pcd", image), {"--cylinder", "25.75,173", "--unit", "mm",
                                                   "--sensor-origin", "0.75,0,0.75"}));
  EXPECT_THAT(mm.out, HasSubstr("stands"));
}

TEST_F(CylindersTest, AnotherUnitAndASensorInTheTablesPlaneAreNamed) {
  auto image = Image();
  image.origins_C = {Eigen::Vector3d::Zero()};
  const auto run = [&](const std::string& name) {
    return Cylinders(Write(name, image), {"--cylinder", "25.75,173"}).err;
  };
  EXPECT_THAT(run("zero.pcd"), HasSubstr("0,0,0 lies in the table's plane"));
  for (auto& p : image.points_C) p *= 1000.0;
  EXPECT_THAT(run("mm.pcd"), HasSubstr("m apart: try --unit mm"));
}

TEST_F(CylindersTest, BadInputIsRefused) {
  const std::string cloud = Write("cloud.pcd", Image());
  ExpectRefused(cloud, {}, "--cylinder");
  for (const std::string bad : {"0,100", "25,0", "-5,100", "25", "25,100,3", "a,b", "nan,100", "",
                                "0.035,0.115", "25,0.1"}) {
    ExpectRefused(cloud, {"--cylinder", bad}, "RADIUS,HEIGHT in mm");
  }
  ExpectRefused(cloud, {"--cylinder", "0.035,0.115"}, "both at least 1");
  ExpectRefused(folder_ / "missing.pcd", {"--cylinder", "25,100"}, "missing.pcd");
  ExpectRefused(cloud, {"--cylinder", "25,100", "--up", "0,0,0"}, "--up");
  ExpectRefused(cloud, {"--cylinder", "25,100", "--crop", "5,5,5,6,6,6"},
                "the box contains none of the");
}

TEST_F(CylindersTest, EmptyCloudsAndCloudsWithoutATableAreNamed) {
  ExpectRefused(folder_.Write("empty.pcd", ""), {"--cylinder", "25,100"}, "empty.pcd");
  geometry::RangeImage image = Image();
  image.points_C.resize(50);
  image.profiles = 1;
  image.samples = 50;
  ExpectRefused(Write("few.pcd", image), {"--cylinder", "25,100"}, "at least 100 points");
  base::Rng rng(2);
  geometry::RangeImage cube{1, 3000, {}, {Eigen::Vector3d(0, 0, 3)}};
  for (int i = 0; i < cube.samples; ++i) {
    cube.points_C.push_back(geometry::samples::RandomInUnitCube(rng));
  }
  ExpectRefused(Write("cube.pcd", cube), {"--cylinder", "25,100", "--as-published"}, "no table");
}

TEST_F(CylindersTest, FilesThatAreNoCloudsAreNamed) {
  ExpectRefused(folder_.Write("text.pcd", "this is no cloud\n"), {"--cylinder", "25,100"},
                "text.pcd");
  const std::string cut =
      folder_.Write("cut.pcd",
                    "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 500\n"
                    "HEIGHT 1\nPOINTS 500\nDATA ascii\n0 0 1\n");
  ExpectRefused(cut, {"--cylinder", "25,100"}, "cut.pcd");
  ExpectRefused(folder_.path(), {"--cylinder", "25,100"}, folder_.path().filename());
}

TEST_F(CylindersTest, OneThatIsLargerThanTheSceneIsNotFoundAndThatIsSaid) {
  const Ran ran = Succeeded(Cylinders(Write("cloud.pcd", Image()), {"--cylinder", "900,4000"}));
  EXPECT_THAT(ran.err, HasSubstr("is larger than the scene"));
  EXPECT_THAT(ran.out, HasSubstr("not found"));
}

}  // namespace
}  // namespace rangegrasp::testing_support
