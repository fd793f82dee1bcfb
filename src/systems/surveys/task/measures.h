#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "experiment/report.h"
#include "geometry/cloud_file.h"
#include "perception/perception_options.h"
#include "trial/trial.h"

/// What a survey measures of one arranged scene, and the tables of it. Truth scores what perception
/// made of the scan, which it does not see.
namespace rangegrasp::surveys {

/// Seconds of each step.
using Seconds = std::vector<std::pair<std::string, double>>;

/// How well touching objects are separated: this program's segmentations and those of the Point
/// Cloud Library on the same scan.
nlohmann::ordered_json MeasureSeparation(const trial::Cell& cell, const trial::Arrangement& scene,
                                         std::uint64_t seed, Seconds& seconds);
/// The same of a depth camera's recorded cloud with labels: 0 nothing measured, 1 to 9 the table,
/// 20 and more objects.
nlohmann::ordered_json MeasureSeparation(const geometry::CloudFile& cloud,
                                         const perception::PerceptionOptions& options,
                                         Seconds& seconds);
/// Whether the first object counts as rotational, and about which axis.
nlohmann::ordered_json MeasureRotation(const trial::Cell& cell, const trial::Arrangement& scene,
                                       std::uint64_t seed, Seconds& seconds);
/// Which share of what the left camera sees of each object is reconstructed, and how well, where
/// its picture has texture and where it has none.
nlohmann::ordered_json MeasureReconstruction(const trial::Cell& cell,
                                             const trial::Arrangement& scene, std::uint64_t seed,
                                             Seconds& seconds);

/// The result of each case: its data, and the record for names and seconds.
struct Measured {
  const experiment::Record* record;
  nlohmann::ordered_json data;
};
experiment::Section SeparationTable(const std::vector<Measured>& scans);
experiment::Section RotationTable(const std::vector<Measured>& scans);
experiment::Section ReconstructionTable(const std::vector<Measured>& scans);

}  // namespace rangegrasp::surveys
