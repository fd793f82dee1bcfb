// What `recognize` tells of a scan of known objects, with colors and without.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "cli/command.h"
#include "temp_folder.h"

namespace rangegrasp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing_support::RunProgram;

const fs::path kRepository = RANGEGRASP_SOURCE_DIR;

class RecognizeTest : public testing::Test {
 protected:
  /// A box of dextrose alone on the table.
  std::string Scan(bool color) const {
    const auto file = folder_ / (color ? "colored.yaml" : "plain.yaml");
    base::WriteFile(
        file, "name: scan\ntask: grasping\nscene: " + Path("scenes/tabletop.xml") +
                  "\narrangement: single\nsensor: " + Path("models/sensors/line_scanner.yaml") +
                  "\nobject_folder: " + Path("models/objects") +
                  "\nobjects: [dextrose]\ncolor: " + (color ? "true" : "false") + "\n");
    const auto cloud = (folder_ / (color ? "colored.pcd" : "plain.pcd")).string();
    const auto ran = RunProgram({"scan", file.string(), "-o", cloud});
    EXPECT_EQ(ran.code, 0) << ran.err;
    return cloud;
  }

  static std::string Path(const std::string& in_repository) {
    return (kRepository / in_repository).string();
  }

  /// A package of the shape of the box, with the print of another one.
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

  static nlohmann::json Found(const std::string& cloud, const std::string& library) {
    const auto ran = RunProgram({"recognize", cloud, "--library", library, "--crop",
                                 "-0.3,-0.3,-0.05,0.3,0.3,0.4", "--json"});
    EXPECT_EQ(ran.code, 0) << ran.err;
    return nlohmann::json::parse(ran.out).at("found");
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

TEST_F(RecognizeTest, AFolderWithoutObjectsIsNamed) {
  fs::create_directories(folder_ / "empty");
  const auto ran =
      RunProgram({"recognize", Scan(false), "--library", (folder_ / "empty").string()});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("NAME/NAME.xml"));
}

}  // namespace
}  // namespace rangegrasp
