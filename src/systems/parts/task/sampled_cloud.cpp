#include "parts/task/sampled_cloud.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "geometry/bounds.h"
#include "geometry/kd_tree.h"
#include "geometry/triangle_point.h"
#include "parts/shape/face_frames.h"

namespace rangegrasp::parts_task {
namespace {

using Eigen::Vector3d;

Vector3d PointOf(const parts::Shape& mesh, std::size_t face, base::Rng& rng) {
  const auto& [a, b, c] = mesh.faces[face];
  const double u = rng.Uniform();
  const double v = rng.Uniform();
  return geometry::TrianglePoint(mesh.points[a], mesh.points[b], mesh.points[c], u, v);
}

Vector3d NoiseOf(double deviation, base::Rng& rng) {
  Vector3d noise;
  for (double& x : noise) x = deviation * rng.Normal();
  return noise;
}

}  // namespace

parts::Shape SampleCloud(const parts::Shape& mesh, const CloudGrade& grade, base::Rng& rng) {
  const parts::FaceFrames frames = parts::BuildFaceFrames(mesh);
  std::vector<double> up_to(frames.area.size());
  std::partial_sum(frames.area.begin(), frames.area.end(), up_to.begin());
  const double deviation =
      0.01 * grade.noise_percent * geometry::BoundsOf(mesh.points).diagonal().norm();
  geometry::TriangleMesh cloud;
  for (int k = 0; k < grade.points; ++k) {
    const double area = rng.Uniform() * up_to.back();
    const auto face = std::upper_bound(up_to.begin(), up_to.end() - 1, area) - up_to.begin();
    const Vector3d p = PointOf(mesh, static_cast<std::size_t>(face), rng);
    cloud.vertices.push_back(p + NoiseOf(deviation, rng));
  }
  return parts::MakeShape(cloud);
}

parts::Segmentation OfMesh(const parts::Shape& mesh, const parts::Shape& cloud,
                           const parts::Segmentation& found) {
  const parts::FaceFrames frames = parts::BuildFaceFrames(mesh);
  const geometry::KdTree tree(cloud.points);
  std::vector<geometry::KdTree::Neighbor> near;
  parts::Segmentation of_mesh = found;
  of_mesh.label.clear();
  for (const Vector3d& center : frames.center) {
    tree.Nearest(center, 1, near);
    of_mesh.label.push_back(found.label[near.front().index]);
  }
  return of_mesh;
}

}  // namespace rangegrasp::parts_task
