#include "parts/hierarchy/internal/move_borders.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "geometry/shortest_path.h"
#include "parts/shape/internal/min_cut.h"

namespace rangegrasp::parts {
namespace {

using Pair = std::pair<std::int32_t, std::int32_t>;
using Faces = std::vector<std::uint32_t>;

std::set<Pair> TouchingParts(const FaceGraph& faces, const std::vector<std::int32_t>& label) {
  std::set<Pair> pairs;
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::int32_t other = label[faces.neighbor[k]];
      if (label[f] < other) pairs.insert({label[f], other});
    }
  }
  return pairs;
}

/// The faces of two parts within `width` of the border between them, and the ring of faces next.
struct Band {
  Faces inner;
  Faces ring;
};

Band BandOf(const FaceGraph& faces, const FaceFrames& frames, const Pair& pair, double width,
            const std::vector<std::int32_t>& label) {
  const auto in_pair = [&](std::uint32_t f) {
    return label[f] == pair.first || label[f] == pair.second;
  };
  Faces at_border;
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    if (!in_pair(f)) continue;
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::uint32_t g = faces.neighbor[k];
      if (in_pair(g) && label[g] != label[f]) at_border.push_back(f);
    }
  }
  std::vector<double> distance(label.size(), geometry::ShortestPaths::kFar);
  geometry::ShortestPaths().Lower(
      at_border, distance,
      [&](std::uint32_t f, double d, const auto& reach) {
        for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
          const std::uint32_t g = faces.neighbor[k];
          if (in_pair(g)) reach(g, d + (frames.center[f] - frames.center[g]).norm());
        }
      },
      width);
  Band band;
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    if (distance[f] < geometry::ShortestPaths::kFar) {
      (distance[f] <= width ? band.inner : band.ring).push_back(f);
    }
  }
  return band;
}

void MoveBorder(const FaceGraph& faces, const FaceFrames& frames, const std::vector<double>& costs,
                const Pair& pair, double width, std::vector<std::int32_t>& label) {
  const Band band = BandOf(faces, frames, pair, width, label);
  // Both parts keep something: the ring, without which there is nothing to cut between.
  bool first = false;
  bool second = false;
  std::map<std::uint32_t, std::uint32_t> node;
  for (const std::uint32_t f : band.ring) {
    node[f] = label[f] == pair.first ? kSource : kSink;
    (label[f] == pair.first ? first : second) = true;
  }
  if (!first || !second) return;
  std::uint32_t nodes = 2;
  for (const std::uint32_t f : band.inner) node[f] = nodes++;
  std::vector<CutLink> links;
  for (const std::uint32_t f : band.inner) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const auto other = node.find(faces.neighbor[k]);
      if (other == node.end()) continue;
      if (other->second > kSink && other->first < f) continue;
      links.push_back({node[f], other->second, costs[k]});
    }
  }
  const std::vector<bool> with_source = MinCut(nodes, links, kSource, kSink);
  for (const std::uint32_t f : band.inner)
    label[f] = with_source[node[f]] ? pair.first : pair.second;
}

}  // namespace

void MoveBorders(const FaceGraph& faces, const FaceFrames& frames, const std::vector<double>& costs,
                 double width, std::vector<std::int32_t>& label) {
  for (const Pair& pair : TouchingParts(faces, label)) {
    MoveBorder(faces, frames, costs, pair, width, label);
  }
}

}  // namespace rangegrasp::parts
