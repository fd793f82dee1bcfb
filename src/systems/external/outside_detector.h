#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/yaml_map.h"
#include "grasp/detector.h"

namespace rangegrasp::external {

/// Options of an external detector program; empty command: no such detector.
struct OutsideOptions {
  std::vector<std::string> command;          ///< the program's file and its arguments
  std::vector<std::filesystem::path> files;  ///< files and folders named in the command
  double limit_s = 20.0;
  bool sandbox = false;
  int memory_mb = 4096;
  int file_mb = 256;
  std::vector<std::filesystem::path> hidden;  ///< folders of results, hidden in a sandbox
};

/// Reads the keys below `detector`, to the end of the map. Words of the command that name a file
/// relative to the experiment's folder are replaced by its path; the program is searched in PATH.
/// @throws base::InputError also if the program does not exist.
void ReadOutside(base::YamlMap map, OutsideOptions& options);

/// A detector that is another program (docs/bring-your-own-detector.md). Each question starts it in
/// a new folder and ends it after its answer, so that results do not depend on the number of
/// workers. All arguments except `outside` must outlive it.
/// @param observer  gets the answer as a scene, with the table and the points above it; may be
///                  empty
std::unique_ptr<grasp::Detector> MakeOutsideDetector(const OutsideOptions& outside,
                                                     const grasp::DetectorOptions& options,
                                                     const robot::Robot& robot,
                                                     grasp::SceneObserver observer = {});

struct Question {
  const geometry::Observation& observation;
  const robot::Robot& robot;
  double noise_m = 0.0;    ///< of the points, measured on the table
  double margin_m = 0.0;   ///< points further outside the workspace are ignored
  std::uint64_t seed = 0;  ///< below 2^53, so that every language can represent it
};

/// Draws Question::seed: the first number that a trial draws for perception.
std::uint64_t DrawSeed(base::Rng& rng);

/// Returns the same JSON as a program. grasp::DetectorFailed is an outcome of the trial.
using AnswerFunction = std::function<std::string(const Question&)>;

/// A detector that is a function of this process. All arguments except `answer` must outlive it.
/// @param observer  as above
std::unique_ptr<grasp::Detector> MakeFunctionDetector(AnswerFunction answer,
                                                      const grasp::DetectorOptions& options,
                                                      const robot::Robot& robot,
                                                      grasp::SceneObserver observer = {});

}  // namespace rangegrasp::external
