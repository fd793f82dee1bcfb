// The parts commands, as a user with their own mesh or cloud would run them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>

#include "cli/command.h"
#include "parts/task/peanuts.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing_support::Ran;
using testing_support::RunProgram;
using testing_support::TempFolder;

// A ball with a rod on its x side: rings of points along x, with two ends.
parts::Shape Lollipop() {
  const auto x = [](double t) { return -0.99 + 4.0 * t; };
  return parts::samples::Tube(
      40, 16, [&](double t) { return Eigen::Vector3d(x(t), 0.0, 0.0); },
      [&](double t) { return std::max(0.15, std::sqrt(std::max(0.0, 1.0 - x(t) * x(t)))); });
}

std::string PlyOf(const geometry::Points& points) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\nelement vertex " << points.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const auto& p : points) out << p.transpose() << "\n";
  return out.str();
}

class PartsTest : public testing::Test {
 protected:
  PartsTest() { mesh_ = folder_.Write("lollipop.off", testing_support::OffOf(Lollipop())); }

  Ran Parts(std::vector<std::string> more) {
    more.insert(more.begin(), "parts");
    more.insert(more.end(), {"-o", Out()});
    return RunProgram(more);
  }
  /// The table of the parts of one file.
  base::CsvTable TableOf(const std::vector<std::string>& arguments) {
    Succeeded(Parts(arguments));
    const auto name = std::filesystem::path(arguments.front()).stem();
    return base::CsvTable::Read(folder_ / "out" / (name.string() + ".csv"));
  }
  std::string Out() const { return folder_ / "out"; }
  void ExpectRefused(const std::vector<std::string>& arguments, const std::string& says) {
    ExpectRefusal(Parts(arguments), says);
  }

  TempFolder folder_;
  std::string mesh_;
};

TEST_F(PartsTest, WritesLabelsAColouredShapeAndAPicture) {
  const auto table = TableOf({mesh_});
  double elements = 0.0;
  for (std::size_t part = 0; part < table.rows(); ++part) {
    elements += table.Number(part, table.Column("elements"));
  }
  EXPECT_EQ(elements, static_cast<double>(Lollipop().faces.size()));
  const std::string labels = base::ReadFile(folder_ / "out/lollipop.seg");
  EXPECT_EQ(std::count(labels.begin(), labels.end(), '\n'),
            static_cast<long>(Lollipop().faces.size()));
  EXPECT_THAT(base::ReadFile(folder_ / "out/lollipop.ply"), testing::StartsWith("ply\n"));
  EXPECT_THAT(base::ReadFile(folder_ / "out/lollipop.png"), testing::StartsWith("\x89PNG"));
}

TEST_F(PartsTest, EveryMethodSegmentsAMesh) {
  for (const char* method : {"mirror", "hierarchy", "kmeans", "sdf", "core"}) {
    const Ran ran = Succeeded(Parts({mesh_, "--method", method}));
    EXPECT_THAT(ran.out, testing::ContainsRegex("[2-9] parts of 1280 faces")) << method;
  }
}

TEST_F(PartsTest, OnePartByDiameterNamesTheOptionThatMayFindMore) {
  const auto err = [&](const char* clusters) {
    return Succeeded(Parts({mesh_, "--method", "sdf", "--parts", clusters})).err;
  };
  EXPECT_THAT(err("1"),
              testing::HasSubstr("lollipop.off: one part: the clusters of the diameters"));
  EXPECT_THAT(err("1"), testing::HasSubstr("--parts 2"));
  EXPECT_THAT(err("2"), testing::Not(testing::HasSubstr("one part")));
}

TEST_F(PartsTest, KMeansGivesAsManyPartsAsAsked) {
  for (const int k : {1, 2, 7}) {
    const auto table = TableOf({mesh_, "--method", "kmeans", "--parts", std::to_string(k)});
    EXPECT_EQ(table.rows(), static_cast<std::size_t>(k));
  }
}

// A ball on a stick.
TEST_F(PartsTest, AHierarchyHasAsManyPartsAsAskedAndNoneBelowItsCutQuality) {
  const auto parts = [&](const char* option, const char* value) {
    return TableOf({mesh_, "--method", "hierarchy", option, value}).rows();
  };
  EXPECT_EQ(parts("--parts", "2"), 2U);
  EXPECT_EQ(parts("--cut-quality", "0.001"), 1U);
}

TEST_F(PartsTest, EachPartIsAMeshAndSeveralFilesAreSeveralResults) {
  const std::string other = folder_ / "other.off";
  std::filesystem::copy_file(mesh_, other);
  Succeeded(Parts({mesh_, other, "--method", "hierarchy", "--parts", "2", "--meshes"}));
  for (const char* name : {"lollipop", "other"}) {
    std::size_t bytes = 0;
    for (const char* part : {"_part_0.stl", "_part_1.stl"}) {
      bytes += base::ReadFile(folder_ / "out" / (std::string(name) + part)).size() - 84;
    }
    EXPECT_EQ(bytes, 50 * Lollipop().faces.size()) << name;
  }
  std::filesystem::create_directory(folder_ / "again");
  const std::string again = folder_ / "again/other.off";
  std::filesystem::copy_file(mesh_, again);
  ExpectRefused({other, again}, "would both write");
}

TEST_F(PartsTest, AnErrorInOneFileDoesNotStopTheOthers) {
  const std::string other = folder_ / "other.off";
  std::filesystem::copy_file(mesh_, other);
  const std::string broken = folder_.Write("broken.off", "no mesh");
  const Ran ran = Parts({mesh_, broken, other, "--method", "kmeans", "--parts", "1"});
  EXPECT_EQ(ran.code, 2);
  for (const std::string& file : {mesh_, other}) {
    EXPECT_THAT(ran.out, HasSubstr(file + ": 1 part of 1280 faces"));
  }
  EXPECT_THAT(ran.err, HasSubstr(broken));
  EXPECT_THAT(ran.err, HasSubstr("1 of 3 shapes could not be segmented"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/other.seg"));
}

TEST_F(PartsTest, TheSameFileGivesTheSameBytes) {
  const auto files = [&] {
    Succeeded(Parts({mesh_}));
    std::vector<std::string> texts;
    for (const char* name : {"lollipop.seg", "lollipop.ply", "lollipop.png"}) {
      texts.push_back(base::ReadFile(folder_ / "out" / name));
    }
    return texts;
  };
  EXPECT_EQ(files(), files());
}

TEST_F(PartsTest, ACloudHasALabelAPoint) {
  const std::string cloud = folder_.Write("cloud.ply", PlyOf(Lollipop().points));
  EXPECT_THAT(Succeeded(Parts({cloud, "--go-on-outside"})).out, HasSubstr(" points\n"));
  const std::string labels = base::ReadFile(folder_ / "out/cloud.seg");
  EXPECT_EQ(std::count(labels.begin(), labels.end(), '\n'),
            static_cast<long>(Lollipop().points.size()));
}

TEST_F(PartsTest, AMeshInItsPoseInvariantFormHasLabelsForItsOwnFaces) {
  const Ran ran = Succeeded(Parts({mesh_, "--pose-invariant", "--go-on-outside"}));
  EXPECT_THAT(ran.out, testing::ContainsRegex("[2-9] parts of 1280 faces"));
}

// A cloud of one view: the handle is a separate part, the container is the core.
TEST_F(PartsTest, AScannedMugHasAContainerAndAHandle) {
  const std::string cloud = folder_ / "mug.ply";
  const std::string experiment = RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml";
  Succeeded(
      RunProgram({"scan", experiment, "--trial", "coffee_cup-0004", "--target-only", "-o", cloud}));
  const auto table = TableOf({cloud});
  ASSERT_GE(table.rows(), 2U);
  EXPECT_GT(table.Number(0, table.Column("share")), 0.8);
  // The scanned mug stands upright: its handle is what extends beyond the wall's radius of 40 mm.
  const auto points = parts::ReadPolygons(cloud).mesh.vertices;
  const auto labels = parts::ReadLabels(folder_ / "out/mug.seg", points.size());
  std::array<double, 2> middle{};
  std::size_t rim = 0;
  for (const auto& p : points) {
    if (p[2] < 0.09) continue;
    ++rim;
    middle[0] += p[0];
    middle[1] += p[1];
  }
  for (double& m : middle) m /= static_cast<double>(rim);
  std::map<int, int> handle;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double out = std::hypot(points[i][0] - middle[0], points[i][1] - middle[1]);
    if (out > 0.050) ++handle[labels[i]];
  }
  ASSERT_EQ(handle.size(), 1U);
  EXPECT_GT(handle.begin()->first, 0);
  EXPECT_GT(handle.begin()->second, 30);
}

// The same from the whole scan: perception finds the object on the table, without the arm.
TEST_F(PartsTest, APerceivedObjectIsAFileToTakeApart) {
  const std::string cloud = folder_ / "scan.pcd";
  const std::string experiment = RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml";
  ASSERT_EQ(RunProgram({"scan", experiment, "--trial", "coffee_cup-0005", "-o", cloud}).code, 0);
  const std::string out = folder_ / "perceived";
  const Ran ran =
      Succeeded(RunProgram({"perceive", cloud, "--crop", "-0.25,-0.25,-1,0.25,0.25,1", "-o", out}));
  EXPECT_THAT(ran.out, HasSubstr("object 1: "));
  EXPECT_EQ(Parts({out + "/object_1.ply", "--go-on-outside"}).code, 0);
  const Ran turned = RunProgram({"perceive", cloud, "--crop", "1,0,0,0,1,1"});
  EXPECT_EQ(turned.code, 2);
  EXPECT_THAT(turned.err, HasSubstr("--crop"));
  EXPECT_EQ(RunProgram({"perceive", cloud, "--crop", "1,0,0"}).code, 2);
}

TEST_F(PartsTest, AnInputIsNotOverwritten) {
  const std::string cloud = folder_.Write("out/cloud.ply", PlyOf(Lollipop().points));
  const std::string before = base::ReadFile(cloud);
  ExpectRefused({cloud, "--method", "hierarchy"}, "cloud.ply: is an input");
  EXPECT_EQ(base::ReadFile(cloud), before);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/cloud.seg"));
}

TEST_F(PartsTest, BadUsageAndInputAreRefusedWithWhatWouldBeRight) {
  const std::string cloud = folder_.Write("cloud.ply", PlyOf(Lollipop().points));
  ExpectRefused({}, "a FILE");
  ExpectRefused({folder_ / "none.off"}, "none.off");
  ExpectRefused({folder_.Write("a.off", "OFF\nx\n")}, "a.off");
  ExpectRefused({folder_.Write("a.txt", "1 2 3")}, "a.txt: unknown ending");
  ExpectRefused({mesh_, "--method", "mirrow"}, "--method");
  ExpectRefused({mesh_, "--parts", "3"}, "kmeans and sdf");
  ExpectRefused({mesh_, "--method", "kmeans", "--parts", "0"}, "--parts");
  for (const char* number : {"nan", "0", "1e9", "x"}) {
    ExpectRefused({mesh_, "--method", "hierarchy", "--cut-quality", number}, "--cut-quality");
  }
  ExpectRefused({mesh_, "--method", "sdf", "--cut-quality", "0.5"}, "--method hierarchy");
  ExpectRefused({cloud, "--go-on-outside", "--meshes"}, "needs a mesh");
  ExpectRefused({mesh_, "--method", "sdf", "--pose-invariant"}, "--pose-invariant");
  ExpectRefused({mesh_, "--method", "core", "--go-on-outside"}, "--go-on-outside");
  for (const char* method : {"kmeans", "sdf", "core"}) {
    ExpectRefused({cloud, "--method", method}, "cloud.ply: is a point cloud");
  }
}

}  // namespace
}  // namespace rangegrasp
