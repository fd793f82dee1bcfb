#include "base/file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "base/error.h"

namespace rangegrasp::base {

std::string ReadFile(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) {
    throw InputError(file.string() + ": no such file");
  }
  if (std::filesystem::is_directory(status)) {
    throw InputError(file.string() + ": is a folder; a file is needed");
  }
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file.string() + ": cannot be opened for reading");
  std::ostringstream bytes;
  bytes << in.rdbuf();
  if (in.bad()) throw InputError(file.string() + ": cannot be read to its end");
  return std::move(bytes).str();
}

std::string ReadNonEmptyFile(const std::filesystem::path& file) {
  std::string bytes = ReadFile(file);
  if (bytes.empty()) throw InputError(file.string() + ": is empty");
  return bytes;
}

void WriteFile(const std::filesystem::path& file, std::string_view bytes) {
  MakeFolderOf(file);
  std::error_code error;
  // A device or a pipe (/dev/stdout, /dev/full) is written to, not replaced.
  const auto status = std::filesystem::status(file, error);
  const bool in_place =
      std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
  std::filesystem::path target = file;
  if (!in_place) target += fmt::format(".part{}", getpid());
  std::ofstream out(target, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();  // a full disk may show only here
  if (out && !in_place) std::filesystem::rename(target, file, error);
  if (out && !error) return;
  if (!in_place) std::filesystem::remove(target, error);
  throw RunError(
      fmt::format("{}: could not be written whole ({} bytes; is the disk full, or the folder not "
                  "writable?)",
                  file.string(), bytes.size()));
}

void MakeFolderOf(const std::filesystem::path& file) {
  if (!file.has_parent_path()) return;
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  if (error) {
    throw InputError(file.parent_path().string() +
                     ": the folder cannot be made: " + error.message());
  }
}

std::string EndingOf(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return ending;
}

}  // namespace rangegrasp::base
