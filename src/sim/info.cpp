#include "sim/info.h"

#include <mujoco/mujoco.h>

#include "base/error.h"
#include "sim/internal/engine.h"

namespace rangegrasp::sim {

std::string EngineVersion() { return mj_versionString(); }

std::string ObjectTitle(const ObjectModel& object) {
  char error[1000] = "";
  const internal::SpecPtr spec(
      mj_parseXML(object.mjcf.c_str(), nullptr, error, static_cast<int>(sizeof(error))));
  if (!spec) {
    throw base::InputError(object.mjcf.string() + ": no MJCF that can be read: " + error);
  }
  mjsElement* title = mjs_findElement(spec.get(), mjOBJ_TEXT, "title");
  return title ? mjs_getString(mjs_asText(title)->data) : object.name;
}

}  // namespace rangegrasp::sim
