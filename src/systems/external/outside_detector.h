#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/yaml_map.h"
#include "grasp/detector.h"

namespace rangegrasp::external {

/// A detector that is another program; empty command: there is none.
struct OutsideOptions {
  std::vector<std::string> command;          ///< the program's file, and its arguments
  std::vector<std::filesystem::path> files;  ///< those and folders that the command names as such
  double limit_s = 20.0;
  bool sandbox = false;
  int memory_mb = 4096;
  int file_mb = 256;
  std::vector<std::filesystem::path> hidden;  ///< from a program in a sandbox: results lie there
};

/// Under this name they stand in trial::Options.
inline constexpr const char* kExternal = "external";

/// Reads the keys below `detector`, to the end of the map: words of the command that name a file
/// from the experiment's folder become its path, the program's name is looked for in PATH.
/// @throws base::InputError also if the program is not there.
void ReadOutside(base::YamlMap map, OutsideOptions& options);

/// A detector that is another program (docs/bring-your-own-detector.md). Each question starts it in
/// a new folder and ends it after its answer: results do not depend on the number of workers. The
/// arguments but `outside` must outlive it.
/// @param observer  sees the answer as a scene, with the table and what lies above it; may be empty
std::unique_ptr<grasp::Detector> MakeOutsideDetector(const OutsideOptions& outside,
                                                     const grasp::DetectorOptions& options,
                                                     const robot::Robot& robot,
                                                     grasp::SceneObserver observer = {});

/// What a detector is asked about one scan.
struct Question {
  const geometry::Observation& observation;
  const robot::Robot& robot;
  double noise_m = 0.0;    ///< of the points, measured on the table
  double margin_m = 0.0;   ///< round the workspace in which things are perceived
  std::uint64_t seed = 0;  ///< below 2^53, so that every language can hold it
};

/// Answers by the same JSON as a program. What it throws as grasp::DetectorFailed is an outcome.
using AnswerFunction = std::function<std::string(const Question&)>;

/// A detector that is a function of this process. The arguments but `answer` must outlive it.
/// @param observer  as above
std::unique_ptr<grasp::Detector> MakeFunctionDetector(AnswerFunction answer,
                                                      const grasp::DetectorOptions& options,
                                                      const robot::Robot& robot,
                                                      grasp::SceneObserver observer = {});

}  // namespace rangegrasp::external
