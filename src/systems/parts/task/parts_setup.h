#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/yaml_map.h"
#include "experiment/task.h"
#include "parts/method.h"

namespace rangegrasp::parts {

/// Parameters are tuned on the models of one split only; the other is held out.
enum class Split { kTune, kReport };
constexpr std::array<std::string_view, 2> WordsOf(Split) { return {"tune", "report"}; }

/// How a cloud is sampled from a mesh.
struct CloudGrade {
  int points = 0;
  /// Standard deviation of each coordinate, in percent of the diagonal of the mesh's bounding box.
  double noise_percent = 0.0;

  bool operator==(const CloudGrade&) const = default;
};

/// A class of models of the benchmark.
struct ModelClass {
  std::string name;
  std::vector<int> tune;    ///< ids
  std::vector<int> report;  ///< ids; no id stands twice
  /// For k-means: mean number of segments that people made of all models that the file names; 0
  /// where it is not among the methods.
  int human_segments = 0;
};

/// An experiment file such as experiments/parts_psb.yaml.
struct PartsSetup {
  std::filesystem::path folder;
  std::vector<ModelClass> classes;
  std::vector<Method> methods;
  std::vector<CloudGrade> clouds;
  std::string published;  ///< table 6.1; or empty

  bool HasModels(Split split) const;
};

/// Reads the kind's keys to their end.
/// @throws base::InputError naming file, line and key; also where the folder holds no off/ and
/// seg/.
PartsSetup ReadPartsSetup(base::YamlMap& map);
/// The same keys, for the documentation.
void ReadPartsKeys(base::YamlMap& map);

/// Puts all but the folder into the stamp's data, and a hash of the models into its identity.
void AddTo(experiment::Stamp& stamp, const PartsSetup& setup);
/// What AddTo put there.
PartsSetup PartsSetupOf(const experiment::Stamp& stamp);

}  // namespace rangegrasp::parts
