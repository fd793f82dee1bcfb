#include "parts/hierarchy/internal/cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "parts/hierarchy/internal/patches.h"
#include "parts/shape/internal/pieces.h"

namespace rangegrasp::parts {
namespace {

using geometry::ShortestPaths;
using Seeds = std::vector<std::uint32_t>;

/// Area of a patch of the grid below which it has no seed, of a cube's side: a corner cut off.
constexpr double kMinPatch = 0.3;
/// Times that seeds go to the middle of their cells: the first evens the grid out, more do little.
constexpr int kRounds = 2;

/// Of each set of faces that has a center the face nearest to it; none where the center is absent.
Seeds NearestFaces(const FaceFrames& frames, const std::vector<std::int32_t>& set_of_face,
                   const geometry::Points& center, const std::vector<bool>& wanted) {
  constexpr std::uint32_t kNoCell = std::numeric_limits<std::uint32_t>::max();
  std::vector<double> nearest(center.size(), ShortestPaths::kFar);
  Seeds face(center.size(), kNoCell);
  for (std::uint32_t f = 0; f < set_of_face.size(); ++f) {
    const auto set = static_cast<std::size_t>(set_of_face[f]);
    const double squared = (frames.center[f] - center[set]).squaredNorm();
    if (!wanted[set] || squared >= nearest[set]) continue;
    nearest[set] = squared;
    face[set] = f;
  }
  std::erase(face, kNoCell);
  return face;
}

/// A seed in each large patch of the grid, and one in the largest patch of a piece without.
Seeds GridSeeds(const FaceGraph& faces, const FaceFrames& frames, double side) {
  const Patches patches = CutByGrid(faces, frames, side);
  std::vector<bool> wanted(patches.size());
  for (std::size_t p = 0; p < patches.size(); ++p) {
    wanted[p] = patches.area[p] >= kMinPatch * side * side;
  }
  std::vector<std::int32_t> piece;
  const auto pieces = static_cast<std::size_t>(
      LabelPieces(faces, std::vector<bool>(frames.area.size(), true), piece));
  std::vector<std::int32_t> largest(pieces, -1);
  std::vector<bool> has(pieces, false);
  for (std::size_t f = 0; f < piece.size(); ++f) {
    const auto of = static_cast<std::size_t>(piece[f]);
    const std::int32_t p = patches.of_face[f];
    has[of] = has[of] || wanted[static_cast<std::size_t>(p)];
    if (largest[of] < 0 || patches.area[static_cast<std::size_t>(p)] >
                               patches.area[static_cast<std::size_t>(largest[of])]) {
      largest[of] = p;
    }
  }
  for (std::size_t of = 0; of < pieces; ++of) {
    if (!has[of]) wanted[static_cast<std::size_t>(largest[of])] = true;
  }
  return NearestFaces(frames, patches.of_face, patches.center, wanted);
}

/// The seed that each face is nearest to.
std::vector<std::int32_t> NearestSeeds(const FaceGraph& faces, const std::vector<double>& step,
                                       const Seeds& seeds) {
  std::vector<std::int32_t> cell(faces.begin.size() - 1, -1);
  for (std::size_t s = 0; s < seeds.size(); ++s) cell[seeds[s]] = static_cast<std::int32_t>(s);
  std::vector<double> distance(cell.size(), ShortestPaths::kFar);
  ShortestPaths().Lower(seeds, distance, [&](std::uint32_t f, double d, const auto& reach) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      if (reach(faces.neighbor[k], d + step[k])) cell[faces.neighbor[k]] = cell[f];
    }
  });
  return cell;
}

void Summarize(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
               const std::vector<double>& costs, std::size_t count, Cells& cells) {
  cells.center.assign(count, Eigen::Vector3d::Zero());
  cells.normal.assign(count, Eigen::Vector3d::Zero());
  cells.area.assign(count, 0.0);
  struct Border {
    double cost = 0.0;
    double length = 0.0;
  };
  std::vector<std::map<std::uint32_t, Border>> borders(count);
  for (std::uint32_t f = 0; f < frames.area.size(); ++f) {
    const auto c = static_cast<std::size_t>(cells.of_face[f]);
    cells.center[c] += frames.area[f] * frames.center[f];
    cells.normal[c] += frames.area[f] * frames.normal[f];
    cells.area[c] += frames.area[f];
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::int32_t other = cells.of_face[faces.neighbor[k]];
      if (other == cells.of_face[f]) continue;
      Border& border = borders[c][static_cast<std::uint32_t>(other)];
      border.cost += costs[k];
      border.length += (mesh.points[faces.edge[k][0]] - mesh.points[faces.edge[k][1]]).norm();
    }
  }
  cells.links.resize(count);
  cells.on_edge.assign(count, false);
  for (std::size_t c = 0; c < count; ++c) {
    cells.center[c] /= cells.area[c];
    if (cells.normal[c].norm() > 0.0) cells.normal[c].normalize();
    for (const auto& [to, border] : borders[c]) {
      cells.links[c].push_back({to, border.cost, border.length});
    }
  }
}

}  // namespace

Cells BuildCells(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                 const std::vector<double>& bends, const std::vector<double>& costs, int count,
                 double crease) {
  const std::size_t n = frames.area.size();
  std::vector<double> step(bends.size());
  for (std::uint32_t f = 0; f < n; ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      step[k] = (frames.center[f] - frames.center[faces.neighbor[k]]).norm() *
                (1.0 + crease * std::max(0.0, bends[k]));
    }
  }
  // A surface lies in about 1.5 area / side^2 patches, two thirds of which have a seed.
  Seeds seeds = GridSeeds(faces, frames, std::sqrt(frames.total_area / count));
  Cells cells;
  for (int round = 0; round <= kRounds; ++round) {
    cells = {};
    cells.of_face = NearestSeeds(faces, step, seeds);
    Summarize(mesh, faces, frames, costs, seeds.size(), cells);
    if (round < kRounds) {
      seeds =
          NearestFaces(frames, cells.of_face, cells.center, std::vector<bool>(seeds.size(), true));
    }
  }
  return cells;
}

Cells Subset(const Cells& cells, const std::vector<std::uint32_t>& some) {
  constexpr std::uint32_t kOut = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number(cells.size(), kOut);
  for (std::uint32_t k = 0; k < some.size(); ++k) number[some[k]] = k;
  Cells subset;
  subset.links.resize(some.size());
  for (std::uint32_t k = 0; k < some.size(); ++k) {
    const std::uint32_t c = some[k];
    subset.center.push_back(cells.center[c]);
    subset.normal.push_back(cells.normal[c]);
    subset.area.push_back(cells.area[c]);
    subset.on_edge.push_back(cells.on_edge[c]);
    for (const Cells::Link& link : cells.links[c]) {
      if (number[link.to] == kOut) {
        subset.on_edge.back() = true;
      } else {
        subset.links[k].push_back({number[link.to], link.cost, link.length});
      }
    }
  }
  return subset;
}

}  // namespace rangegrasp::parts
