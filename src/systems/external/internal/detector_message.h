#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "external/outside_detector.h"
#include "grasp/proposals.h"

/// What goes to a detector from outside and comes back from it: one JSON object a line
/// (docs/bring-your-own-detector.md).
namespace rangegrasp::external::internal {

/// Names of the files in its folder.
constexpr const char* kCloudFile = "obs.pcd";
constexpr const char* kHandFile = "hand.stl";

/// Writes what the line names: the cloud, the open hand, and each view's pictures, where its sensor
/// takes some.
/// @return the line, without its end
std::string WriteFiles(const Question& question, const std::filesystem::path& folder);

struct AnsweredObject {
  std::vector<geometry::SampleId> samples;  ///< that were measured; ascending, each once
  std::string surface;                      ///< name of a file; may be empty
};

struct AnsweredGrasp {
  std::size_t object = 0;
  grasp::Proposal proposal;
};

struct Answer {
  std::optional<std::vector<AnsweredObject>> objects;  ///< nullopt: left out
  std::vector<AnsweredGrasp> grasps;                   ///< best first
};

/// @param observation  what the samples are of
/// @throws DetectorFailed naming the place in the answer, the value, and what would be right.
Answer ParseAnswer(const std::string& line, const geometry::Observation& observation);

}  // namespace rangegrasp::external::internal
