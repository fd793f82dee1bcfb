#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/yaml_map.h"
#include "experiment/task.h"
#include "parts/method.h"

namespace rangegrasp::parts {

/// Parameters are tuned on the models of one split; the other split is held out.
enum class Split { kTune, kReport };
constexpr std::array<std::string_view, 2> WordsOf(Split) { return {"tune", "report"}; }

/// How a cloud is sampled from a mesh.
struct CloudGrade {
  int points = 0;
  /// Standard deviation of each coordinate, in percent of the diagonal of the mesh's bounding box.
  double noise_percent = 0.0;

  bool operator==(const CloudGrade&) const = default;
};

/// A class of models in the benchmark.
struct ModelClass {
  std::string name;
  std::vector<int> tune;    ///< ids
  std::vector<int> report;  ///< ids; no id occurs twice
  /// For k-means: mean number of segments that people made, over all models in the file; 0 if
  /// k-means is not among the methods.
  int human_segments = 0;
};

/// Contents of an experiment file such as experiments/parts_psb.yaml.
struct PartsSetup {
  std::filesystem::path folder;
  std::vector<ModelClass> classes;
  std::vector<Method> methods;
  std::vector<CloudGrade> clouds;
  std::string published;  ///< text of table 6.1; or empty
};

/// Reads all keys of this kind of experiment.
/// @throws base::InputError naming file, line and key; also if the folder has no off/ or seg/.
PartsSetup ReadPartsSetup(base::YamlMap& map);
/// Reads the same keys for the documentation.
void ReadPartsKeys(base::YamlMap& map);

/// Writes all but the folder to the stamp's data, and a hash of the models to its identity.
void AddTo(experiment::Stamp& stamp, const PartsSetup& setup);
/// Reads back what AddTo wrote.
PartsSetup PartsSetupOf(const experiment::Stamp& stamp);

}  // namespace rangegrasp::parts
