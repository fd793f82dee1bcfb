#include "parts/shape/face_frames.h"

namespace rangegrasp::parts {

FaceFrames BuildFaceFrames(const Shape& mesh) {
  FaceFrames frames;
  for (const auto& [i, j, k] : mesh.faces) {
    const Eigen::Vector3d& a = mesh.points[i];
    const Eigen::Vector3d& b = mesh.points[j];
    const Eigen::Vector3d& c = mesh.points[k];
    const Eigen::Vector3d cross = (b - a).cross(c - a);
    frames.center.emplace_back((a + b + c) / 3.0);
    frames.normal.emplace_back(cross.normalized());
    frames.area.push_back(0.5 * cross.norm());
    frames.total_area += frames.area.back();
  }
  return frames;
}

}  // namespace rangegrasp::parts
