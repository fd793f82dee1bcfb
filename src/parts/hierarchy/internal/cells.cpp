#include "parts/hierarchy/internal/cells.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace rangegrasp::parts {
namespace {

using geometry::ShortestPaths;

struct Growth {
  std::vector<double> distance;
  std::vector<std::int32_t> cell;
  ShortestPaths paths;
};

/// Takes the faces that are nearer to one more seed than to those before.
void Grow(const FaceGraph& faces, const std::vector<double>& step, std::uint32_t seed,
          std::int32_t cell, Growth& growth) {
  growth.cell[seed] = cell;
  growth.paths.Lower({{seed}}, growth.distance, [&](std::uint32_t f, double d, const auto& reach) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      if (reach(faces.neighbor[k], d + step[k])) {
        growth.cell[faces.neighbor[k]] = cell;
      }
    }
  });
}

void Summarize(const FaceGraph& faces, const FaceFrames& frames, const std::vector<double>& costs,
               std::size_t count, Cells& cells) {
  cells.center.assign(count, Eigen::Vector3d::Zero());
  cells.normal.assign(count, Eigen::Vector3d::Zero());
  cells.area.assign(count, 0.0);
  std::vector<std::map<std::uint32_t, double>> border(count);
  for (std::uint32_t f = 0; f < frames.area.size(); ++f) {
    const auto c = static_cast<std::size_t>(cells.of_face[f]);
    cells.center[c] += frames.area[f] * frames.center[f];
    cells.normal[c] += frames.area[f] * frames.normal[f];
    cells.area[c] += frames.area[f];
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::int32_t other = cells.of_face[faces.neighbor[k]];
      if (other != cells.of_face[f]) border[c][static_cast<std::uint32_t>(other)] += costs[k];
    }
  }
  cells.links.resize(count);
  cells.on_edge.assign(count, false);
  for (std::size_t c = 0; c < count; ++c) {
    cells.center[c] /= cells.area[c];
    if (cells.normal[c].norm() > 0.0) cells.normal[c].normalize();
    for (const auto& [to, cost] : border[c]) cells.links[c].push_back({to, cost});
  }
}

}  // namespace

Cells BuildCells(const FaceGraph& faces, const FaceFrames& frames, const std::vector<double>& bends,
                 const std::vector<double>& costs, int count, double crease) {
  const std::size_t n = frames.area.size();
  std::vector<double> step(bends.size());
  for (std::uint32_t f = 0; f < n; ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      step[k] = (frames.center[f] - frames.center[faces.neighbor[k]]).norm() *
                (1.0 + crease * std::max(0.0, bends[k]));
    }
  }
  Growth growth{std::vector<double>(n, ShortestPaths::kFar), std::vector<std::int32_t>(n, -1), {}};
  Growth first = growth;
  Grow(faces, step, 0, 0, first);
  std::size_t seed = geometry::FarthestReached(first.distance);
  std::int32_t made = 0;
  while (made < count || growth.distance[seed] == ShortestPaths::kFar) {
    Grow(faces, step, static_cast<std::uint32_t>(seed), made++, growth);
    seed = static_cast<std::size_t>(
        std::max_element(growth.distance.begin(), growth.distance.end()) - growth.distance.begin());
    if (growth.distance[seed] == 0.0) break;
  }
  Cells cells;
  cells.of_face = growth.cell;
  Summarize(faces, frames, costs, static_cast<std::size_t>(made), cells);
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
        subset.links[k].push_back({number[link.to], link.cost});
      }
    }
  }
  return subset;
}

}  // namespace rangegrasp::parts
