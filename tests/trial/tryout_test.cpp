#include "trial/tryout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "base/file.h"
#include "hand_cell.h"
#include "sim/check/check.h"
#include "sim/check/findings.h"
#include "sim/check/fix.h"
#include "temp_folder.h"

namespace rangegrasp::trial {
namespace {

using testing::HasSubstr;

const std::filesystem::path kSource = RANGEGRASP_SOURCE_DIR;

// The shipped arm with the shipped hand, as texts to break in one place.
struct Texts {
  std::string arm, hand, scene;
};

void Replace(std::string& text, const std::string& pattern, const std::string& by) {
  const std::string before = text;
  text = std::regex_replace(text, std::regex(pattern), by);
  EXPECT_NE(text, before) << pattern;
}

// Multiplies all numbers in the values that the pattern's only group matches.
void Scale(std::string& text, const std::string& pattern, double factor) {
  std::string out;
  std::size_t last = 0;
  const std::regex wanted(pattern);
  for (std::sregex_iterator it(text.begin(), text.end(), wanted), end; it != end; ++it) {
    out += text.substr(last, it->position(1) - last);
    std::istringstream values((*it)[1].str());
    for (double value; values >> value;) out += std::to_string(factor * value) + " ";
    last = it->position(1) + it->length(1);
  }
  EXPECT_GT(last, 0u) << pattern;
  text = out + text.substr(last);
}

class Broken : public testing::Test {
 protected:
  Broken()
      : texts_{base::ReadFile(kSource / "models/arm/lwa3.xml"),
               base::ReadFile(kSource / "models/hand/sensorhand.xml"),
               base::ReadFile(kSource / "scenes/tabletop.xml")} {}

  std::filesystem::path Write() {
    Replace(texts_.arm, "\\.\\./hand/sensorhand\\.xml", "hand.xml");
    Replace(texts_.scene, "\\.\\./models/arm/lwa3\\.xml", "arm.xml");
    folder_.Write("arm.xml", texts_.arm);
    folder_.Write("hand.xml", texts_.hand);
    return folder_.Write("scene.xml", texts_.scene);
  }

  // Checks as the command does.
  std::string Check() {
    const auto scene = Write();
    auto findings = check::CheckModel(scene, check::Kind::kScene);
    if (!base::HasError(findings)) {
      tryout_ = TryCell(OptionsOf(scene));
      findings.insert(findings.end(), tryout_.findings.begin(), tryout_.findings.end());
    }
    return testing_support::TextOfAll(findings);
  }

  testing_support::TempFolder folder_;
  Texts texts_;
  Tryout tryout_;
};

TEST_F(Broken, NothingIsSaidOfTheShippedCell) {
  EXPECT_EQ(Check(), "");
  EXPECT_EQ(tryout_.delivered, tryout_.trials);
  EXPECT_EQ(tryout_.trials, 27);
}
TEST_F(Broken, WeakServosOfTheArm) {
  Scale(texts_.arm, "kp=\"([^\"]*)\"", 0.1);
  EXPECT_THAT(Check(), HasSubstr("kp"));
}
// If slower motions do not help, stiffer drives are tried.
TEST_F(Broken, DrivesThatFallBehindInTrialsAreCuredByTheEdits) {
  Scale(texts_.arm, "kp=\"([^\"]*)\"", 0.18);
  ASSERT_THAT(Check(), HasSubstr("lag up to"));
  check::Fixer fixer(folder_ / "scene.xml", /*in_place=*/false);
  for (int round = 0; round < 3 && fixer.Apply(tryout_.findings); ++round) {
    tryout_ = TryCell(OptionsOf(fixer.file()));
  }
  EXPECT_EQ(tryout_.findings.size(), 0u) << base::TextOf(tryout_.findings.front());
  EXPECT_EQ(base::ReadFile(folder_ / "arm.xml"), texts_.arm);
}
TEST_F(Broken, NoArmature) {
  Replace(texts_.arm, " armature=\"[^\"]*\"", "");
  EXPECT_THAT(Check(), HasSubstr("armature"));
}
TEST_F(Broken, MissingGripSensors) {
  Replace(texts_.hand, "<tuple name=\"grip_sensors\">[^]*?</tuple>", "");
  EXPECT_THAT(Check(), HasSubstr("grip_sensors"));
}
// Applies the edits to a typical third-party hand.
TEST(TryCell, AFourFingeredHandDeliversAfterTheEdits) {
  const testing_support::TempFolder folder;
  const std::string hand = base::ReadFile(kSource / "tests/data/hands/four_fingers.xml");
  testing_support::WriteHandCell(folder, hand);
  for (const auto& [file, kind] :
       {std::pair("hand.xml", check::Kind::kHand), std::pair("scene.xml", check::Kind::kScene)}) {
    check::Fixer fixer(folder / file, /*in_place=*/true);
    fixer.Run(check::CheckModel(folder / file, kind),
              [&] { return check::CheckModel(folder / file, kind); });
    std::filesystem::remove(folder / "hand.xml.bak");
  }
  const Tryout tryout = TryCell(OptionsOf(folder / "scene.xml"));
  EXPECT_EQ(tryout.trials, 27);
  EXPECT_GE(tryout.delivered, 20);  // 23
  // Some contacts creep, fewer with more iterations, which were tried.
  const auto creeps = std::ranges::find_if(tryout.findings, [](const base::Finding& finding) {
    return finding.what.find("creep") != std::string::npos;
  });
  ASSERT_NE(creeps, tryout.findings.end());
  EXPECT_THAT(base::CureOf(*creeps), HasSubstr("noslip_iterations=\"30\" in"));
  EXPECT_THAT(base::CureOf(*creeps), HasSubstr("(tried: "));
}
TEST_F(Broken, AWallThatIsSeenButHasNoKnownShape) {
  Replace(texts_.scene, "<worldbody>",
          "<worldbody><geom group=\"2\" contype=\"0\" conaffinity=\"0\" type=\"box\" pos=\"0 -0.19 "
          "0.1\" size=\"0.3 0.01 0.1\"/>");
  EXPECT_THAT(Check(), HasSubstr("is mistaken for an object"));
}
TEST_F(Broken, AWallOfKnownShapeIsNoObject) {
  Replace(texts_.scene, "<worldbody>",
          "<worldbody><geom group=\"2\" type=\"box\" pos=\"0 -0.19 0.1\" size=\"0.3 0.01 0.1\"/>");
  EXPECT_EQ(Check(), "");
}

}  // namespace
}  // namespace rangegrasp::trial
