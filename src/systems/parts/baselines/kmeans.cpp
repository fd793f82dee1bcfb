#include "parts/baselines/kmeans.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "geometry/shortest_path.h"
#include "parts/shape/face_frames.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {
namespace {

using KMeansSeeds = std::vector<std::uint32_t>;

/// The faces with their centroids, and what it costs to go from one to the next.
struct DualGraph {
  FaceGraph faces;
  std::vector<double> cost;  ///< parallel to faces.neighbor
  FaceFrames frames;
};

/// 0 where the surface is flat or bends outwards, up to 2 in the sharpest concave fold: 1 - cos of
/// the angle between the normals, as in the weights of Funkhouser et al. 2004 that let cuts run
/// along concave edges.
double Concavity(const Eigen::Vector3d& normal, const Eigen::Vector3d& next_normal,
                 const Eigen::Vector3d& to_next) {
  if (normal.dot(to_next) - next_normal.dot(to_next) <= 0.0) return 0.0;
  return 1.0 - normal.dot(next_normal);
}

DualGraph MakeDualGraph(const Shape& mesh, double dihedral_weight) {
  DualGraph graph;
  graph.faces = BuildFaceGraph(mesh);
  graph.frames = BuildFaceFrames(mesh);
  const FaceFrames& frames = graph.frames;
  graph.cost.resize(graph.faces.neighbor.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::uint32_t k = graph.faces.begin[f]; k < graph.faces.begin[f + 1]; ++k) {
      const std::uint32_t next = graph.faces.neighbor[k];
      const Eigen::Vector3d to_next = frames.center[next] - frames.center[f];
      graph.cost[k] =
          to_next.norm() *
          (1.0 + dihedral_weight * Concavity(frames.normal[f], frames.normal[next], to_next));
    }
  }
  return graph;
}

/// For each face the seed (a position in seeds) it is nearest to, and how far.
struct Nearest {
  std::vector<double> distance;
  std::vector<std::int32_t> seed;
};

using geometry::ShortestPaths;

/// Takes the faces that are nearer to the seeds from `first` on than to those before.
void Grow(const DualGraph& graph, const KMeansSeeds& seeds, std::size_t first, Nearest& nearest) {
  for (std::size_t s = first; s < seeds.size(); ++s) {
    nearest.seed[seeds[s]] = static_cast<std::int32_t>(s);
  }
  ShortestPaths().Lower(std::span(seeds).subspan(first), nearest.distance,
                        [&](std::uint32_t f, double d, const auto& reach) {
                          for (std::uint32_t k = graph.faces.begin[f]; k < graph.faces.begin[f + 1];
                               ++k) {
                            const std::uint32_t next = graph.faces.neighbor[k];
                            if (reach(next, d + graph.cost[k])) {
                              nearest.seed[next] = nearest.seed[f];
                            }
                          }
                        });
}

Nearest Unreached(const DualGraph& graph) {
  return {std::vector<double>(graph.frames.center.size(), ShortestPaths::kFar),
          std::vector<std::int32_t>(graph.frames.center.size(), -1)};
}

/// Faces in pieces of the mesh without a seed go with the seed nearest in a straight line.
std::vector<std::int32_t> Assign(const DualGraph& graph, const KMeansSeeds& seeds) {
  Nearest nearest = Unreached(graph);
  Grow(graph, seeds, 0, nearest);
  for (std::size_t f = 0; f < graph.frames.center.size(); ++f) {
    if (nearest.seed[f] >= 0) continue;
    double best = ShortestPaths::kFar;
    for (std::size_t s = 0; s < seeds.size(); ++s) {
      const double d = (graph.frames.center[seeds[s]] - graph.frames.center[f]).squaredNorm();
      if (d >= best) continue;
      best = d;
      nearest.seed[f] = static_cast<std::int32_t>(s);
    }
  }
  return nearest.seed;
}

/// Area-weighted; one a cluster.
geometry::Points ClusterCenters(const DualGraph& graph, const std::vector<std::int32_t>& label,
                                std::size_t clusters) {
  geometry::Points centers(clusters, Eigen::Vector3d::Zero());
  std::vector<double> areas(clusters, 0.0);
  for (std::size_t f = 0; f < label.size(); ++f) {
    const auto cluster = static_cast<std::size_t>(label[f]);
    centers[cluster] += graph.frames.area[f] * graph.frames.center[f];
    areas[cluster] += graph.frames.area[f];
  }
  for (std::size_t s = 0; s < clusters; ++s) centers[s] /= areas[s];
  return centers;
}

/// The face of each cluster that is nearest to the cluster's center.
KMeansSeeds MiddleFaces(const DualGraph& graph, const std::vector<std::int32_t>& label,
                        std::size_t clusters) {
  const geometry::Points centers = ClusterCenters(graph, label, clusters);
  KMeansSeeds seeds(clusters, 0);
  std::vector<double> best(clusters, ShortestPaths::kFar);
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    const auto cluster = static_cast<std::size_t>(label[f]);
    const double d = (graph.frames.center[f] - centers[cluster]).squaredNorm();
    if (d >= best[cluster]) continue;
    best[cluster] = d;
    seeds[cluster] = f;
  }
  return seeds;
}

/// The face farthest from the center of the surface, then again and again the one farthest along
/// the graph from all before; pieces that no seed reaches come first, by index.
KMeansSeeds FarApart(const DualGraph& graph, int count) {
  const Eigen::Vector3d center =
      ClusterCenters(graph, std::vector<std::int32_t>(graph.frames.center.size(), 0), 1).front();
  const auto farthest = std::max_element(
      graph.frames.center.begin(), graph.frames.center.end(), [&](const auto& a, const auto& b) {
        return (a - center).squaredNorm() < (b - center).squaredNorm();
      });
  KMeansSeeds seeds{static_cast<std::uint32_t>(farthest - graph.frames.center.begin())};
  Nearest nearest = Unreached(graph);
  for (Grow(graph, seeds, 0, nearest); seeds.size() < static_cast<std::size_t>(count);
       Grow(graph, seeds, seeds.size() - 1, nearest)) {
    const auto next = std::max_element(nearest.distance.begin(), nearest.distance.end());
    if (*next <= 0.0) break;  // more clusters than faces
    seeds.push_back(static_cast<std::uint32_t>(next - nearest.distance.begin()));
  }
  return seeds;
}

}  // namespace

Segmentation SegmentByKMeans(const Shape& shape, const KMeansOptions& options) {
  if (!shape.IsMesh()) throw base::InputError("k-means needs a mesh; the input is a point cloud");
  if (options.clusters < 1 || options.iterations < 1 || !(options.dihedral_weight >= 0.0)) {
    throw std::invalid_argument("SegmentByKMeans: clusters, iterations >= 1, dihedral_weight >= 0");
  }
  const DualGraph graph = MakeDualGraph(shape, options.dihedral_weight);
  KMeansSeeds seeds = FarApart(graph, options.clusters);
  Segmentation result;
  result.label = Assign(graph, seeds);
  for (int i = 1; i < options.iterations; ++i) {
    seeds = MiddleFaces(graph, result.label, seeds.size());
    std::vector<std::int32_t> label = Assign(graph, seeds);
    if (label == result.label) break;
    result.label = std::move(label);
  }
  result.parts = static_cast<int>(seeds.size());
  return result;
}

}  // namespace rangegrasp::parts
