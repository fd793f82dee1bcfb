#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/finding.h"
#include "base/yaml_map.h"
#include "sim/model.h"
#include "trial/options.h"

namespace rangegrasp::trial {

/// Reads `object_folder` and `object_folders`: each holds NAME/NAME.xml for objects.
/// @throws base::InputError
std::vector<std::filesystem::path> ReadObjectFolders(base::YamlMap& map);

/// The rows' objects, and what else may lie there; each once, the rows' first.
std::vector<std::string> AllObjects(const Options& options);

/// The MJCF of one of the experiment's objects; where it would stand in the first folder if it is
/// in none.
sim::ObjectModel ObjectModelOf(const Options& options, const std::string& object);

/// Checks that every object is there. @throws base::InputError
void CheckObjects(const base::YamlMap& map, const Options& options);

/// What is wrong with the scene, its arm and its hand (sim/check/check.h), and with the objects.
std::vector<base::Finding> CheckModels(const Options& options);

/// A hash over the scene, the models that it and the objects refer to, and the sensor.
std::string SceneHash(const Options& options);

}  // namespace rangegrasp::trial
