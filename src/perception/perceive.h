#pragma once

#include "core/rng.h"
#include "perception/features.h"
#include "perception/preprocess.h"
#include "perception/scene.h"
#include "perception/segment.h"

namespace rangegrasp::perception {

struct PerceptionOptions {
  PreprocessOptions preprocess;
  SegmentOptions segment;
  FeatureOptions features;
};

/// Multiplies every length that stands for point spacing or noise: the defaults are those of a
/// laser scanner with 2 mm between points and 0.5 mm noise. @throws std::invalid_argument unless
/// factor > 0.
void ScaleLengths(double factor, PerceptionOptions& options);

/// Chapter 5.1 from a cloud to objects: table, filters, normals, segments, top surfaces, rims,
/// merging, completion. Given a cloud and where the sensor stood, nothing else: it runs on a
/// recorded cloud as in a trial.
/// @param points_C  n finite points [m]
/// @param sensor_origin_C  [m]
/// @throws core::InputError if there are fewer than 100 points or no table plane can be found.
Scene Perceive(geometry::PointSpan points_C, const Eigen::Vector3d& sensor_origin_C,
               const PerceptionOptions& options, core::Rng& rng);

}  // namespace rangegrasp::perception
