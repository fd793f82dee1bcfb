#pragma once

#include <optional>
#include <string>
#include <vector>

#include "external/outside_detector.h"
#include "grasp/proposals.h"

/// Messages to and from an external detector: one JSON object per line
/// (docs/bring-your-own-detector.md).
namespace rangegrasp::external::internal {

/// Writes the files that the question refers to: the cloud, the open hand, and the pictures of each
/// view whose sensor takes pictures.
/// @return the question's line, without a newline
std::string WriteFiles(const Question& question, const std::filesystem::path& folder);

struct AnsweredObject {
  std::vector<geometry::SampleId> samples;  ///< measured samples; ascending, each once
  std::string surface;                      ///< file name; may be empty
};

struct AnsweredGrasp {
  std::size_t object = 0;
  grasp::Proposal proposal;
};

struct Answer {
  std::optional<std::vector<AnsweredObject>> objects;  ///< nullopt: not in the answer
  std::vector<AnsweredGrasp> grasps;                   ///< best first
};

/// @param observation  the observation that the samples belong to
/// @throws DetectorFailed naming the place in the answer, its value, and what is expected.
Answer ParseAnswer(const std::string& line, const geometry::Observation& observation);

}  // namespace rangegrasp::external::internal
