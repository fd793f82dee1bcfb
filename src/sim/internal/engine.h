#pragma once

#include <mujoco/mujoco.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace rangegrasp::sim::internal {

struct SpecDeleter {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
};
struct ModelDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
struct DataDeleter {
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using SpecPtr = std::unique_ptr<mjSpec, SpecDeleter>;
using ModelPtr = std::unique_ptr<mjModel, ModelDeleter>;
using DataPtr = std::unique_ptr<mjData, DataDeleter>;

/// Runs engine code with its log going to us: warnings are appended to `warnings` (may be null), an
/// engine error ends the call and becomes a base::RunError with the engine's text. The engine asks
/// error handlers to longjmp: `call` must not own anything that needs a destructor while the engine
/// runs, and after an error the mjData concerned must only be deleted.
void CallEngine(std::vector<std::string>* warnings, const std::function<void()>& call);

}  // namespace rangegrasp::sim::internal
