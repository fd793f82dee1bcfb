#include "cli/output.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"
#include "cli/terminal_text.h"

namespace rangegrasp::cli {
namespace {

// Of a picture [px]: smaller shows nothing, larger is more than the offscreen buffer takes.
constexpr int kMinSide_px = 16;
constexpr int kMaxSide_px = 8192;

}  // namespace

void WriteResult(const std::string& text, const std::filesystem::path& file) {
  if (!file.empty()) return base::WriteFile(file, text);
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) {
    return;
  }
  if (errno == EPIPE) return;  // the reader has seen enough: `| head`
  throw base::RunError("stdout: the results could not be written");
}

void WriteTables(const std::string& text) {
  WriteResult(StdoutShowsColors() ? ForTerminal(text) : text);
}

void WriteTables(const experiment::Report& report, const experiment::Stamp& stamp,
                 experiment::TableFormat format) {
  const std::string text = experiment::Format(report, stamp, format);
  if (format == experiment::TableFormat::kText) {
    WriteTables(text);
  } else {
    WriteResult(text);
  }
}

void CheckEnding(const std::filesystem::path& file, const std::vector<std::string>& endings) {
  if (std::find(endings.begin(), endings.end(), base::EndingOf(file)) != endings.end()) return;
  throw base::InputError(fmt::format("{}: its name must end with {}, which is what can be written",
                                     file.string(), base::Join(endings, " or ")));
}

std::pair<int, int> ParseSize(const std::string& text) {
  int width = 0;
  int height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < kMinSide_px ||
      height < kMinSide_px || width > kMaxSide_px || height > kMaxSide_px) {
    throw base::InputError("size '" + text +
                           "' must be WIDTHxHEIGHT in pixels, 16 to 8192 each, e.g. 1280x960");
  }
  return {width, height};
}

void AddFormatOption(CLI::App& command, std::string& format) {
  command.add_option("--format", format, "of the tables (text)")
      ->check(CLI::IsMember(base::WordList<experiment::TableFormat>()));
  command.add_flag_callback(
      "--json", [&format] { format = "json"; }, "same as --format json");
}

experiment::TableFormat TableFormatFrom(const std::string& word) {
  return base::FromWord<experiment::TableFormat>(word, "--format");
}

}  // namespace rangegrasp::cli
