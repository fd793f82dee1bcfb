// One fault each, told with its cure.

#include "sim/check_object.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/surfaces.h"
#include "temp_folder.h"

namespace rangegrasp::sim {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

const std::string kSurface = "<custom><text name='surface' data='plastic'/></custom>";
const std::string kSeen =
    "<geom type='box' size='0.02 0.03 0.05' contype='0' conaffinity='0' group='2' mass='0'/>";
const std::string kSolid = "<geom type='box' size='0.02 0.03 0.05' group='3' mass='0.2'/>";

class CheckObjectTest : public testing::Test {
 protected:
  std::vector<base::Finding> Check(const std::string& body, const std::string& head = kSurface) {
    const auto file = folder_.Write("odd/odd.xml", "<mujoco>" + head +
                                                       "<worldbody><body name='odd'><freejoint/>" +
                                                       body + "</body></worldbody></mujoco>");
    return CheckObject({"odd", file});
  }
  void ExpectOne(bool error, const std::string& what, const std::vector<base::Finding>& findings) {
    ASSERT_EQ(findings.size(), 1U) << what;
    EXPECT_EQ(findings[0].error, error);
    EXPECT_THAT(findings[0].where, HasSubstr("odd.xml"));
    EXPECT_THAT(findings[0].what, HasSubstr(what));
    EXPECT_NE(findings[0].cure, "");
  }
  testing_support::TempFolder folder_;
};

TEST_F(CheckObjectTest, ShippedObjectsAreSound) {
  for (const auto& entry :
       std::filesystem::directory_iterator(RANGEGRASP_SOURCE_DIR "/models/objects")) {
    const std::string name = entry.path().filename().string();
    for (const auto& finding : CheckObject({name, entry.path() / (name + ".xml")})) {
      ADD_FAILURE() << base::TextOf(finding);
    }
  }
  EXPECT_THAT(Check(kSeen + kSolid), IsEmpty());
}

TEST_F(CheckObjectTest, SizesAndWhatIsSeen) {
  ExpectOne(true, "millimetres", Check("<geom type='box' size='20 30 50' mass='0.2'/>"));
  ExpectOne(true, "too small", Check("<geom type='box' size='2e-5 3e-5 5e-5' mass='0.2'/>"));
  ExpectOne(true, "no geom is seen", Check(kSolid));
  ExpectOne(true, "what is seen is 50 mm long, what collides 100 mm",
            Check("<geom type='box' size='0.01 0.015 0.025' contype='0' conaffinity='0' group='2' "
                  "mass='0'/>" +
                  kSolid));
}

TEST_F(CheckObjectTest, NothingThatCollidesAndWhatIsNoObject) {
  ExpectOne(true, "at least one collision geom", Check(kSeen));
  const auto file = folder_.Write("odd/odd.xml", "<mujoco><worldbody/></mujoco>");
  ExpectOne(true, "one root body", CheckObject({"odd", file}));
  EXPECT_FALSE(IsObjectFile(file));
  EXPECT_FALSE(IsObjectFile(RANGEGRASP_SOURCE_DIR "/scenes/tabletop.xml"));
  EXPECT_TRUE(IsObjectFile(RANGEGRASP_SOURCE_DIR "/models/objects/spread/spread.xml"));
}

// 0.24 l: 5 g are 21 kg/m3, 2.9 kg are 12,083.
TEST_F(CheckObjectTest, MassAndInertia) {
  const auto body = [](const std::string& inertial) {
    return inertial + kSeen + "<geom type='box' size='0.02 0.03 0.05' group='3'/>";
  };
  const auto inertial = [](double mass, double moment, double z = 0.0) {
    return fmt::format("<inertial pos='0 0 {}' mass='{}' diaginertia='{} {} {}'/>", z, mass, moment,
                       moment, moment);
  };
  EXPECT_THAT(Check(body(inertial(0.2, 2e-4))), IsEmpty());
  ExpectOne(true, "its mass of 2.9 kg", Check(body(inertial(2.9, 2e-3))));
  ExpectOne(true, "its mass of 0.004 kg", Check(body(inertial(0.004, 4e-6))));
  ExpectOne(true, "its inertia", Check(body(inertial(0.2, 2e-2))));
  ExpectOne(true, "its inertia", Check(body(inertial(0.2, 2e-6))));
  ExpectOne(true, "center of mass", Check(body(inertial(0.2, 2e-4, 0.051))));
}

TEST_F(CheckObjectTest, WhatStandsNowhereAndWhatNamesNoSurface) {
  // A box of 40 x 60 x 100 mm lies the firmest on its largest side: it tips over at atan(60 / 40).
  ObjectBounds firm;
  firm.min_tipping_rad = 1.0;
  ASSERT_THAT(Check(kSeen + kSolid), IsEmpty());
  ExpectOne(true, "rests nowhere", CheckObject({"odd", folder_ / "odd/odd.xml"}, firm));
  ExpectOne(false, "names no surface", Check(kSeen + kSolid, ""));
}

// Two boxes in one mesh, apart: its hull is full, the mesh is not.
TEST_F(CheckObjectTest, AMeshThatIsNotConvexIsSaid) {
  std::string text;
  for (const double x : {-0.04, 0.04}) {
    for (int corner = 0; corner < 8; ++corner) {
      text += fmt::format("v {} {} {}\n", x + ((corner & 1) ? 0.01 : -0.01),
                          (corner & 2) ? 0.02 : -0.02, (corner & 4) ? 0.02 : -0.02);
    }
  }
  for (const int first : {1, 9}) {
    const int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                              {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    for (const auto& f : faces) {
      text += fmt::format("f {} {} {}\n", first + f[0], first + f[1], first + f[2]);
    }
  }
  folder_.Write("odd/two.obj", text);
  ExpectOne(false, "is not convex",
            Check("<geom type='mesh' mesh='two' contype='0' conaffinity='0' group='2' mass='0'/>"
                  "<geom type='mesh' mesh='two' group='3' mass='0.05'/>",
                  kSurface + "<asset><mesh name='two' file='two.obj'/></asset>"));
}

TEST(Surfaces, AreFoundBesideTheObjectFirst) {
  const testing_support::TempFolder folder;
  const std::string pair =
      "  glove: {static: 0.9, from: 0.7, to: 1.2, kinetic: 0.8}\n"
      "  laminate: {static: 0.8, kinetic: 0.7}\n";
  const auto object = folder.Write("objects/duck/duck.xml", "<mujoco/>");
  EXPECT_EQ(SurfaceFiles(object).size(), 1U);
  EXPECT_EQ(FindSurface(SurfacesFor(object), "ceramic").glove.middle, 0.70);
  folder.Write("objects/surfaces.yaml", "rubber:\n" + pair + "ceramic:\n" + pair);
  EXPECT_EQ(FindSurface(SurfacesFor(object), "rubber").glove.high, 1.2);
  EXPECT_EQ(FindSurface(SurfacesFor(object), "ceramic").glove.middle, 0.9);
  EXPECT_EQ(FindSurface(SurfacesFor(object), "cardboard").glove.middle, 0.60);
}

}  // namespace
}  // namespace rangegrasp::sim
