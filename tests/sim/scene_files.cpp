#include "sim/scene_files.h"

#include "base/units.h"
#include "temp_folder.h"

namespace rangegrasp::sim::samples {

std::filesystem::path WriteFile(const std::string& name, const std::string& text) {
  // One folder per process, since tests of one binary run in parallel.
  static const testing_support::TempFolder folder;
  return folder.Write(name, text);
}

std::filesystem::path PlaneScene(double tilt_rad) {
  return WriteFile(
      "plane.xml",
      R"(<mujoco><option timestep="0.002" integrator="implicitfast" cone="elliptic" impratio="10"
  noslip_iterations="10"><flag sleep="enable"/></option><worldbody><body name="table">
  <geom type="plane" size="0 0 1" condim="6" friction="0.2 0.005 0.002" euler="0 )" +
          std::to_string(base::ToDeg(tilt_rad)) + R"( 0"/></body></worldbody></mujoco>)");
}

ObjectModel MakeObject(const std::string& name, const std::string& geoms) {
  const std::string file = WriteFile(
      name + ".xml",
      R"(<mujoco><custom><text name="surface" data="cardboard"/><numeric name="albedo" data="0.65"/>
  <numeric name="gloss" data="0.2"/></custom>
  <default><geom condim="6" friction="0.25 0.003 0.002" solref="0.005 1" solimp="0.95 0.99 0.001 0.5 2"/></default>
  <worldbody><body name=")" +
          name + R"("><freejoint/>)" + geoms + "</body></worldbody></mujoco>");
  return {name, file};
}

ObjectModel RepositoryObject(const std::string& name) {
  const std::filesystem::path root(RANGEGRASP_SOURCE_DIR);
  return {name, root / "models" / "objects" / name / (name + ".xml")};
}

std::filesystem::path Tabletop() {
  return std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "scenes" / "tabletop.xml";
}

}  // namespace rangegrasp::sim::samples
