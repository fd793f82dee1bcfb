#pragma once

#include <filesystem>

namespace rangegrasp::process {

/// A new empty folder among the temporary ones, that nobody else may enter; goes with its contents.
class OwnFolder {
 public:
  /// @throws base::RunError if it cannot be made.
  OwnFolder();
  ~OwnFolder();
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }  ///< without links in it

 private:
  std::filesystem::path path_;
};

}  // namespace rangegrasp::process
