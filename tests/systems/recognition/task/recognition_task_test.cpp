#include "recognition/task/recognition_task.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "error_of.h"
#include "experiment/experiment.h"
#include "geometry/mesh_file.h"
#include "perception/raster_scan.h"
#include "sim/bodies.h"
#include "temp_folder.h"

namespace rangegrasp::recognition {
namespace {

using testing::HasSubstr;

const std::string kExperiments = RANGEGRASP_SOURCE_DIR "/experiments/";

// Warnings for an experiment with one object.
std::string WarningsOf(const std::string& experiment, const std::vector<std::string>& set) {
  std::string text;
  experiment::OpenExperiment(kExperiments + experiment, {.set = set, .groups = {"dextrose"}},
                             [&](const std::vector<base::Finding>& findings) {
                               for (const auto& finding : findings)
                                 text += base::TextOf(finding) + "\n";
                               return false;
                             });
  return text;
}

TEST(RecognitionTask, AStereoCameraAloneIsWarnedOf) {
  const std::string stereo = "sensor=../models/sensors/stereo_camera.yaml";
  constexpr const char* kWarning = "a stereo camera alone found none";
  EXPECT_THAT(WarningsOf("known_single.yaml", {stereo, "views=1"}), HasSubstr(kWarning));
  EXPECT_THAT(WarningsOf("bring.yaml", {stereo, "bring.max_looks=1"}), HasSubstr(kWarning));
  EXPECT_EQ(WarningsOf("known_single.yaml", {stereo}), "");  // the wrist has a laser
  EXPECT_EQ(WarningsOf("known_single.yaml", {"views=1"}), "");
}

TEST(RecognitionTask, AMissingMeshIsNamed) {
  const testing_support::TempFolder folder;
  EXPECT_THAT(testing_support::ErrorOf([&] {
                experiment::OpenExperiment(
                    kExperiments + "known_single.yaml",
                    {.set = {"objects=[dextrose]", "library.folder=" + (folder / "").string()}});
              }),
              HasSubstr("dextrose.stl"));
}

std::string OutcomeWith(const std::vector<std::string>& library) {
  std::vector<std::string> set = {"objects=[dextrose]", "views=1"};
  set.insert(set.end(), library.begin(), library.end());
  const auto opened =
      experiment::OpenExperiment(kExperiments + "known_single.yaml", {.set = set, .seed = 1001});
  return opened.task->Run(opened.cases.front()).outcome;
}

TEST(RecognitionTask, TheLibraryMayComeFromMeshesInAFolder) {
  const testing_support::TempFolder folder;
  const std::string object = RANGEGRASP_SOURCE_DIR "/models/objects/dextrose/dextrose.xml";
  auto mesh = sim::ObjectSurface({"dextrose", object}).mesh;
  const std::string library = "library.folder=" + (folder / "").string();
  geometry::WriteStl(folder / "dextrose.stl", mesh);
  EXPECT_EQ(OutcomeWith({library}), "found");
  for (auto& p : mesh.vertices) p *= 1.3;  // another size: it must not be recognized
  geometry::WriteStl(folder / "dextrose.stl", mesh);
  EXPECT_NE(OutcomeWith({library}), "found");
}

TEST(RecognitionTask, TheLibraryMayBeAFolderOfObjects) {
  EXPECT_EQ(OutcomeWith({"library.folder=" RANGEGRASP_SOURCE_DIR "/models/objects"}), "found");
  const testing_support::TempFolder folder;
  const std::filesystem::path objects = RANGEGRASP_SOURCE_DIR "/models/objects";
  std::filesystem::create_directory(folder / "dextrose");  // another object under its name
  std::filesystem::copy(objects / "spread", folder / "dextrose");
  std::filesystem::rename(folder / "dextrose/spread.xml", folder / "dextrose/dextrose.xml");
  EXPECT_NE(OutcomeWith({"library.folder=" + (folder / "").string()}), "found");
}

TEST(RecognitionTask, ALibraryMayBeOfMeshes) {
  const testing_support::TempFolder folder;
  const std::string object = RANGEGRASP_SOURCE_DIR "/models/objects/dextrose/dextrose.xml";
  const auto mesh = sim::ObjectSurface({"dextrose", object}).mesh;
  geometry::WriteStl(folder / "box.v2.stl", mesh);
  std::filesystem::create_directory(folder / "not an object");
  const auto library = LoadLibrary(folder.path());
  EXPECT_EQ(library.Find("box.v2").mesh_B.triangles.size(), mesh.triangles.size());
  EXPECT_EQ(library.Find("box.v2").title, "box.v2");
}

TEST(RecognitionTask, AMeshInMillimetresIsRefused) {
  const testing_support::TempFolder folder;
  const auto file = folder / "dextrose.stl";
  geometry::WriteStl(file, synthetic::BoxMesh(50.0, 1e-3, 1e-3));
  const auto error = testing_support::ErrorOf([&] { LoadLibrary(folder.path()); });
  EXPECT_THAT(error, HasSubstr(file.string() + ": is 50 m long"));
  EXPECT_THAT(error, HasSubstr("`rangegrasp add-object " + file.string() + " --unit mm`"));
  EXPECT_THAT(
      testing_support::ErrorOf([&] { OutcomeWith({"library.folder=" + folder.path().string()}); }),
      HasSubstr(": is 50 m long"));
}

TEST(RecognitionTask, AModelThatIsFarOffFindsNothing) {
  EXPECT_EQ(OutcomeWith({}), "found");
  EXPECT_EQ(OutcomeWith({"library.distortion_mm=15"}), "unknown");
}

}  // namespace
}  // namespace rangegrasp::recognition
