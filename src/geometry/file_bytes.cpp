#include "geometry/internal/file_bytes.h"

#include <fstream>
#include <sstream>

#include "core/error.h"

namespace rangegrasp::geometry::internal {

std::string ReadBytes(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) {
    throw core::InputError(file.string() + ": there is no such file");
  }
  if (std::filesystem::is_directory(status)) {
    throw core::InputError(file.string() + ": is a folder; a file is needed");
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw core::InputError(file.string() + ": cannot be opened for reading");
  std::ostringstream buffer;
  buffer << stream.rdbuf();
  if (stream.bad()) throw core::InputError(file.string() + ": cannot be read to its end");
  std::string bytes = std::move(buffer).str();
  if (bytes.empty()) throw core::InputError(file.string() + ": is empty");
  return bytes;
}

void WriteBytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  if (!stream) throw core::RunError(file.string() + ": cannot be opened for writing");
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();  // a full disk may show only here
  if (!stream) {
    throw core::RunError(file.string() + ": could not be written whole (" +
                         std::to_string(bytes.size()) + " bytes; is the disk full?)");
  }
}

}  // namespace rangegrasp::geometry::internal
