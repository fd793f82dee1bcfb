#include "cli/output.h"

#include <cstdio>
#include <fstream>

#include "core/error.h"

namespace rangegrasp::cli {

void WriteResult(const std::string& text, const std::filesystem::path& file) {
  if (file.empty()) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() ||
        std::fflush(stdout) != 0) {
      throw core::RunError("stdout: the results could not be written");
    }
    return;
  }
  MakeFolderOf(file);
  std::ofstream out(file, std::ios::binary);
  if (!(out << text) || !out.flush()) {
    throw core::RunError(file.string() +
                         ": cannot be written (is the disk full, or the folder not writable?)");
  }
}

void MakeFolderOf(const std::filesystem::path& file) {
  if (!file.has_parent_path()) return;
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  if (error) {
    throw core::InputError(file.parent_path().string() +
                           ": the folder cannot be made: " + error.message());
  }
}

std::pair<int, int> ParseSize(const std::string& text) {
  int width = 0;
  int height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 16 ||
      height < 16 || width > 8192 || height > 8192) {
    throw core::InputError("size '" + text +
                           "' must be WIDTHxHEIGHT in pixels, 16 to 8192 each, e.g. 1280x960");
  }
  return {width, height};
}

report::TableFormat ParseTableFormat(const std::string& name) {
  if (name == "markdown") return report::TableFormat::kMarkdown;
  if (name == "csv") return report::TableFormat::kCsv;
  if (name == "json") return report::TableFormat::kJson;
  return report::TableFormat::kText;
}

}  // namespace rangegrasp::cli
