// Hands that declare how they close: one edit of a good file causes each finding and no other.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hand_cell.h"
#include "labelled_cloud.h"
#include "sim/check/check.h"
#include "sim/check/findings.h"

namespace rangegrasp::check {
namespace {

using ::testing::HasSubstr;
using testing_support::ExampleHand;
using testing_support::TempFolder;

class OwnHand : public ::testing::Test {
 protected:
  void Replace(const std::string& from, const std::string& to) {
    const auto at = hand_.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    hand_.replace(at, from.size(), to);
  }
  void Cut(const std::string& from, const std::string& to) {
    const auto at = hand_.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    hand_.erase(at, hand_.find(to, at) + to.size() - at);
  }
  std::vector<base::Finding> Check() {
    base::WriteFile(folder_ / "hand.xml", hand_);
    return CheckModel(folder_ / "hand.xml", Kind::kHand);
  }
  std::string All() { return testing_support::TextOfAll(Check()); }
  void ExpectOne(const std::vector<std::string>& words, bool error = true) {
    testing_support::ExpectOneFinding(Check(), words, error);
  }

  TempFolder folder_;
  std::string hand_ = ExampleHand("parallel_jaw");
};

TEST_F(OwnHand, ExamplesHaveNoFinding) {
  EXPECT_EQ(All(), "");
  base::WriteFile(folder_ / "hand.xml", hand_);
  EXPECT_EQ(KindOf(folder_ / "hand.xml"), Kind::kHand);
  hand_ = ExampleHand("three_fingers");
  EXPECT_EQ(All(), "");
}

TEST_F(OwnHand, TheExamplesOnTheShippedArmHaveNoFinding) {
  for (const char* name : {"parallel_jaw", "three_fingers"}) {
    const auto scene = testing_support::WriteHandCell(folder_, ExampleHand(name));
    for (const auto& finding : CheckModel(scene, Kind::kScene)) {
      ADD_FAILURE() << name << ": " << base::TextOf(finding);
    }
  }
}

// Names.

TEST_F(OwnHand, PrintsTheMissingDriveReadyToPaste) {
  Cut("<tuple name=\"hand_motors\">", "</tuple>");
  EXPECT_THAT(All(), HasSubstr("<element objtype=\"actuator\" objname=\"jaw_drive\"/>"));
}
// The limit with the larger distance between the pads is the open one.
TEST_F(OwnHand, PrintsBothEndsReadyToPaste) {
  Cut("<numeric name=\"hand_open\"", "/>");
  ExpectOne({"hand.xml: error", "numeric \"hand_open\"", "missing", "data=\"0.05\""});
  Cut("<numeric name=\"hand_closed\"", "/>");
  EXPECT_THAT(All(), HasSubstr("<numeric name=\"hand_closed\" data=\"0\"/>"));
}
// Also before the file names its parts.
TEST_F(OwnHand, PrintsBothEndsOfAFileWithoutNames) {
  for (const char* tuple : {"hand_motors", "fingertips"}) {
    Cut("<tuple name=\"" + std::string(tuple) + "\">", "</tuple>");
  }
  Cut("<numeric name=\"hand_open\"", "/>");
  Cut("<numeric name=\"hand_closed\"", "/>");
  const auto has_both = testing::AllOf(HasSubstr("<numeric name=\"hand_open\" data=\"0.05\"/>"),
                                       HasSubstr("<numeric name=\"hand_closed\" data=\"0\"/>"));
  EXPECT_THAT(All(), has_both);
  Replace("<body name=\"hand\"", "<body name=\"gripper\"");
  Replace("<exclude body1=\"hand\"", "<exclude body1=\"gripper\"");
  Replace("<exclude body1=\"hand\"", "<exclude body1=\"gripper\"");
  EXPECT_THAT(All(), has_both);
}
TEST_F(OwnHand, PrintsTheMissingFingertips) {
  Cut("<tuple name=\"fingertips\">", "</tuple>");
  EXPECT_THAT(All(), HasSubstr("objname=\"thumb_pad\""));
  EXPECT_THAT(All(), HasSubstr("objname=\"finger_pad\""));
}
TEST_F(OwnHand, PrintsTheToolCentre) {
  Cut("<site name=\"tcp\"", "/>");
  ExpectOne(
      {"site \"tcp\"", "missing", "<site name=\"tcp\" pos=\"0 0 0.13\" xyaxes=\"1 0 0 0 1 0\""});
}
TEST_F(OwnHand, SaysThatThereIsNoForce) {
  Cut("<numeric name=\"grip_force\"", "/>");
  ExpectOne({"numeric \"grip_force\"", "missing"});
}
TEST_F(OwnHand, AsksForTheNameOfTheRootBody) {
  Replace("<body name=\"hand\"", "<body name=\"gripper\"");
  Replace("<exclude body1=\"hand\"", "<exclude body1=\"gripper\"");
  Replace("<exclude body1=\"hand\"", "<exclude body1=\"gripper\"");
  ExpectOne({"body \"hand\"", "name=\"hand\" in <body name=\"gripper\">"});
}
TEST_F(OwnHand, AValueForEachDrive) {
  Replace("name=\"hand_closed\" data=\"0\"", "name=\"hand_closed\" data=\"0 0\"");
  ExpectOne({"numeric \"hand_closed\"", "must have 1 numbers, it has 2"});
}

// Findings from closing the hand.

TEST_F(OwnHand, SaysThatAFingertipIsNotMoved) {
  Replace("<element objtype=\"geom\" objname=\"finger_pad\"/>",
          "<element objtype=\"geom\" objname=\"finger_pad\"/><element objtype=\"geom\" "
          "objname=\"housing\"/>");
  EXPECT_THAT(All(), HasSubstr("geom \"housing\": is a fingertip that moves by 0.0 mm"));
}
TEST_F(OwnHand, SaysThatPadsNeverMeet) {
  Replace("name=\"hand_closed\" data=\"0\"", "name=\"hand_closed\" data=\"0.01\"");
  ExpectOne({"never meet", "stay 20.0 mm apart"}, false);
}
TEST_F(OwnHand, SaysThatOpenAndClosedAreSwapped) {
  Replace("name=\"hand_open\" data=\"0.05\"", "name=\"hand_open\" data=\"0.0\"");
  Replace("name=\"hand_closed\" data=\"0\"", "name=\"hand_closed\" data=\"0.05\"");
  ExpectOne({"move apart while the hand closes", "data=\"0.05\" in <numeric name=\"hand_open\">",
             "data=\"0\" in <numeric name=\"hand_closed\">"});
}
TEST_F(OwnHand, ClosesAgainstTheDampingOfItsJoints) {
  Replace("damping=\"20\"", "damping=\"2000\"");
  EXPECT_EQ(All(), "");
}
TEST_F(OwnHand, SaysThatADriveStopsShort) {
  Replace("name=\"hand_open\" data=\"0.05\"", "name=\"hand_open\" data=\"0.045\"");
  Replace("name=\"hand_closed\" data=\"0\"", "name=\"hand_closed\" data=\"-0.02\"");
  ExpectOne({"actuator \"jaw_drive\"",
             "short of \"hand_closed\": stopped by the end of the range of joint "});
}
// Both slides move in the same direction: the soft coupling works against the drive of the other
// jaw.
TEST_F(OwnHand, SaysThatAnEqualityDoesNotHold) {
  Replace("polycoef=\"0 1 0 0 0\" solref=\"0.005 1\" solimp=\"0.999 0.9999 0.001 0.5 2\"",
          "polycoef=\"0.08 -1 0 0 0\" solref=\"0.005 1\" solimp=\"0.99 0.999 0.001 0.5 2\"");
  EXPECT_THAT(All(), HasSubstr("does not hold while the empty hand closes"));
}
TEST_F(OwnHand, SaysThatTheDriveIsTooWeak) {
  Replace("forcerange=\"-200 200\"", "forcerange=\"-60 60\"");
  ExpectOne(
      {"actuator \"jaw_drive\"", "gives 30 N", "data=\"30 30\" in <numeric name=\"grip_force\">"});
}
// 70 N of 70 N, up to the rounding of a file and a solver.
TEST_F(OwnHand, ADriveThatGivesTheForceButForRoundingIsStrongEnough) {
  Replace("forcerange=\"-200 200\"", "forcerange=\"-139.99 139.99\"");
  Replace("name=\"grip_force\" data=\"40 80\"", "name=\"grip_force\" data=\"40 70\"");
  EXPECT_EQ(All(), "");
}
TEST_F(OwnHand, SaysThatTheToolCentreLooksTheWrongWay) {
  Replace("<site name=\"tcp\" pos=\"0 0 0.130\"",
          "<site name=\"tcp\" pos=\"0 0 0.130\" xyaxes=\"-1 0 0 0 -1 0\"");
  ExpectOne({"site \"tcp\"", "from the thumb's pads to the fingers'", "xyaxes=\"1 0 0 0 1 0\""});
}
TEST_F(OwnHand, SaysThatThereAreNoTwoSides) {
  Replace("objname=\"finger_pad\"", "objname=\"thumb_plate\"");
  ExpectOne({"tuple \"fingertips\"", "two sides"});
}
TEST_F(OwnHand, SaysThatFingertipsAreSoft) {
  Replace("condim=\"4\" friction=\"0.5 0.005 0.0001\" solref=\"0.005 1\"",
          "condim=\"4\" friction=\"0.5 0.005 0.0001\" solref=\"0.02 1\"");
  EXPECT_THAT(All(), HasSubstr("soft"));
}
TEST_F(OwnHand, SaysThatADriveIsOfAnotherKind) {
  Replace("<position name=\"jaw_drive\" joint=\"thumb_jaw\" kp=\"5000\" dampratio=\"1\"",
          "<general name=\"jaw_drive\" joint=\"thumb_jaw\" dyntype=\"filter\" dynprm=\"0.1\"");
  EXPECT_THAT(All(), HasSubstr("neither a <position> servo nor a <motor>"));
}

// For third-party hands, everything that is missing is reported at once.
class ForeignHand : public ::testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(ForeignHand, IsToldWhatItLacks) {
  const auto file = labelled::SharedFolder() / "data/robots" / GetParam().first;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  ASSERT_EQ(KindOf(file), Kind::kHand);
  const std::string text = testing_support::TextOfAll(CheckModel(file, Kind::kHand));
  EXPECT_THAT(text, HasSubstr("body \"hand\": is missing"));
  for (const char* what : {GetParam().second, "tuple \"hand_motors\"", "tuple \"fingertips\"",
                           "numeric \"hand_open\"", "numeric \"grip_force\"", "site \"tcp\""}) {
    EXPECT_THAT(text, HasSubstr(what));
  }
}
INSTANTIATE_TEST_SUITE_P(
    Menagerie, ForeignHand,
    ::testing::Values(std::pair("robotiq_2f85/2f85.xml", "in <body name=\"base_mount\">"),
                      std::pair("wonik_allegro/right_hand.xml", "in <body name=\"palm\">")),
    [](const auto& tested) { return std::string(tested.index == 0 ? "robotiq" : "allegro"); });

}  // namespace
}  // namespace rangegrasp::check
