#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "base/file.h"
#include "geometry/cloud_file.h"

/// Clouds of a depth camera with labels, for evaluation alone: data/kinect in the folder that
/// RANGEGRASP_SHARED names, or in ../shared beside the project. Its README says what the labels
/// mean.
namespace rangegrasp::labelled {

inline std::filesystem::path SharedFolder() {
  const char* shared = std::getenv("RANGEGRASP_SHARED");
  return shared != nullptr ? std::filesystem::path(shared)
                           : std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "../shared";
}
inline std::filesystem::path KinectFolder() { return SharedFolder() / "data/kinect"; }

/// The first `size` bytes of LZF data: runs of literals (control < 32: control + 1 of them) and
/// copies (a length of 3 bits and more, a distance of 13 bits).
inline std::string ExpandLzf(const std::string& in, std::size_t size) {
  std::string out;
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(in.at(at)); };
  for (std::size_t at = 0; out.size() < size;) {
    const unsigned control = byte(at++);
    if (control < 32) {
      out += in.substr(at, control + 1);
      at += control + 1;
      continue;
    }
    unsigned length = control >> 5;
    if (length == 7) length += byte(at++);
    const std::size_t distance = ((control & 31u) << 8) + byte(at++) + 1;
    for (unsigned k = 0; k < length + 2; ++k) out += out.at(out.size() - distance);
  }
  return out;
}

/// The column `label`, which is the first: compressed columns stand one after the other.
inline std::vector<std::uint32_t> ReadLabels(const std::filesystem::path& file,
                                             std::size_t points) {
  const std::string text = base::ReadFile(file);
  const std::string head = "DATA binary_compressed\n";
  const std::size_t start = text.find(head) + head.size() + 8;  // after the two sizes
  const std::string column = ExpandLzf(text.substr(start), 4 * points);
  std::vector<std::uint32_t> labels(points);
  for (std::size_t i = 0; i < points; ++i) std::memcpy(&labels[i], column.data() + 4 * i, 4);
  return labels;
}

struct Cloud {
  geometry::CloudFile file;           ///< organised, NaN where nothing was measured
  std::vector<std::uint32_t> labels;  ///< one a point
};

/// @param number  of learn<number>.pcd
inline Cloud ReadKinect(int number) {
  const auto path = KinectFolder() / ("learn" + std::to_string(number) + ".pcd");
  Cloud cloud{geometry::ReadCloud(path), {}};
  cloud.labels = ReadLabels(path, cloud.file.points.size());
  return cloud;
}

/// The numbers of all clouds.
inline std::vector<int> KinectNumbers() {
  std::vector<int> numbers;
  for (int number = 0; number <= 44; number += 2) numbers.push_back(number);
  return numbers;
}

}  // namespace rangegrasp::labelled
