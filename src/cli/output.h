#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "report/table.h"

namespace rangegrasp::cli {

/// Writes text to stdout, or whole to a file where one is named.
/// @throws core::RunError naming the target if it cannot be written whole.
void WriteResult(const std::string& text, const std::filesystem::path& file = {});

/// Makes the folder a file is to stand in. @throws core::InputError naming it if that is not
/// possible.
void MakeFolderOf(const std::filesystem::path& file);

/// "1280x960" -> {1280, 960}. @throws core::InputError.
std::pair<int, int> ParseSize(const std::string& text);

/// "text", "markdown", "csv" or "json" (checked by the option itself).
report::TableFormat ParseTableFormat(const std::string& name);

}  // namespace rangegrasp::cli
