#pragma once

#include <cstdint>
#include <vector>

#include "base/rng.h"
#include "parts/shape/segmentation.h"

namespace rangegrasp::parts_task {

/// How a cloud is sampled from a mesh.
struct CloudGrade {
  int points = 0;
  /// Standard deviation of each coordinate, in percent of the diagonal of the mesh's bounding box.
  double noise_percent = 0.0;

  bool operator==(const CloudGrade&) const = default;
};

/// Points drawn evenly from the surface, each with normal noise.
/// @throws base::InputError as parts::MakeShape.
parts::Shape SampleCloud(const parts::Shape& mesh, const CloudGrade& grade, base::Rng& rng);

/// What was found of a cloud, handed to the mesh that it was sampled from: a face has the label of
/// the point nearest to its center.
parts::Segmentation OfMesh(const parts::Shape& mesh, const parts::Shape& cloud,
                           const parts::Segmentation& found);

}  // namespace rangegrasp::parts_task
