#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/cloud_file.h"

/// Labelled point clouds of a depth camera, for evaluation only. They are in data/kinect of the
/// folder that RANGEGRASP_SHARED names, or of ../shared next to the project. The README there
/// describes the labels.
namespace rangegrasp::labelled {

inline std::filesystem::path SharedFolder() {
  const char* shared = std::getenv("RANGEGRASP_SHARED");
  return shared != nullptr ? std::filesystem::path(shared)
                           : std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "../shared";
}
inline std::filesystem::path KinectFolder() { return SharedFolder() / "data/kinect"; }

/// @param number  the number in learn<number>.pcd
inline geometry::CloudFile ReadKinect(int number) {
  return geometry::ReadCloud(KinectFolder() / ("learn" + std::to_string(number) + ".pcd"));
}

/// The numbers of all clouds.
inline std::vector<int> KinectNumbers() {
  std::vector<int> numbers;
  for (int number = 0; number <= 44; number += 2) numbers.push_back(number);
  return numbers;
}

}  // namespace rangegrasp::labelled
