#include "parts/cloud/cloud_mesh.h"

#include <utility>

#include "geometry/plane.h"
#include "mesh/repair.h"
#include "parts/cloud/internal/advancing_front.h"
#include "parts/cloud/seen_side.h"
#include "parts/cloud/surface_points.h"
#include "parts/shape/canonical_mesh.h"
#include "parts/shape/face_frames.h"
#include "parts/shape/internal/pieces.h"
#include "parts/shape/turn_outwards.h"

namespace rangegrasp::parts {
namespace {

using geometry::KdTree;
using geometry::Points;

/// Gaps that are bridged, in spacings: a random sample has some of three, a scan more.
constexpr double kMaxGap = 6.0;
/// Of the area, below which a piece is no part of the surface; as HierarchyOptions::min_area.
constexpr double kMinPiece = 0.005;

/// Noise, in spacings, from which what is thin crumbles: both of its sides become one, in shreds.
/// Of the models for tuning 0.5 % of noise is 0.40 to 1.5, 0.3 % is 0.24 to 0.7.
constexpr double kCrumbles = 0.35;
/// Of the wrap, in spacings: radius of what is bridged, and how far it stands off. On the tuning
/// models with 0.5 % of noise 1.5 and 0.5 give the same, 3 and 1 blunt creases; both cost time or
/// borders.
constexpr double kBridged = 2.0, kOffset = 0.5;

/// Whether a mesh has to be wrapped to be whole. What is seen from one side would get a far side.
bool IsInShreds(const Shape& mesh, const SurfacePoints& surface) {
  return surface.noise > kCrumbles * surface.spacing &&
         FewestLayers(mesh) > SeenSideOptions{}.max_layers;
}

void LeaveSmallPiecesOut(Shape& mesh) {
  const FaceGraph graph = BuildFaceGraph(mesh);
  const FaceFrames frames = BuildFaceFrames(mesh);
  std::vector<std::int32_t> piece;
  const std::int32_t count = LabelPieces(graph, std::vector<bool>(mesh.faces.size(), true), piece);
  std::vector<double> area(static_cast<std::size_t>(count), 0.0);
  for (std::size_t f = 0; f < piece.size(); ++f) {
    area[static_cast<std::size_t>(piece[f])] += frames.area[f];
  }
  std::size_t kept = 0;
  for (std::size_t f = 0; f < piece.size(); ++f) {
    if (area[static_cast<std::size_t>(piece[f])] < kMinPiece * frames.total_area) continue;
    mesh.faces[kept++] = mesh.faces[f];
  }
  mesh.faces.resize(kept);
}

}  // namespace

CloudMesh MeshOfCloud(const Points& points) {
  const CanonicalCloud canonical = MakeCanonicalCloud(points);
  SurfacePoints surface = PointsOfSurface(canonical.points);
  CloudMesh result;
  Shape& mesh = result.mesh;
  mesh.points = std::move(surface.points);
  // Flat, or all but: it would have no third dimension to triangulate.
  if (geometry::IsFlat(mesh.points)) return {};
  mesh.faces = AdvancingFront(mesh.points, kMaxGap * surface.spacing);
  if (mesh.faces.empty()) return {};
  mesh.faces = TurnedOutwards(mesh);
  LeaveSmallPiecesOut(mesh);
  if (IsInShreds(mesh, surface)) {
    const geometry::TriangleMesh wrap = geometry::AlphaWrap(
        {mesh.points, mesh.faces}, kBridged * surface.spacing, kOffset * surface.spacing);
    mesh.points = wrap.vertices;
    mesh.faces = wrap.triangles;
  }
  const FaceFrames frames = BuildFaceFrames(mesh);
  const KdTree faces(frames.center);
  std::vector<KdTree::Neighbor> near;
  result.face_of_point.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    faces.Nearest(canonical.points[i], 1, near);
    result.face_of_point[canonical.origin[i]] = near.front().index;
  }
  return result;
}

}  // namespace rangegrasp::parts
