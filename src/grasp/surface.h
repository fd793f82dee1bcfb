#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "geometry/mesh.h"
#include "perception/scene.h"

namespace rangegrasp::grasp {

/// Points spread evenly over a surface. Each stands for the same area.
struct SurfaceSamples {
  geometry::Points points;
  geometry::Points normals;  ///< unit; oriented like the triangles
  double area_m2 = 0.0;      ///< area of one sample
};

/// About `count` samples of a mesh. Each triangle gets samples in proportion to its area, along an
/// additive low-discrepancy sequence (Roberts 2018, R2), so that the same mesh gives the same
/// samples and a moved mesh gives moved ones.
SurfaceSamples SampleSurface(const geometry::TriangleMesh& mesh, std::size_t count);

/// Samples of a perceived object: of its completed surface or, if it has none, its own points.
SurfaceSamples SampleObject(const perception::Scene& scene,
                            const perception::PerceivedObject& object, std::size_t count);

/// The centre of the volume that the surface encloses (divergence theorem), which is the centre of
/// mass of a homogeneous object. If the surface encloses none (open, mixed orientation), the mean
/// of its sampled points.
Eigen::Vector3d CenterOfMass(const geometry::TriangleMesh& mesh, geometry::PointSpan sampled);

/// The cell that contains a point, in a grid that starts at the origin.
std::array<long, 3> GridCell(const Eigen::Vector3d& p, double cell_m);

/// One small triangle (side 1.2 mm) for every cell of a grid of cell_m that contains points: a
/// surface for point sets without one.
geometry::TriangleMesh SpeckMesh(geometry::PointSpan points, double cell_m);

/// An object known only by points: they are its shape, specks on a grid of 2 mm its surface. Its
/// box reaches down to the table.
/// @param points  positions in scene.cloud
perception::PerceivedObject ObjectOfPoints(const perception::Scene& scene,
                                           geometry::Indices points);

/// The surface of an object for collision checks: its own, or specks if it has none.
geometry::TriangleMesh SurfaceOf(const perception::PerceivedObject& object);

/// The surfaces of all objects but one, and the obstacles.
std::vector<geometry::TriangleMesh> Others(const perception::Scene& scene, std::size_t own,
                                           std::span<const geometry::TriangleMesh> obstacles_C);

}  // namespace rangegrasp::grasp
