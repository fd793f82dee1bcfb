// A mesh becomes an object, or is refused with a reason and no files left behind. The meshes are
// generated here.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "base/image/image.h"
#include "cli/command.h"
#include "geometry/mesh.h"
#include "geometry/sample_meshes.h"

namespace rangegrasp {
namespace {

namespace fs = std::filesystem;
using geometry::samples::BoxMesh;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing_support::ExpectRefusal;
using testing_support::Ran;
using testing_support::RunProgram;
using testing_support::TempFolder;

class AddObjectTest : public testing::Test {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers refuse CoACD's library";
#endif
    if (!fs::exists(RANGEGRASP_SOURCE_DIR "/.cache/coacd/lib_coacd.so")) {
      GTEST_SKIP() << "CoACD is not there; scripts/setup fetches it";
    }
    folder_.Write("box.off", Off(box_));
  }
  static std::string Off(const geometry::TriangleMesh& mesh) {
    std::string text = fmt::format("OFF\n{} {} 0\n", mesh.vertices.size(), mesh.triangles.size());
    for (const auto& v : mesh.vertices) text += fmt::format("{} {} {}\n", v.x(), v.y(), v.z());
    for (const auto& [a, b, c] : mesh.triangles) text += fmt::format("3 {} {} {}\n", a, b, c);
    return text;
  }
  std::string Out() const { return (folder_ / "objects").string(); }
  Ran Add(const std::string& mesh, std::vector<std::string> more = {},
          const std::string& lift_trials = "0") const {
    std::vector<std::string> arguments = {"add-object", (folder_ / mesh).string(), "--out",
                                          Out(),        "--lift-trials",           lift_trials};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }
  // Expects exit code 2, a reason, and no files written.
  void ExpectRefused(const std::string& mesh, const std::string& reason,
                     const std::vector<std::string>& more = {}) const {
    ExpectRefusal(Add(mesh, more), reason);
    EXPECT_FALSE(fs::exists(Out())) << reason;
  }

  TempFolder folder_;
  const geometry::TriangleMesh box_ = BoxMesh({20, 30, 50});
};

TEST_F(AddObjectTest, AMeshCanBeGraspedInOneCommandAndAnExperimentOfFiveLines) {
  folder_.Write("My Box.off", Off(box_));
  const Ran ran = Add("My Box.off", {"--mass", "200", "--surface", "cardboard"}, "2");
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("my_box: 40 x 60 x 100 mm, 240.0 cm3, 200 g (833 kg/m3)"));
  EXPECT_THAT(ran.out, HasSubstr("unit: mm, guessed"));
  EXPECT_THAT(ran.out, HasSubstr("hulls: 1; they cover 100.0 %"));
  EXPECT_THAT(ran.out, HasSubstr("resting poses: pose0"));
  EXPECT_THAT(ran.out, HasSubstr("lift test: 2 of 2 delivered"));
  for (const char* file : {"my_box.xml", "my_box.png", "visual.obj", "hull0.obj"}) {
    EXPECT_TRUE(fs::exists(fs::path(Out()) / "my_box" / file)) << file;
  }
  const auto experiment =
      folder_.Write("mine.yaml", "name: mine\nscene: " RANGEGRASP_SOURCE_DIR
                                 "/scenes/tabletop.xml\nsensor: " RANGEGRASP_SOURCE_DIR
                                 "/models/sensors/line_scanner.yaml\nobject_folders: [objects]\n"
                                 "objects: [my_box, salt_cuboid]\n");
  const Ran run = RunProgram({"run", experiment.string(), "--trials", "1", "--out",
                              (folder_ / "results").string(), "--json"});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("my_box"), HasSubstr("salt_cuboid")));
}

TEST_F(AddObjectTest, TheSameMeshIsTheSameBytes) {
  ASSERT_EQ(Add("box.off").code, 0);
  const auto xml = fs::path(Out()) / "box/box.xml";
  const std::string first = base::ReadFile(xml);
  const std::string hull = base::ReadFile(fs::path(Out()) / "box/hull0.obj");
  ExpectRefusal(Add("box.off"), "already exists; --overwrite");
  ASSERT_EQ(Add("box.off", {"--overwrite"}).code, 0);
  EXPECT_EQ(base::ReadFile(xml), first);
  EXPECT_EQ(base::ReadFile(fs::path(Out()) / "box/hull0.obj"), hull);
}

TEST_F(AddObjectTest, ItsFileHasAPictureOfItsOwn) {
  ASSERT_EQ(Add("box.off").code, 0);
  const auto png = folder_ / "snapshot.png";
  const Ran ran =
      RunProgram({"snapshot", Out() + "/box/box.xml", "-o", png.string(), "--size", "160x120"});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_TRUE(fs::exists(png));
}

// The density of plastic, 900 kg/m3; 0.8^3 of 240 cm3.
TEST_F(AddObjectTest, IsScaledToASizeAndHasItsSurfacesDensity) {
  const Ran ran = Add("box.off", {"--size-mm", "80", "--name", "small"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("small: 32 x 48 x 80 mm, 122.9 cm3, 111 g (900 kg/m3)"));
}

TEST_F(AddObjectTest, RefusesWhatIsNoMesh) {
  folder_.Write("empty.obj", "");
  ExpectRefused("empty.obj", "empty.obj");
  folder_.Write("text.stl", "hello");
  ExpectRefused("text.stl", "text.stl");
  folder_.Write("points.obj", "v 0 0 0\nv 1 0 0\n");
  ExpectRefused("points.obj", "points.obj");
  ExpectRefused("nowhere.obj", "nowhere.obj");
  auto nan = box_;
  nan.vertices[3].x() = std::numeric_limits<double>::quiet_NaN();
  folder_.Write("nan.off", Off(nan));
  ExpectRefused("nan.off", "nan.off");
}

TEST_F(AddObjectTest, RefusesWhatIsNoSolid) {
  auto open = box_;
  open.triangles.resize(open.triangles.size() - 4);
  folder_.Write("open.off", Off(open));
  ExpectRefused("open.off", "is open");
  folder_.Write("sheet.off", Off(BoxMesh({20, 30, 1e-6})));
  ExpectRefused("sheet.off", "no volume");
}

TEST_F(AddObjectTest, RefusesNonsenseOfSizesAndUnits) {
  ExpectRefused("box.off", "would be 100 m long", {"--unit", "m"});
  ExpectRefused("box.off", "is its unit mm?", {"--unit", "m"});
  folder_.Write("odd.off", Off(BoxMesh({0.4, 0.5, 0.8})));
  ExpectRefused("odd.off", "Give the unit with --unit");
  ExpectRefused("box.off", "--size-mm", {"--size-mm", "-3"});
  ExpectRefused("box.off", "furlong", {"--unit", "furlong"});
  ExpectRefused("box.off", "--mass", {"--mass", "0"});
  ExpectRefused("box.off", "--mass` is in grams", {"--mass", "0.2"});
  ExpectRefused("box.off", "implausible", {"--mass", "90000"});
  ExpectRefused("box.off", "velvet", {"--surface", "velvet"});
  ExpectRefused("box.off", "--name 'No Name'", {"--name", "No Name"});
  folder_.Write("label.png", "no picture");
  const std::string label = (folder_ / "label.png").string();
  ExpectRefused("box.off", label + ": is not a PNG image", {"--texture", label});
  const std::string whole =
      image::EncodePng(image::Image{64, 64, std::vector<std::uint8_t>(3 * 64 * 64, 90)});
  folder_.Write("label.png", whole.substr(0, whole.size() / 2));
  ExpectRefused("box.off", label + ": is not a complete PNG image", {"--texture", label});
}

TEST_F(AddObjectTest, NamesTheGuessedUnitIfTheMassDoesNotFitTheSize) {
  folder_.Write("inches.off", Off(BoxMesh({1.5, 1.5, 2.0})));
  ExpectRefused("inches.off", "it is 40 mm long; unit: cm, guessed", {"--mass", "600"});
}

TEST_F(AddObjectTest, SurfacesMayBeAdded) {
  folder_.Write("objects/surfaces.yaml",
                "rubber:\n  glove: {static: 0.9, from: 0.7, to: 1.2, kinetic: 0.8}\n"
                "  laminate: {static: 0.8, kinetic: 0.7}\n  density_kg_m3: 1100\n");
  const Ran ran = Add("box.off", {"--surface", "rubber"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("264 g (1100 kg/m3), rubber"));
  folder_.Write("objects/surfaces.yaml",
                "rubber:\n  glove: {static: 0.9, from: 1.0, to: 1.2, kinetic: 0.8}\n"
                "  laminate: {static: 0.8, kinetic: 0.7}\n");
  const Ran wrong = Add("box.off", {"--surface", "rubber", "--overwrite"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, AllOf(HasSubstr("surfaces.yaml:2"), HasSubstr("below `static`")));
}

}  // namespace
}  // namespace rangegrasp
