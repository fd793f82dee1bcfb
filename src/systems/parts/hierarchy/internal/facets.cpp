#include "parts/hierarchy/internal/facets.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "parts/hierarchy/internal/grid_slices.h"
#include "parts/shape/internal/pieces.h"

namespace rangegrasp::parts {
namespace {

/// Sine of the angle between faces in one plane, at most: above what coordinates of single
/// precision leave of it on faces of a hundredth of the size, below all that can be seen.
constexpr double kFlat = 1e-3;

/// Which flat piece each face is of.
std::int32_t FlatPieces(const FaceGraph& faces, const FaceFrames& frames,
                        std::vector<std::int32_t>& of_face) {
  return LabelPieces(
      faces, std::vector<bool>(frames.area.size(), true),
      [&](std::uint32_t f, std::uint32_t g) {
        return frames.normal[f].dot(frames.normal[g]) > 0.0 &&
               frames.normal[f].cross(frames.normal[g]).norm() < kFlat;
      },
      of_face);
}

/// Whether each face is of a piece of more area than a limit.
std::vector<bool> OfLargePieces(const FaceFrames& frames, std::int32_t pieces,
                                const std::vector<std::int32_t>& of_face, double max_area) {
  std::vector<double> area(static_cast<std::size_t>(pieces), 0.0);
  for (std::size_t f = 0; f < of_face.size(); ++f) {
    area[static_cast<std::size_t>(of_face[f])] += frames.area[f];
  }
  std::vector<bool> large;
  for (const std::int32_t piece : of_face) {
    large.push_back(area[static_cast<std::size_t>(piece)] > max_area);
  }
  return large;
}

FaceFrames FacetSums(const FaceFrames& faces, const std::vector<std::int32_t>& of_face,
                     std::size_t count) {
  FaceFrames sums{geometry::Points(count, Eigen::Vector3d::Zero()),
                  geometry::Points(count, Eigen::Vector3d::Zero()), std::vector<double>(count, 0.0),
                  faces.total_area};
  for (std::size_t f = 0; f < of_face.size(); ++f) {
    const auto facet = static_cast<std::size_t>(of_face[f]);
    sums.center[facet] += faces.area[f] * faces.center[f];
    sums.normal[facet] += faces.area[f] * faces.normal[f];
    sums.area[facet] += faces.area[f];
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (sums.area[k] > 0.0) sums.center[k] /= sums.area[k];
    sums.normal[k].normalize();
  }
  return sums;
}

/// Numbers facets by the places of their centers.
void NumberByCenter(FaceFrames& frames, std::vector<std::int32_t>& of_face) {
  std::vector<std::uint32_t> order(frames.area.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Eigen::Vector3d& p = frames.center[a];
    const Eigen::Vector3d& q = frames.center[b];
    return std::tie(p.x(), p.y(), p.z(), a) < std::tie(q.x(), q.y(), q.z(), b);
  });
  FaceFrames sorted;
  sorted.total_area = frames.total_area;
  std::vector<std::int32_t> number(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    number[order[k]] = static_cast<std::int32_t>(k);
    sorted.center.push_back(frames.center[order[k]]);
    sorted.normal.push_back(frames.normal[order[k]]);
    sorted.area.push_back(frames.area[order[k]]);
  }
  frames = std::move(sorted);
  for (std::int32_t& facet : of_face) facet = number[static_cast<std::size_t>(facet)];
}

FaceGraph GraphOf(const FaceGraph& faces, const std::vector<std::int32_t>& of_face,
                  std::size_t count) {
  std::vector<FaceLink> links;
  links.reserve(faces.neighbor.size());
  for (std::uint32_t f = 0; f < of_face.size(); ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::int32_t to = of_face[faces.neighbor[k]];
      if (to == of_face[f]) continue;
      links.push_back(
          {static_cast<std::uint32_t>(of_face[f]), static_cast<std::uint32_t>(to), faces.edge[k]});
    }
  }
  return GraphOfLinks(count, std::move(links));
}

}  // namespace

Facets MakeFacets(const Shape& mesh, double side) {
  Facets facets;
  facets.mesh = {mesh.points, mesh.faces, {}};
  facets.origin.resize(mesh.faces.size());
  std::iota(facets.origin.begin(), facets.origin.end(), 0u);
  FaceGraph faces = BuildFaceGraph(mesh);
  FaceFrames frames = BuildFaceFrames(mesh);
  std::vector<std::int32_t> flat;
  const std::int32_t pieces = FlatPieces(faces, frames, flat);
  const std::vector<bool> large = OfLargePieces(frames, pieces, flat, 0.5 * side * side);
  if (std::find(large.begin(), large.end(), true) != large.end()) {
    SliceAlongGrid(side, large, facets.mesh, facets.origin);
    faces = BuildFaceGraph(facets.mesh);
    frames = BuildFaceFrames(facets.mesh);
  }
  const auto cube = [&](std::uint32_t f) -> Eigen::Vector3i {
    return (frames.center[f] / side).array().floor().cast<int>();
  };
  const std::int32_t count = LabelPieces(
      faces, std::vector<bool>(facets.mesh.faces.size(), true),
      [&](std::uint32_t f, std::uint32_t g) {
        const std::uint32_t from = facets.origin[f];
        return flat[from] == flat[facets.origin[g]] && (!large[from] || cube(f) == cube(g));
      },
      facets.of_face);
  facets.frames = FacetSums(frames, facets.of_face, static_cast<std::size_t>(count));
  NumberByCenter(facets.frames, facets.of_face);
  facets.graph = GraphOf(faces, facets.of_face, static_cast<std::size_t>(count));
  return facets;
}

std::vector<std::int32_t> LabelsOfOrigin(const Facets& facets, std::size_t faces,
                                         const std::vector<std::int32_t>& label_of_facet) {
  struct Vote {
    std::uint32_t face;
    std::int32_t label;
    double area;
  };
  const FaceFrames frames = BuildFaceFrames(facets.mesh);
  std::vector<Vote> votes;
  votes.reserve(facets.of_face.size());
  for (std::size_t f = 0; f < facets.of_face.size(); ++f) {
    votes.push_back({facets.origin[f], label_of_facet[static_cast<std::size_t>(facets.of_face[f])],
                     frames.area[f]});
  }
  std::stable_sort(votes.begin(), votes.end(), [](const Vote& a, const Vote& b) {
    return std::tie(a.face, a.label) < std::tie(b.face, b.label);
  });
  std::vector<std::int32_t> labels(faces, -1);
  std::vector<double> most(faces, -1.0);
  for (std::size_t k = 0; k < votes.size();) {
    const Vote& first = votes[k];
    double area = 0.0;
    for (; k < votes.size() && votes[k].face == first.face && votes[k].label == first.label; ++k) {
      area += votes[k].area;
    }
    if (area <= most[first.face]) continue;
    most[first.face] = area;
    labels[first.face] = first.label;
  }
  return labels;
}

}  // namespace rangegrasp::parts
