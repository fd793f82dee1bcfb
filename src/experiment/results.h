#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiment/record.h"
#include "experiment/stamp.h"

namespace rangegrasp::experiment {

/// What a run left, or several that differ in nothing but their seeds.
struct Results {
  Stamp stamp;  ///< of several: the first's, with all seeds and the sum of the cases
  std::vector<Record> records;
};

/// Where a run with several seeds keeps the one of a seed: "<folder>/seed-<seed>".
std::filesystem::path SeedFolder(const std::filesystem::path& folder, std::uint64_t seed);

/// The stores of a results folder: itself, or those of its seeds in ascending order.
/// @throws base::InputError if it holds neither.
std::vector<std::filesystem::path> StoresIn(const std::filesystem::path& folder);

/// All that a results folder holds. @throws base::InputError also if its seeds' runs are not of the
/// same experiment.
Results ReadResults(const std::filesystem::path& folder);

}  // namespace rangegrasp::experiment
