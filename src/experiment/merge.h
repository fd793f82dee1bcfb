#pragma once

#include <filesystem>
#include <vector>

namespace rangegrasp::experiment {

struct Merged {
  std::size_t cases = 0;     ///< that were joined
  std::size_t expected = 0;  ///< that the experiment has
};

/// Joins the results of shards into a folder without results, all of them or nothing. Memory does
/// not grow with the number of cases. What is joined may be joined with more.
/// @param complete  whether to write nothing where cases are missing: see what is returned
/// @throws base::InputError naming the folder: it holds results already, a shard is of another run,
/// or a case is in two of them.
Merged Merge(const std::vector<std::filesystem::path>& shards, const std::filesystem::path& out,
             bool complete = false);

}  // namespace rangegrasp::experiment
