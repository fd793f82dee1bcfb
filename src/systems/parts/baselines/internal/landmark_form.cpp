#include "parts/baselines/internal/landmark_form.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

#include "geometry/hull.h"
#include "parts/mirror/spherical_mirror.h"
#include "parts/stretched/smacof.h"

namespace rangegrasp::parts {
namespace {

struct CoordinateLess {
  bool operator()(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
    return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
  }
};

std::vector<bool> OnHull(const geometry::Points& points, const geometry::TriangleMesh& hull) {
  const std::set<Eigen::Vector3d, CoordinateLess> corners(hull.vertices.begin(),
                                                          hull.vertices.end());
  std::vector<bool> on_hull(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) on_hull[i] = corners.contains(points[i]);
  return on_hull;
}

/// How far each point is inside of a hull of which it is one or which holds it.
std::vector<double> DepthInHull(const geometry::Points& points,
                                const geometry::TriangleMesh& hull) {
  std::vector<double> depth(points.size(), std::numeric_limits<double>::infinity());
  for (const auto& [a, b, c] : hull.triangles) {
    const Eigen::Vector3d normal = (hull.vertices[b] - hull.vertices[a])
                                       .cross(hull.vertices[c] - hull.vertices[a])
                                       .normalized();
    for (std::size_t i = 0; i < points.size(); ++i) {
      depth[i] = std::min(depth[i], normal.dot(hull.vertices[a] - points[i]));
    }
  }
  return depth;
}

}  // namespace

LandmarkForm MakeLandmarkForm(const VertexGraph& graph, const std::vector<bool>& cut,
                              int landmarks) {
  LandmarkForm form;
  form.spread = SpreadLandmarks(graph, landmarks);
  const auto n = form.spread.landmark.size();
  form.distance = BetweenLandmarks(form.spread);
  form.neighbors.resize(n);
  form.near_cut.assign(n, false);
  const std::vector<std::uint32_t>& nearest = form.spread.nearest;
  for (std::uint32_t v = 0; v < nearest.size(); ++v) {
    if (cut[v]) form.near_cut[nearest[v]] = true;
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      const std::uint32_t other = nearest[graph.neighbor[k]];
      if (other != nearest[v]) form.neighbors[nearest[v]].insert(other);
    }
  }
  const Embedding embedding = Smacof(form.distance, {});
  for (std::size_t i = 0; i < n; ++i) {
    form.embedded.push_back(embedding.positions.row(static_cast<Eigen::Index>(i)));
  }
  return form;
}

std::vector<bool> FeaturePoints(const LandmarkForm& form, const std::vector<bool>& on_hull) {
  const Eigen::VectorXd far = form.distance.rowwise().sum();
  std::vector<bool> feature(form.size(), false);
  for (std::uint32_t i = 0; i < form.size(); ++i) {
    feature[i] = on_hull[i] && !form.near_cut[i];
    for (const std::uint32_t j : form.neighbors[i]) {
      if (far[j] >= far[i]) feature[i] = false;
    }
  }
  return feature;
}

namespace {

/// Landmarks from the core's middle outwards: by how deep the mirrored ones lie in their hull.
struct Outward {
  std::vector<std::uint32_t> order;
  std::vector<double> depth;  ///< a landmark
  std::size_t on_hull = 0;    ///< the first so many
};

Outward FromCoreOutwards(const LandmarkForm& form) {
  const Sphere sphere = SphereRound(geometry::Centroid(form.embedded), form.embedded);
  const geometry::Points mirrored = MirrorOut(form.embedded, sphere);
  const geometry::TriangleMesh hull = geometry::ConvexHull(mirrored);
  Outward outward{{}, DepthInHull(mirrored, hull), hull.vertices.size()};
  outward.order.resize(form.size());
  std::iota(outward.order.begin(), outward.order.end(), 0u);
  std::stable_sort(
      outward.order.begin(), outward.order.end(),
      [&](std::uint32_t a, std::uint32_t b) { return outward.depth[a] < outward.depth[b]; });
  return outward;
}

/// Components of the landmarks that are left when the first `core` of the order are gone, numbered
/// from 1 where they hold a feature point, else 0. Returns how many do.
std::int32_t Components(const LandmarkForm& form, const std::vector<bool>& feature,
                        const std::vector<std::uint32_t>& order, std::size_t core,
                        std::vector<std::int32_t>& label) {
  std::vector<bool> rest(form.size(), true);
  for (std::size_t k = 0; k < core; ++k) rest[order[k]] = false;
  label.assign(form.size(), 0);
  std::int32_t count = 0;
  std::vector<std::uint32_t> front;
  for (std::uint32_t i = 0; i < form.size(); ++i) {
    if (!feature[i] || !rest[i] || label[i] != 0) continue;
    label[i] = ++count;
    front.push_back(i);
    while (!front.empty()) {
      const std::uint32_t at = front.back();
      front.pop_back();
      for (const std::uint32_t j : form.neighbors[at]) {
        if (!rest[j] || label[j] != 0) continue;
        label[j] = count;
        front.push_back(j);
      }
    }
  }
  return count;
}

/// Grows the core from the hull of the mirrored landmarks outwards and stops where the number of
/// separate components with feature points then stays the same for longest: growing on until every
/// last feature point is on its own (ears, horns) would leave stumps of the limbs.
std::int32_t Separate(const LandmarkForm& form, const std::vector<bool>& feature,
                      std::vector<std::int32_t>& label) {
  const Outward outward = FromCoreOutwards(form);
  double longest = -1.0;
  std::int32_t best = 0;
  std::int32_t count = 0;
  double since = 0.0;
  std::vector<std::int32_t> first, candidate;
  for (std::size_t core = outward.on_hull; core < outward.order.size(); ++core) {
    const double depth = outward.depth[outward.order[core]];
    const std::int32_t now = Components(form, feature, outward.order, core, candidate);
    if (now != count) {
      count = now;
      since = depth;
      first = candidate;
    }
    if (count > 0 && (count - 1) * (depth - since) > longest) {
      longest = (count - 1) * (depth - since);
      best = count;
      label = first;
    }
  }
  return best;
}

}  // namespace

std::int32_t LabelLandmarks(const LandmarkForm& form, double hull_fraction,
                            std::vector<std::int32_t>& label) {
  const std::vector<bool> on_hull = OnHull(form.embedded, geometry::ConvexHull(form.embedded));
  const auto convex = static_cast<double>(std::count(on_hull.begin(), on_hull.end(), true));
  if (convex > hull_fraction * form.size()) return 0;
  return Separate(form, FeaturePoints(form, on_hull), label);
}

}  // namespace rangegrasp::parts
