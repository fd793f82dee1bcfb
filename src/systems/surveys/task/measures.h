#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "experiment/report.h"
#include "geometry/cloud_file.h"
#include "perception/perception_options.h"
#include "trial/trial.h"

/// Measurements of a survey on one arranged scene, and their tables. Ground truth scores the result
/// of perception, which does not see it.
namespace rangegrasp::surveys {

/// Seconds of each step.
using Seconds = std::vector<std::pair<std::string, double>>;

/// Quality of the separation of touching objects: this program's segmentations and those of the
/// Point Cloud Library on the same scan.
nlohmann::ordered_json MeasureSeparation(const trial::Cell& cell, const trial::Arrangement& scene,
                                         std::uint64_t seed, Seconds& seconds);
/// The same for a depth camera's recorded cloud with labels: 0 not measured, 1 to 9 the table, 20
/// and above objects.
nlohmann::ordered_json MeasureSeparation(const geometry::CloudFile& cloud,
                                         const perception::PerceptionOptions& options,
                                         Seconds& seconds);
/// Whether the first object is classified as rotational, and about which axis.
nlohmann::ordered_json MeasureRotation(const trial::Cell& cell, const trial::Arrangement& scene,
                                       std::uint64_t seed, Seconds& seconds);
/// For each object, the share of what the left camera sees that is reconstructed, and its errors,
/// for parts of the image with and without texture. The cell's sensor must be a stereo camera.
nlohmann::ordered_json MeasureReconstruction(const trial::Cell& cell,
                                             const trial::Arrangement& scene, std::uint64_t seed,
                                             Seconds& seconds);

/// The result of a case: its data, and the record for names and seconds.
struct Measured {
  const experiment::Record* record;
  nlohmann::ordered_json data;
};
experiment::Section SeparationTable(const std::vector<Measured>& scans);
experiment::Section RotationTable(const std::vector<Measured>& scans);
experiment::Section ReconstructionTable(const std::vector<Measured>& scans);

}  // namespace rangegrasp::surveys
