#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "experiment/format.h"

namespace CLI {
class App;
}

namespace rangegrasp::cli {

/// Writes text to stdout, or whole to a file where one is named.
/// @throws core::RunError naming the target if it cannot be written whole.
void WriteResult(const std::string& text, const std::filesystem::path& file = {});

/// "1280x960" -> {1280, 960}. @throws core::InputError.
std::pair<int, int> ParseSize(const std::string& text);

/// Adds `--format text|markdown|csv|json`, and `--json` for the last; `format` must live as long as
/// the command.
void AddFormatOption(CLI::App& command, std::string& format);
/// Of what that option took.
experiment::TableFormat TableFormatFrom(const std::string& word);

}  // namespace rangegrasp::cli
