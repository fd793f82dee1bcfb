#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "geometry/mesh.h"
#include "perception/scene.h"

namespace rangegrasp::grasp {

/// Points spread evenly over a surface, each standing for the same area.
struct SurfaceSamples {
  geometry::Points points;
  geometry::Points normals;  ///< unit; as the triangles are turned
  double area_m2 = 0.0;      ///< of one sample
};

/// About `count` samples of a mesh: every triangle gets its share of the area, along an additive
/// low-discrepancy sequence (Roberts 2018, R2), so that the same mesh gives the same samples and a
/// moved mesh gives moved ones.
SurfaceSamples SampleSurface(const geometry::TriangleMesh& mesh, std::size_t count);

/// Samples of a perceived object: of its completed surface, or, where it has none, its own points.
SurfaceSamples SampleObject(const perception::Scene& scene,
                            const perception::PerceivedObject& object, std::size_t count);

/// The centre of the volume that the surface encloses (divergence theorem), for a homogeneous
/// object its centre of mass; where the surface does not enclose one (open, turned mixed) the mean
/// of the samples.
Eigen::Vector3d CenterOfMass(const geometry::TriangleMesh& mesh, const SurfaceSamples& samples);

/// The cell of a grid from the origin that a point lies in.
std::array<long, 3> GridCell(const Eigen::Vector3d& p, double cell_m);

/// One small triangle (side 1 mm) for every cell of a grid of cell_m that holds points: a surface
/// for point sets that have none.
geometry::TriangleMesh SpeckMesh(geometry::PointSpan points, double cell_m);

/// An object that is nothing but points: those are its shape, specks on a grid of 2 mm its surface.
/// @param points  positions in scene.cloud
perception::PerceivedObject ObjectOfPoints(const perception::Scene& scene,
                                           geometry::Indices points);

/// What stands for an object in collision checks: its surface, or specks where it has none.
geometry::TriangleMesh SurfaceOf(const perception::PerceivedObject& object);

/// Those of all objects but one, and obstacles.
std::vector<geometry::TriangleMesh> Others(const perception::Scene& scene, std::size_t own,
                                           std::span<const geometry::TriangleMesh> obstacles_C);

}  // namespace rangegrasp::grasp
