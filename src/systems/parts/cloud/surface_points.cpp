#include "parts/cloud/surface_points.h"

#include "parts/cloud/internal/smooth_surface.h"

namespace rangegrasp::parts {
namespace {

using geometry::KdTree;
using geometry::Points;

/// Cells are of 1000 faces' areas; three times as many points as these have corners.
constexpr int kMaxPoints = 15'000;
/// How near points may stand, in spacings: nearer ones make slivers.
constexpr double kMinDistance = 0.7;
/// Noise, in spacings, below which the nearest points lie beside a point, not above it.
constexpr double kNoisy = 0.25;

Points WithoutStrays(const Points& points) {
  const KdTree tree(points);
  const std::vector<bool> stray = StrayPoints(points, tree, MeasureSampling(points, tree));
  Points kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!stray[i]) kept.push_back(points[i]);
  }
  return kept.empty() ? points : kept;
}

}  // namespace

bool IsNoisy(const CloudSampling& sampling) { return sampling.noise > kNoisy * sampling.spacing; }

SurfacePoints PointsOfSurface(const Points& points) {
  const Points kept = WithoutStrays(points);
  const CloudSampling sampling = MeasureSampling(kept, KdTree(kept));
  const double spacing = ThinnedSpacing(kept.size(), sampling, kMaxPoints);
  return {SpreadOut(SmoothSurface(kept, sampling, kMaxPoints), kMinDistance * spacing), spacing,
          sampling.noise};
}

}  // namespace rangegrasp::parts
