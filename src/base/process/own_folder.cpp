#include "base/process/own_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

#include "base/error.h"

namespace rangegrasp::process {

OwnFolder::OwnFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "rangegrasp-XXXXXX").string();
  if (!mkdtemp(name.data())) {
    throw base::RunError(name + ": no such folder can be made: " + strerror(errno));
  }
  path_ = std::filesystem::canonical(name);
}

OwnFolder::~OwnFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace rangegrasp::process
