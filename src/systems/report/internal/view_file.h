#pragma once

#include <filesystem>

#include "experiment/view.h"

namespace rangegrasp::report {

/// Writes what the page loads when a case is looked at: `views/<number>.js`, a small picture
/// `views/<number>.png`, and each mesh that moves once for all cases, as `meshes/<hash>.js`.
/// Processes may write views of one report at the same time.
/// @throws base::RunError naming a file that cannot be written.
void WriteView(const experiment::View& view, const std::filesystem::path& folder,
               std::size_t number);

}  // namespace rangegrasp::report
