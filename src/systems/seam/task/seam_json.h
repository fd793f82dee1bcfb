#pragma once

#include <optional>
#include <string>

#include "experiment/task.h"
#include "seam/task/seam_score.h"

/// Cases and results of seam experiments as the store keeps them: JSON objects whose numbers are
/// read back the same.
namespace rangegrasp::seam_task {

/// What a case is. A seam of rates has no method and no hazard.
struct SeamParams {
  int number = 0;  ///< of the seam or run, from 0
  stitching::EdgeShape shape = stitching::EdgeShape::kStep;
  std::optional<seam::DecisionMethod> method;
  Hazard hazard = Hazard::kNone;
};

/// {"seam", "shape"} or {"run", "shape", "method", "hazard"}.
std::string ToJson(const SeamParams& params);
/// @throws base::RunError if the text is no such object.
SeamParams ParamsFrom(const std::string& json);

/// Without what the case itself tells (number, shape).
std::string ToJson(const SeamResult& result);
std::string ToJson(const RunResult& result);
/// @throws base::RunError if the text is no such result.
SeamResult SeamResultFrom(const SeamParams& params, const std::string& json);
RunResult RunResultFrom(const SeamParams& params, const std::string& json);

}  // namespace rangegrasp::seam_task
