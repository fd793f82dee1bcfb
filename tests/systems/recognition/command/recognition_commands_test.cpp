#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "cli/command.h"
#include "geometry/cloud_file.h"
#include "geometry/mesh.h"
#include "geometry/mesh_file.h"
#include "geometry/synthetic.h"
#include "perception/raster_scan.h"
#include "temp_folder.h"

namespace rangegrasp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;
using testing_support::ExpectRefused;
using testing_support::RunProgram;

const fs::path kRepository = RANGEGRASP_SOURCE_DIR;

TEST(Bring, AnUnknownObjectNeedsAnExperimentThatListsIt) {
  ExpectRefused({"bring", "--set", "seed=1", "beaker"},
                "others need an experiment file that lists them: --experiment FILE");
}

// No object is as slow as this so soon after its drop.
TEST(Bring, WithoutAnArrangementTheReasonIsNotACrash) {
  const auto ran =
      RunProgram({"bring", "coffee_cup", "--arrangement", "pile", "--set", "clutter.max_draws=1",
                  "--set", "clutter.rest_speed_mm_s=0.01", "--set", "clutter.settle_limit_s=0.5"});
  EXPECT_EQ(ran.code, 1) << ran.out;
  EXPECT_THAT(ran.err, HasSubstr("coffee_cup was not handed over: no arrangement: "));
}

TEST(Bring, CheckNamesKnownGraspsThatTheHandDoesNotOpenFor) {
  const testing_support::TempFolder folder;
  const std::string source = RANGEGRASP_SOURCE_DIR;
  folder.Write("objects/slab/slab.xml",
               "<mujoco><worldbody><body name=\"slab\"><freejoint/><geom type=\"box\" "
               "size=\".02 .10 .03\" mass=\"0.2\"/></body></worldbody></mujoco>");
  const std::string at = "    at_mm: [0, 0, 20]\n    approach: [0, 0, -1]\n";
  folder.Write("objects/slab/grasps.yaml",
               "grasps:\n  across:\n" + at +
                   "    closing: [1, 0, 0]\n    width_mm: 40\n  along:\n" + at +
                   "    closing: [0, 1, 0]\n    width_mm: 200\n");
  const auto file = folder.Write(
      "own.yaml",
      "task: bring\nname: own\nscene: " + source + "/scenes/tabletop.xml\nsensor: " + source +
          "/models/sensors/line_scanner.yaml\nobject_folders: [objects]\nobjects: [slab]\n");
  const auto ran = Succeeded(RunProgram({"check", file}));
  EXPECT_THAT(ran.out, HasSubstr("grasp 'along': its width_mm is 200, but the hand opens only "));
  EXPECT_THAT(ran.out, HasSubstr("it is never used"));
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("'across'")));
  // `bring` and `run` repeat it, before they find that there is no such object.
  const std::vector<std::vector<std::string>> commands = {
      {"bring", "slob", "--experiment", file},
      {"run", file, "--objects", "slob", "--out", folder / "out"}};
  for (const auto& command : commands) {
    const auto refused = RunProgram(command);
    EXPECT_THAT(refused.err, HasSubstr("did you mean 'slab'?"));
    EXPECT_THAT(refused.err,
                HasSubstr("grasp 'along': its width_mm is 200, but the hand opens only "));
  }
}

TEST(Scan, TakesEveryExperimentThatArrangesObjects) {
  const testing_support::TempFolder folder;
  const auto scan = [&](const char* experiment) {
    return std::vector<std::string>{"scan", kRepository / "experiments" / experiment, "-o",
                                    folder / "scan.pcd"};
  };
  Succeeded(RunProgram(scan("clear_pile.yaml")));
  Succeeded(RunProgram(scan("bring.yaml")));
  const auto cloud = geometry::ReadCloud(folder / "scan.pcd");
  EXPECT_GT(cloud.points.size(), 10000u);
  ExpectRefused(scan("seam_base.yaml"),
                "seam_base.yaml: has no scene that can be shown (`task: seam`); give an experiment "
                "that arranges objects");
}

class RecognizeTest : public testing::Test {
 protected:
  /// A single dextrose box on the table.
  std::string Scan(bool color) const {
    const auto file = folder_ / (color ? "colored.yaml" : "plain.yaml");
    base::WriteFile(
        file, "name: scan\ntask: grasping\nscene: " + Path("scenes/tabletop.xml") +
                  "\narrangement: single\nsensor: " + Path("models/sensors/line_scanner.yaml") +
                  "\nobjects: [dextrose]\ncolor: " + (color ? "true" : "false") + "\n");
    const auto cloud = (folder_ / (color ? "colored.pcd" : "plain.pcd")).string();
    const auto ran = RunProgram({"scan", file.string(), "-o", cloud});
    EXPECT_EQ(ran.code, 0) << ran.err;
    return cloud;
  }

  static std::string Path(const std::string& in_repository) {
    return (kRepository / in_repository).string();
  }

  /// Two packages of the same shape with different prints.
  std::string FolderOfTwins() const {
    const fs::path objects = kRepository / "models/objects";
    for (const std::string name : {"dextrose", "twin"}) {
      const fs::path folder = folder_ / "twins" / name;
      fs::create_directories(folder);
      for (const char* part : {"visual.obj", "label.png"}) {
        fs::copy_file(objects / "dextrose" / part, folder / part);
      }
      fs::copy_file(objects / "dextrose/dextrose.xml", folder / (name + ".xml"));
    }
    fs::copy_file(objects / "salt_cuboid/label.png", folder_ / "twins/twin/label.png",
                  fs::copy_options::overwrite_existing);
    return (folder_ / "twins").string();
  }

  /// A cube of 30 mm.
  std::string FolderOfACube() const {
    const fs::path folder = folder_ / "cubes";
    fs::create_directories(folder);
    geometry::WriteStl(folder / "cube.stl", synthetic::BoxMesh(0.03, 0.03, 0.03));
    return folder.string();
  }

  static std::string Recognized(const std::string& cloud, const std::string& library,
                                std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"recognize", cloud,    "--library",
                                          library,     "--crop", "-0.3,-0.3,-0.05,0.3,0.3,0.4"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto ran = RunProgram(arguments);
    EXPECT_EQ(ran.code, 0) << ran.err;
    return ran.out;
  }

  static nlohmann::json Found(const std::string& cloud, const std::string& library) {
    return nlohmann::json::parse(Recognized(cloud, library, {"--json"})).at("found");
  }

  const testing_support::TempFolder folder_;
};

TEST_F(RecognizeTest, TheObjectIsNamedAndTellsHowItsColorsAgree) {
  for (const bool color : {false, true}) {
    const auto found = Found(Scan(color), Path("models/objects"));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0]["object"], "dextrose");
    const double agree = found[0]["color"];
    if (color) {
      EXPECT_GT(agree, 0.7);
      EXPECT_LT(agree, 1.0);
    } else {
      EXPECT_EQ(agree, 1.0);
    }
  }
}

TEST_F(RecognizeTest, TwinsAreToldApartByTheirPrintAlone) {
  const auto twins = FolderOfTwins();
  EXPECT_TRUE(Found(Scan(false), twins).empty());
  const auto found = Found(Scan(true), twins);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0]["object"], "dextrose");
}

TEST_F(RecognizeTest, AnUnknownObjectIsReportedWithItsPlaceAndTheReason) {
  const std::string cloud = Scan(false);
  const std::string library = FolderOfACube();
  const std::string text = Recognized(cloud, library);
  EXPECT_THAT(text, HasSubstr("0 of 1 perceived objects are known\nunknown: at "));
  EXPECT_THAT(text, HasSubstr("nearest cube, score 0."));
  const auto json = nlohmann::json::parse(Recognized(cloud, library, {"--json"}));
  ASSERT_EQ(json.at("unknown").size(), 1u);
  const auto& unknown = json.at("unknown")[0];
  EXPECT_EQ(unknown.at("nearest"), "cube");
  EXPECT_LT(unknown.at("score"), 0.72);
  EXPECT_EQ(unknown.at("center_m").size(), 3u);
  EXPECT_EQ(unknown.at("size_m").size(), 3u);
  EXPECT_THAT(unknown.at("reason").get<std::string>(), HasSubstr("at least 0.72"));
}

TEST_F(RecognizeTest, ACloudInMillimetresIsWarnedOf) {
  const auto scan = synthetic::MakeScan({}, {});  // an empty table
  std::string text;
  for (const Eigen::Vector3d& p : scan.points_W) {
    for (const double x : {p.x(), p.y(), p.z()}) text += std::to_string(1000.0 * x) + " ";
    text.back() = '\n';
  }
  const std::string cloud = folder_.Write("mm.xyz", text).string();
  const std::string library = FolderOfACube();
  const auto run = [&](const std::string& unit) {
    return RunProgram({"recognize", cloud, "--library", library, "--sensor-origin", "800,0,620",
                       "--unit", unit})
        .err;
  };
  EXPECT_THAT(run("m"), HasSubstr(cloud + ": the points are 2.0 m apart: try --unit mm"));
  EXPECT_THAT(run("mm"), Not(HasSubstr("--unit")));
  // The sensor's position is in metres, whatever the cloud's unit is.
  const std::string far = " m from the cloud: its position (--sensor-origin) must be in metres";
  EXPECT_THAT(run("m"), Not(HasSubstr(far)));
  EXPECT_THAT(run("mm"), HasSubstr(far));
}

TEST_F(RecognizeTest, ACloudWithoutScanOrderIsWarnedOf) {
  const std::string scanned = Scan(false);
  const auto cloud = geometry::ReadCloud(scanned);
  const std::string unordered = folder_ / "plain.ply";
  geometry::WriteCloud(unordered, {.profiles = cloud.height,
                                   .samples = cloud.width,
                                   .points_C = cloud.points,
                                   .origins_C = {cloud.sensor_origin.value()}});
  const std::string library = FolderOfACube();
  const auto run = [&](const std::string& file) {
    return RunProgram({"recognize", file, "--library", library}).err;
  };
  EXPECT_THAT(run(unordered), HasSubstr(unordered + ": the cloud has no scan order"));
  EXPECT_THAT(run(scanned), Not(HasSubstr("scan order")));
}

TEST_F(RecognizeTest, TheCloudIsReadBeforeTheLibrary) {
  ExpectRefused({"recognize", (folder_ / "no.pcd").string(), "--library", folder_ / "none"},
                "no.pcd: no such file");
}

TEST_F(RecognizeTest, AToleranceIsANumber) {
  ExpectRefused(
      {"recognize", "cloud.pcd", "--library", Path("models/objects"), "--tolerance-mm", "nan"},
      "--tolerance-mm: 'nan' must be a number from 0.5 to 20");
}

TEST_F(RecognizeTest, AFolderWithoutObjectsIsNamed) {
  fs::create_directories(folder_ / "empty");
  ExpectRefused({"recognize", Scan(false), "--library", folder_ / "empty"}, "NAME/NAME.xml");
}

// The output of `learn` for views of an object, and its message if there are too few.

class LearnTest : public testing::Test {
 protected:
  /// A cylinder on a table, seen from the given direction, 0.8 m to the side and 0.62 m above.
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

// The frame is at the foot of the cylinder, rotated by a quarter turn about y from the table's.
TEST_F(LearnTest, TheMeshIsGivenInAFrame) {
  const auto ran = RunProgram({"learn", View(0.0), View(2.1), View(4.2), "-o", Mesh(),
                               "--frame=0,0,1,0.01,0,1,0,0.02,-1,0,0,0,0,0,0,1"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto box = geometry::BoundsOf(geometry::ReadMesh(Mesh()).vertices);
  EXPECT_NEAR(box.min().x(), -0.12, 0.003);
  EXPECT_NEAR(box.max().x(), 0.0, 0.003);
  EXPECT_LT(box.center().tail<2>().norm(), 0.002);
}

TEST_F(LearnTest, AFrameThatIsNoPoseIsRefused) {
  for (const std::string row : {"2,0,0,0", "1,0,0,nan", "1,0,0,inf"}) {
    ExpectRefused({"learn", View(0.0), "-o", Mesh(), "--frame=" + row + ",0,1,0,0,0,0,1,0,0,0,0,1"},
                  "--frame must be a 4 x 4 pose matrix");
  }
  ExpectRefused({"learn", View(0.0), "-o", Mesh(), "--spacing-mm", "nan"}, "--spacing-mm");
}

TEST_F(LearnTest, AnythingButAnStlIsNotWritten) {
  const auto view = View(0.0);
  const std::string before = base::ReadFile(view);
  ExpectRefused({"learn", view, "-o", view}, "the name must end with .stl");
  EXPECT_EQ(base::ReadFile(view), before);
}

TEST_F(LearnTest, OneSideIsSaidToBeTooLittle) {
  const auto ran = RunProgram({"learn", View(0.0), "-o", Mesh()});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("unseen parts are guessed"));
}

TEST_F(LearnTest, ASensorThatIsNotAboveTheTableIsNamed) {
  const auto err = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"learn", View(0.0), "-o", Mesh()});
    return RunProgram(more).err;
  };
  EXPECT_THAT(err({"--sensor-origin=0.8,0,0.001"}), HasSubstr("lies in the table's plane"));
  EXPECT_THAT(err({"--sensor-origin=0.8,0,-0.6", "--up=0,0,1"}),
              HasSubstr("the sensor's position lies below the table: give --sensor-origin"));
  EXPECT_THAT(err({}), Not(HasSubstr("--sensor-origin")));
}

TEST_F(LearnTest, AnEmptyTableIsRefused) {
  const auto view = View(0.0);
  ExpectRefused(
      {"learn", view, "-o", Mesh(), "--crop", "-0.14", "-0.14", "-0.1", "-0.05", "0.14", "0.3"},
      view + ": only 0 points belong to an object on the table");
  EXPECT_FALSE(std::filesystem::exists(Mesh()));
}

}  // namespace
}  // namespace rangegrasp
