// The scanner head on the wrist in scenes/tabletop_wrist.xml.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "base/file.h"
#include "base/units.h"
#include "robot/collision/collider.h"
#include "robot/robot.h"

namespace rangegrasp::views {
namespace {

const robot::Robot& WristHeadWrist() {
  static const auto robot = robot::Robot::Load(RANGEGRASP_SOURCE_DIR "/scenes/tabletop_wrist.xml");
  return robot;
}

std::vector<geometry::Shape> HeadShapes() {
  std::vector<geometry::Shape> shapes;
  for (const geometry::Shape& shape : WristHeadWrist().links().back().shapes) {
    if (shape.kind == geometry::Shape::Kind::kBox) shapes.push_back(shape);
  }
  return shapes;
}

TEST(WristHead, KeepsFiveMillimetresClearOfTheHandFromOpenToClosed) {
  const auto heads = HeadShapes();
  ASSERT_EQ(heads.size(), 2u);  // the bracket and the head
  for (const auto& state : WristHeadWrist().hand().states) {
    for (const geometry::Shape& of_hand : state.shapes) {
      const collision::Solid hand(of_hand);
      for (const geometry::Shape& of_head : heads) {
        const collision::Solid head(of_head, {.margin_m = 0.005});
        EXPECT_FALSE(collision::Hit(collision::Place(head, base::Pose::Identity()),
                                    collision::Place(hand, WristHeadWrist().X_FH)))
            << "gap " << state.gap_m;
      }
    }
  }
}

// From models/sensors/wrist_scanner.yaml: 40 deg of pan, 36 deg of fan.
TEST(WristHead, DoesNotSeeTheFingers) {
  const base::Pose X_SH = WristHeadWrist().X_HWristScanner->inverse();
  for (const auto& state : WristHeadWrist().hand().states) {
    for (const Eigen::Vector3d& pad_H : {state.thumb_pad_H, state.finger_pad_H}) {
      const Eigen::Vector3d p = X_SH * pad_H;
      EXPECT_TRUE(std::abs(std::atan2(p.x(), p.z())) > base::Deg(20.0) ||
                  std::abs(std::atan2(p.y(), p.z())) > base::Deg(18.0))
          << p.transpose();
    }
  }
}

// lwa3_scanner.xml repeats all lines of lwa3.xml in order, except for those named here.
TEST(WristHead, HasTheSameArmAsTheSceneWithoutIt) {
  const auto lines = [](const char* name) {
    std::istringstream text(
        base::ReadFile(std::string(RANGEGRASP_SOURCE_DIR "/models/arm/") + name));
    std::vector<std::string> out;
    for (std::string line; std::getline(text, line);) out.push_back(line);
    return out;
  };
  const auto plain = lines("lwa3.xml");
  const auto with_head = lines("lwa3_scanner.xml");
  std::vector<std::string> missing;
  std::size_t at = 0;
  for (const std::string& line : plain) {
    const auto found =
        std::find(with_head.begin() + static_cast<std::ptrdiff_t>(at), with_head.end(), line);
    if (found == with_head.end()) {
      missing.push_back(line);
    } else {
      at = static_cast<std::size_t>(found - with_head.begin()) + 1;
    }
  }
  ASSERT_EQ(missing.size(), 3u);
  EXPECT_NE(missing[0].find("AMTEC"), std::string::npos);  // the comment's first line
  EXPECT_NE(missing[1].find("model=\"lwa3\""), std::string::npos);
  EXPECT_NE(missing[2].find("exclude body1=\"link5\" body2=\"link7\""), std::string::npos);
}

}  // namespace
}  // namespace rangegrasp::views
