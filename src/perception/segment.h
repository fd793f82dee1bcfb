#pragma once

#include "base/units.h"
#include "base/words.h"
#include "perception/sampling.h"

namespace rangegrasp::perception {

enum class SegmentMethod { kMesh, kRegionGrowing, kConvexity };
constexpr std::array<std::string_view, 3> WordsOf(SegmentMethod) {
  return {"mesh", "region_growing", "convexity"};
}

/// Options of SegmentByConvexity.
struct ConvexityOptions {
  /// Points this near are neighbors: the next line of a line scanner and its diagonals.
  AdaptiveLength link_m{0.0035, {.noises = 1.5, .spacings = 2.0, .gaps = 1.5}};
  /// On a face seen at a grazing angle, a point's neighbors spread less than this share across a
  /// line. There, it looks grazing_reach times as far for few_links more neighbors, which must lie
  /// across the line (45 deg) and in each other's tangent planes (20 deg).
  double on_a_line = 0.3;
  double grazing_reach = 4.0;
  int few_links = 6;
  double max_along_line = 0.7;
  double max_link_slope = 0.35;
  /// Size of a patch. Larger: small things join their neighbors; smaller: noise bends patches.
  AdaptiveLength patch_m{0.015, {.noises = 20.0, .gaps = 4.0}};
  /// Difference of unit normals (30 deg) that separates points as patch_m does. Smaller: patches of
  /// curved surfaces become narrow; larger: they bend around edges.
  double patch_turn = 0.52;
  int min_seed_points = 4;
  /// Patches with a smaller angle between them belong to one surface: noise.
  double concavity_rad = base::Deg(14.0);
  double concave_rad = base::Deg(40.0);  ///< from this angle on, a concave border has full weight
  /// Weight of a concave border's links; others: 1. Larger: fewer leaks; smaller: dents cut less.
  double concave_weight = 4.0;
  /// Bodies of less than this many mean patches are no bodies and join a neighbor.
  double speck_patches = 5.0;
  /// So do slivers along a seam: more than this share of their points lies within sliver_depth
  /// patches of the border with another body.
  double sliver_share = 0.6;
  double sliver_depth = 0.35;
  /// Patches that face the same way, but are further apart along their normals, are two surfaces.
  AdaptiveLength step_m{0.002, {.noises = 2.0, .gaps = 0.5}};
};

struct SegmentAdditions {
  bool bounded_alpha = true;
  bool drop_small_segments = true;
};
constexpr std::array<base::Addition<SegmentAdditions>, 2> AdditionsOf(const SegmentAdditions*) {
  using A = SegmentAdditions;
  return {{
      {"bounded_alpha", &A::bounded_alpha,
       "limit the mesh's alpha, so that one stray point cannot join all segments; off: d_max "
       "without limits"},
      {"drop_small_segments", &A::drop_small_segments, "remove segments of fewer than 40 points"},
  }};
}
static_assert(base::AllAdditionsListed<SegmentAdditions>());

/// Options of section 5.1.2.
struct SegmentOptions : SegmentAdditions {
  /// The dissertation's choice is the mesh, which joins touching objects.
  SegmentMethod method = SegmentMethod::kConvexity;
  /// With bounded_alpha, the bounds of the mesh's alpha: 1.5 to 5 point spacings.
  AdaptiveLength min_alpha_m{0.003, {.noises = 2.0, .gaps = 0.65}};
  AdaptiveLength max_alpha_m{0.010, {.noises = 5.0, .gaps = 2.2}};
  /// With drop_small_segments, the smallest size: 18 mm square for the dissertation's scanner.
  /// AdaptLengths sets it: fewer for a coarser one.
  int min_points = 40;
  /// Radius of region growing in mean nearest-neighbor distances: the next row and its diagonals.
  double neighborhood = 3.0;
  ConvexityOptions convexity;
};

/// The mesh's alpha [m]: d_max, the largest nearest-neighbor distance (dissertation), within the
/// options' bounds.
double MeshAlpha(double d_max_m, const SegmentOptions& options);

/// Algorithm 3: 3-D Delaunay triangulation, alpha shape, triangle connectivity. Segments largest
/// first, ties by first point; positions ascending. O(n log n); independent of the points' order.
std::vector<geometry::Indices> SegmentByMesh(geometry::PointSpan points,
                                             const SegmentOptions& options);

/// Algorithm 2 with the normal weight (eq. 5.2-5.4): a neighbor joins if d * (1 - |cos alpha|) <
/// d_a, the mean nearest-neighbor distance. Only neighbors within 3 d_a can join, because the
/// weight of parallel normals would join points at any distance. Independent of start points and
/// order of growth. Segments largest first, ties by first point; positions ascending.
/// @throws std::invalid_argument unless there is one normal per point.
std::vector<geometry::Indices> SegmentByRegionGrowing(geometry::PointSpan points,
                                                      geometry::PointSpan normals,
                                                      const SegmentOptions& options);

/// Cuts along concave edges, where bodies touch (after Stein et al. 2014, "Object partitioning
/// using local convexity"). Surfaces are split into small flat patches. The border of two patches
/// counts for one body if they are convex, or face the same way without a step. It counts against
/// it if they are concave, by how much they bend more than each by itself. Both count by the
/// border's length. Borders that count more against than for are cut (geometry::ContractGreedily).
/// Specks and slivers along the cuts join a neighbor. Segments largest first, ties by first point;
/// positions ascending. O(m log m), m pairs of neighboring points.
/// @throws std::invalid_argument unless there is one normal per point.
std::vector<geometry::Indices> SegmentByConvexity(const geometry::PointCloud& cloud,
                                                  const SegmentOptions& options);

/// w_g = 1 - |cos(alpha)| (eq. 5.3, 5.4) of two normals, of any length > 0.
double NormalWeight(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// Segments by the method that the options name.
std::vector<geometry::Indices> Segment(const geometry::PointCloud& cloud,
                                       const SegmentOptions& options);

}  // namespace rangegrasp::perception
