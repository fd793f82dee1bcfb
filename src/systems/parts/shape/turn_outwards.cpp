#include "parts/shape/turn_outwards.h"

#include <Eigen/Geometry>
#include <utility>

#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {
namespace {

using TurnedFace = std::array<std::uint32_t, 3>;

bool RunsAlong(const TurnedFace& face, const std::array<std::uint32_t, 2>& edge) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (face[i] == edge[0] && face[(i + 1) % 3] == edge[1]) return true;
  }
  return false;
}

}  // namespace

std::vector<TurnedFace> TurnedOutwards(const Shape& mesh) {
  const FaceGraph graph = BuildFaceGraph(mesh);
  std::vector<TurnedFace> faces = mesh.faces;
  std::vector<bool> seen(faces.size(), false);
  std::vector<std::uint32_t> piece;
  for (std::uint32_t first = 0; first < faces.size(); ++first) {
    if (seen[first]) continue;
    seen[first] = true;
    piece.assign(1, first);
    for (std::size_t k = 0; k < piece.size(); ++k) {
      const std::uint32_t f = piece[k];
      for (std::uint32_t e = graph.begin[f]; e < graph.begin[f + 1]; ++e) {
        const std::uint32_t next = graph.neighbor[e];
        if (seen[next]) continue;
        seen[next] = true;
        if (RunsAlong(faces[f], graph.edge[e]) == RunsAlong(faces[next], graph.edge[e])) {
          std::swap(faces[next][1], faces[next][2]);
        }
        piece.push_back(next);
      }
    }
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const std::uint32_t f : piece) middle += mesh.points[faces[f][0]];
    middle /= static_cast<double>(piece.size());
    double volume = 0.0;
    for (const std::uint32_t f : piece) {
      volume +=
          (mesh.points[faces[f][0]] - middle)
              .dot((mesh.points[faces[f][1]] - middle).cross(mesh.points[faces[f][2]] - middle));
    }
    if (volume >= 0.0) continue;
    for (const std::uint32_t f : piece) std::swap(faces[f][1], faces[f][2]);
  }
  return faces;
}

}  // namespace rangegrasp::parts
