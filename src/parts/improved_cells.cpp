#include "parts/internal/improved_cells.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "geometry/kd_tree.h"

namespace rangegrasp::parts {
namespace {

/// Bits of edges that are looked at, at most.
constexpr std::size_t kBits = 100000;
constexpr int kPieces = 1000;  ///< of one edge, at most
constexpr double kConvexShare = 0.25;
constexpr double kFar = std::numeric_limits<double>::infinity();

/// A bit of an edge.
struct Bits {
  geometry::Points middle;
  geometry::Points normal;
  geometry::Points along;
  std::vector<double> weight;       ///< length times signed angle, > 0 convex
  std::vector<std::uint32_t> slot;  ///< of the edge, in FaceGraph::neighbor
};

/// The angle between two faces, > 0 where they are convex.
double Dihedral(const FaceFrames& frames, std::uint32_t f, std::uint32_t g) {
  const Eigen::Vector3d& n = frames.normal[f];
  const Eigen::Vector3d& m = frames.normal[g];
  const double angle = std::atan2(n.cross(m).norm(), n.dot(m));
  return n.dot(frames.center[g] - frames.center[f]) > 0.0 ? -angle : angle;
}

Bits BitsOfEdges(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                 double longest) {
  Bits bits;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::uint32_t g = faces.neighbor[k];
      if (g < f) continue;
      const Eigen::Vector3d& a = mesh.points[faces.edge[k][0]];
      const Eigen::Vector3d& b = mesh.points[faces.edge[k][1]];
      const double length = (b - a).norm();
      const double angle = Dihedral(frames, f, g);
      Eigen::Vector3d normal = frames.normal[f] + frames.normal[g];
      if (normal.norm() > 1e-9) normal.normalize();
      const int count = std::clamp(static_cast<int>(std::ceil(length / longest)), 1, kPieces);
      for (int i = 0; i < count; ++i) {
        bits.middle.emplace_back(a + (i + 0.5) / count * (b - a));
        bits.normal.push_back(normal);
        bits.along.emplace_back((b - a) / length);
        bits.weight.push_back(angle * length / count);
        bits.slot.push_back(k);
      }
    }
  }
  return bits;
}

std::vector<double> BendOfBits(const Bits& bits, double scale) {
  const std::size_t stride = (bits.middle.size() + kBits - 1) / kBits;
  geometry::Points some;
  for (std::size_t i = 0; i < bits.middle.size(); i += stride) some.push_back(bits.middle[i]);
  const geometry::KdTree tree(some);
  std::vector<geometry::KdTree::Neighbor> near;
  std::vector<double> bend(bits.middle.size(), 0.0);
  for (std::size_t i = 0; i < bits.middle.size(); ++i) {
    tree.Within(bits.middle[i], scale, near);
    double sum = 0.0;
    for (const auto& neighbor : near) {
      const std::size_t other = neighbor.index * stride;
      if (bits.normal[other].dot(bits.normal[i]) <= 0.0) continue;
      const double cosine = bits.along[other].dot(bits.along[i]);
      const double nearness = 1.0 - std::sqrt(neighbor.squared_distance) / scale;
      sum -= 2.0 * nearness * bits.weight[other] * cosine * cosine;
    }
    bend[i] = sum * static_cast<double>(stride) / (2.0 * scale);
  }
  return bend;
}

struct Growth {
  std::vector<double> distance;
  std::vector<std::int32_t> cell;
};

/// Dijkstra's algorithm from one more seed; takes faces that are nearer to it than to others.
void Grow(const FaceGraph& faces, const std::vector<double>& step, std::uint32_t seed,
          std::int32_t cell, Growth& growth) {
  using Entry = std::pair<double, std::uint32_t>;
  std::vector<Entry> heap{{0.0, seed}};
  growth.distance[seed] = 0.0;
  growth.cell[seed] = cell;
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), std::greater<>());
    const auto [distance, f] = heap.back();
    heap.pop_back();
    if (distance > growth.distance[f]) continue;
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::uint32_t g = faces.neighbor[k];
      if (distance + step[k] >= growth.distance[g]) continue;
      growth.distance[g] = distance + step[k];
      growth.cell[g] = cell;
      heap.emplace_back(growth.distance[g], g);
      std::push_heap(heap.begin(), heap.end(), std::greater<>());
    }
  }
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

std::vector<double> EdgeBends(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                              double scale) {
  const Bits bits = BitsOfEdges(mesh, faces, frames, scale);
  const std::vector<double> bend_of_bit = BendOfBits(bits, scale);
  // The bits come edge after edge; each edge has its lower face's turn.
  std::vector<double> bends(faces.neighbor.size(), 0.0);
  std::size_t bit = 0;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::uint32_t g = faces.neighbor[k];
      if (g < f) continue;
      double sum = 0.0;
      std::size_t count = 0;
      for (; bit < bits.slot.size() && bits.slot[bit] == k; ++bit, ++count) {
        sum += bend_of_bit[bit];
      }
      bends[k] = sum / static_cast<double>(count);
      for (std::uint32_t back = faces.begin[g]; back < faces.begin[g + 1]; ++back) {
        if (faces.neighbor[back] == f && faces.edge[back] == faces.edge[k]) bends[back] = bends[k];
      }
    }
  }
  return bends;
}

std::vector<double> BendCosts(const Shape& mesh, const FaceGraph& faces,
                              const std::vector<double>& bends, double gain) {
  std::vector<double> costs(bends.size());
  for (std::size_t k = 0; k < costs.size(); ++k) {
    const double length = (mesh.points[faces.edge[k][0]] - mesh.points[faces.edge[k][1]]).norm();
    costs[k] = length *
               (bends[k] > 0.0 ? std::exp(-gain * bends[k]) : 1.0 - kConvexShare * gain * bends[k]);
  }
  return costs;
}

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
  Growth growth{std::vector<double>(n, kFar), std::vector<std::int32_t>(n, -1)};
  Growth first = growth;
  Grow(faces, step, 0, 0, first);
  std::size_t seed = 0;
  for (std::size_t f = 0; f < n; ++f) {
    if (first.distance[f] < kFar && first.distance[f] > first.distance[seed]) seed = f;
  }
  std::int32_t made = 0;
  while (made < count || growth.distance[seed] == kFar) {
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
