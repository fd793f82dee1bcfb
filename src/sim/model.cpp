#include "sim/model.h"

#include "sim/internal/scene_builder.h"

namespace rangegrasp::sim {

std::shared_ptr<mjModel_> CompileModel(const std::filesystem::path& mjcf,
                                       std::vector<std::string>& warnings) {
  internal::BuiltScene built = internal::BuildScene(mjcf, {}, {});
  warnings.insert(warnings.end(), built.warnings.begin(), built.warnings.end());
  return {built.model.release(), internal::ModelDeleter()};
}

}  // namespace rangegrasp::sim
