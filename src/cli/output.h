#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "experiment/format.h"

namespace CLI {
class App;
}

namespace rangegrasp::cli {

/// Writes text to stdout, or whole to a file where one is named.
/// @throws base::RunError naming the target if it cannot be written whole.
void WriteResult(const std::string& text, const std::filesystem::path& file = {});

/// Tables and lists to stdout: with colors where it is a terminal that shows them, as they are
/// otherwise. @throws as WriteResult.
void WriteTables(const std::string& text);
/// The same of a report; only as text it has colors.
void WriteTables(const experiment::Report& report, const experiment::Stamp& stamp,
                 experiment::TableFormat format);

/// Before anything is computed for a file to be written.
/// @param endings  what the command can write, e.g. {".pcd", ".ply"}
/// @throws base::InputError naming the file and the endings.
void CheckEnding(const std::filesystem::path& file, const std::vector<std::string>& endings);

/// "1280x960" -> {1280, 960}. @throws base::InputError.
std::pair<int, int> ParseSize(const std::string& text);

/// Adds `--format text|markdown|csv|json`, and `--json` for the last; `format` must live as long as
/// the command.
void AddFormatOption(CLI::App& command, std::string& format);
/// Of what that option took.
experiment::TableFormat TableFormatFrom(const std::string& word);

}  // namespace rangegrasp::cli
