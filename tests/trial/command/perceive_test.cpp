// Tests the output of `perceive` for faulty and for correct clouds.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/rng.h"
#include "base/words.h"
#include "cli/command.h"

namespace rangegrasp::testing_support {
namespace {

using testing::HasSubstr;
using testing::Not;

struct Point {
  double x, y, z;
};

/// A table of 0.4 m at z = 0 with points 4 mm apart and 0.3 mm noise, seen from above.
std::vector<Point> Table() {
  base::Rng rng(1);
  std::vector<Point> points;
  for (int i = -50; i <= 50; ++i) {
    for (int k = -50; k <= 50; ++k) points.push_back({0.004 * i, 0.004 * k, 0.0003 * rng.Normal()});
  }
  return points;
}

/// The table with a box's top of a by b metres, 0.1 m high, instead of the table's points there.
std::vector<Point> TableWithBox(double a, double b) {
  base::Rng rng(2);
  std::vector<Point> points = Table();
  for (Point& p : points) {
    if (std::abs(p.x) <= 0.5 * a && std::abs(p.y) <= 0.5 * b) p.z = 0.1 + 0.0003 * rng.Normal();
  }
  return points;
}

class PerceiveTest : public testing::Test {
 protected:
  std::string Write(const std::vector<Point>& points, double unit = 1.0,
                    const std::string& name = "cloud.ply") const {
    const auto file = (folder_ / name).string();
    base::MakeFolderOf(file);
    std::ofstream out(file);
    out << "ply\nformat ascii 1.0\nelement vertex " << points.size()
        << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    for (const Point& p : points) {
      out << p.x / unit << ' ' << p.y / unit << ' ' << p.z / unit << '\n';
    }
    return file;
  }
  static Ran Perceive(const std::string& cloud, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"perceive", cloud, "--sensor-origin", "0,0,1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  TempFolder folder_;
};

TEST_F(PerceiveTest, TellsNoiseAndSpacingAndWarnsOfNothing) {
  const std::string cloud = Write(TableWithBox(0.08, 0.06));
  const Ran ran = Succeeded(Perceive(cloud, {"--json"}));
  const auto json = nlohmann::json::parse(ran.out);
  EXPECT_EQ(json["cloud"], cloud);
  EXPECT_EQ(json["unit"], "m");
  // The tolerance is a fifth, for 32 neighborhoods of 64 points each.
  EXPECT_NEAR(json["noise_m"].get<double>(), 0.0003, 0.00006);
  EXPECT_NEAR(json["spacing_m"].get<double>(), 0.004, 0.0008);
  EXPECT_EQ(json["objects"].size(), 1u);
  EXPECT_TRUE(json["warnings"].empty());
  const auto told = nlohmann::json::parse(Perceive(cloud, {"--json", "--noise-mm", "2"}).out);
  EXPECT_EQ(told["noise_m"], 0.002);
}

TEST_F(PerceiveTest, AnErrorNamesTheSensorsPlaceWhereNothingSaysIt) {
  const std::string cloud =
      Write({{0.0, 0.0, 1.0}, {0.0, 0.1, 1.0}, {0.1, 0.0, 1.1}, {0.1, 0.2, 1.0}});
  const Ran ran = RunProgram({"perceive", cloud});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("give its position with --sensor-origin x,y,z"));
  EXPECT_THAT(Perceive(cloud).err, testing::Not(HasSubstr("sensor-origin")));
}

TEST_F(PerceiveTest, WarnsIfNothingSaysWhereTheSensorWas) {
  const std::string cloud = Write(TableWithBox(0.08, 0.06));
  EXPECT_THAT(RunProgram({"perceive", cloud, "--up", "0,0,1"}).err,
              HasSubstr("no viewpoint: the sensor is assumed at 0,0,0 (--sensor-origin x,y,z)"));
  EXPECT_THAT(Perceive(cloud).err, Not(HasSubstr("viewpoint")));
  std::string text = base::ReadFile(cloud);
  text.insert(text.find("element"), "comment viewpoint 0 0 1\n");
  EXPECT_THAT(RunProgram({"perceive", folder_.Write("seen.ply", text)}).err,
              Not(HasSubstr("viewpoint")));
}

TEST_F(PerceiveTest, CloudsOfObjectsOfAnEarlierRunAreRemoved) {
  const std::string out = folder_ / "out";
  for (const char* name : {"object_7.ply", "object_7.stl", "object_x.ply", "my_object_7.ply"}) {
    folder_.Write(std::string("out/") + name, "old");
  }
  Succeeded(Perceive(Write(TableWithBox(0.08, 0.06)), {"-o", out}));
  EXPECT_FALSE(std::filesystem::exists(out + "/object_7.ply"));
  for (const char* name : {"object_1.ply", "object_7.stl", "object_x.ply", "my_object_7.ply"}) {
    EXPECT_TRUE(std::filesystem::exists(out + "/" + name)) << name;
  }
}

TEST_F(PerceiveTest, SaysThatThereAreNoObjects) {
  const Ran ran = Succeeded(Perceive(Write(Table())));
  EXPECT_THAT(ran.err, HasSubstr("no objects"));
}

TEST_F(PerceiveTest, SaysHowManyPointsTheBestPlaneHasWhereThereIsNoTable) {
  base::Rng rng(3);
  std::vector<Point> points;
  for (int i = 0; i < 3000; ++i) {
    const double x = rng.Uniform();
    const double y = rng.Uniform();
    points.push_back({x, y, rng.Uniform()});
  }
  const Ran ran = Perceive(Write(points), {"--noise-mm", "0.5"});
  EXPECT_NE(ran.code, 0);
  EXPECT_THAT(ran.err, testing::ContainsRegex(
                           "no table was found \\(the best plane has [0-9]+ points of 3000\\)"));
  EXPECT_THAT(ran.err, Not(HasSubstr("try --unit mm")));
}

TEST_F(PerceiveTest, SaysThatTheUnitMayBeAnother) {
  const std::string cloud = Write(TableWithBox(0.08, 0.06), 0.001);
  const Ran wrong = Perceive(cloud);
  EXPECT_THAT(wrong.err, HasSubstr("try --unit mm"));
  EXPECT_THAT(wrong.err, Not(HasSubstr("m long")));  // sizes mean nothing
  const Ran ran = Succeeded(Perceive(cloud, {"--unit", "mm"}));
  EXPECT_THAT(ran.err, Not(HasSubstr("--unit")));
  EXPECT_THAT(Perceive(Write(TableWithBox(0.08, 0.06)), {"--unit", "mm"}).err,
              HasSubstr("try --unit m\n"));
}

TEST_F(PerceiveTest, SaysThatUpPointsDown) {
  const std::string cloud = Write(TableWithBox(0.08, 0.06));
  const Ran ran = Perceive(cloud, {"--up", "0,0,-1"});
  EXPECT_NE(ran.code, 0);
  EXPECT_THAT(ran.err, HasSubstr("try --up with the other sign"));
  EXPECT_EQ(Perceive(cloud, {"--up", "0,0,1"}).code, 0);
}

TEST_F(PerceiveTest, ASensorInTheTablesPlaneIsNamedWhetherAssumedOrGiven) {
  const std::string cloud = Write(TableWithBox(0.08, 0.06));
  const std::string text = base::ReadFile(cloud);
  const std::string seen = folder_.Write(
      "seen.ply", std::string(text).insert(text.find("element"), "comment viewpoint 0 0 0\n"));
  EXPECT_THAT(RunProgram({"perceive", seen}).err,
              HasSubstr("0,0,0 lies in the table's plane, so its upper side is not known"));
  // It is 5 mm below the table, so that the upper side is found as little as with a wrong --up.
  const Ran ran = RunProgram({"perceive", cloud, "--sensor-origin=0,0,-0.005", "--up", "0,0,1"});
  EXPECT_NE(ran.code, 0);
  EXPECT_THAT(ran.err, HasSubstr("lies in the table's plane: give --sensor-origin"));
  EXPECT_THAT(ran.err, Not(HasSubstr("--up with the other sign")));
}

// Of 3,000 points in one place each would be a neighbor of each other one.
TEST_F(PerceiveTest, ZerosAreNotMeasured) {
  std::vector<Point> points = TableWithBox(0.08, 0.06);
  points.insert(points.end(), 3000, Point{0.0, 0.0, 0.0});
  const std::string cloud = Write(points);
  const Ran ran = Succeeded(Perceive(cloud, {"--json"}));
  const auto json = nlohmann::json::parse(ran.out);
  EXPECT_EQ(json.at("warnings").at(0), "3000 points at 0,0,0 are left out as not measured");
  EXPECT_THAT(ran.err, HasSubstr(cloud + ": 3000 points at 0,0,0 are left out as not measured"));
  EXPECT_EQ(json["objects"].size(), 1u);
}

TEST_F(PerceiveTest, SaysThatTheCropLeftNothing) {
  const Ran ran = Perceive(Write(Table()), {"--crop", "5,5,5,6,6,6"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("the box contains none of the 10201 points"));
}

TEST_F(PerceiveTest, WarnsOfAnObjectThatHasAThirdOfAllPoints) {
  // 300 x 200 mm of 400 x 400 mm is 38 % of the points; 200 x 200 mm is 25 %.
  EXPECT_THAT(Perceive(Write(TableWithBox(0.3, 0.2))).err, HasSubstr("% of all points"));
  EXPECT_THAT(Perceive(Write(TableWithBox(0.2, 0.2))).err, Not(HasSubstr("% of all points")));
}

TEST_F(PerceiveTest, WarnsOfAnObjectThatNoHandCouldHold) {
  // Walls of 0.7 m and 0.5 m on a table of 1 m.
  const auto with_wall = [](double length) {
    std::vector<Point> points;
    base::Rng rng(4);
    for (int i = -125; i <= 125; ++i) {
      for (int k = -50; k <= 50; ++k) {
        const double y = 0.004 * i;
        const bool wall = std::abs(k) <= 8 && std::abs(y) < 0.5 * length;
        points.push_back({0.004 * k, y, (wall ? 0.1 : 0.0) + 0.0003 * rng.Normal()});
      }
    }
    return points;
  };
  EXPECT_THAT(Perceive(Write(with_wall(0.7))).err, HasSubstr("too large for a hand"));
  EXPECT_THAT(Perceive(Write(with_wall(0.5))).err, Not(HasSubstr("too large for a hand")));
}

// One line of JSON per cloud, in the order of the names, whichever is ready first. A broken cloud
// does not stop the others.
TEST_F(PerceiveTest, SeveralCloudsAreToldInTurn) {
  Write(TableWithBox(0.08, 0.06), 1.0, "all/b.ply");
  Write(Table(), 1.0, "all/c.ply");
  std::ofstream(folder_ / "all/a.ply") << "no cloud";
  const std::string all = folder_ / "all";
  const std::string out = folder_ / "out";
  for (const char* jobs : {"1", "3"}) {
    const Ran ran = Perceive(all, {"--json", "--jobs", jobs, "-o", out});
    EXPECT_EQ(ran.code, 2);
    EXPECT_THAT(ran.err, HasSubstr("1 of 3 clouds could not be perceived"));
    const auto lines = base::Split(ran.out, '\n');
    ASSERT_EQ(lines.size(), 4u);  // and an empty part after the last newline
    EXPECT_THAT(nlohmann::json::parse(lines[0])["error"].get<std::string>(), HasSubstr("a.ply"));
    EXPECT_EQ(nlohmann::json::parse(lines[1])["cloud"], all + "/b.ply");
    EXPECT_EQ(nlohmann::json::parse(lines[1])["objects"].size(), 1u);
    EXPECT_EQ(nlohmann::json::parse(lines[2])["objects"].size(), 0u);
    const auto written = nlohmann::json::parse(base::ReadFile(out + "/b/perceived.json"));
    EXPECT_EQ(written, nlohmann::json::parse(lines[1]));
  }
  // A cloud alone gives the same result as among others.
  auto alone = nlohmann::json::parse(Perceive(all + "/b.ply", {"--json"}).out);
  auto among = nlohmann::json::parse(base::ReadFile(out + "/b/perceived.json"));
  alone.erase("seconds");
  among.erase("seconds");
  EXPECT_EQ(alone, among);
}

TEST_F(PerceiveTest, CloudsOfTheSameNameAreNotWrittenOverEachOther) {
  const std::string one = Write(Table(), 1.0, "one/cloud.ply");
  const std::string two = Write(Table(), 1.0, "two/cloud.ply");
  const Ran ran = Perceive(one, {two, "-o", folder_ / "out"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("have the same name"));
  std::filesystem::create_directory(folder_ / "empty");
  EXPECT_THAT(Perceive(folder_ / "empty").err, HasSubstr("without a .pcd, .ply"));
}

}  // namespace
}  // namespace rangegrasp::testing_support
