#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/observation.h"
#include "labelled_cloud.h"
#include "perception/perceive.h"
#include "trial/trial.h"

namespace rangegrasp::bench {

/// One view with the truth beside it, for evaluation alone.
struct LabelledScan {
  std::string name;
  geometry::Observation observation;
  /// One a sample, as of the depth camera's clouds: 0 nothing measured, or outside the workspace;
  /// 1 table, box, or anything else of the scene; 20 and more objects.
  std::vector<std::uint32_t> label;
  Eigen::Vector3d origin_C = Eigen::Vector3d::Zero();
  std::optional<perception::Workspace> workspace;
  bool depth_camera = false;  ///< points further apart with depth; else a line scanner's

  const geometry::RangeImage& image() const { return observation.views.front().image; }
  /// The samples that count.
  geometry::Points Measured() const;
};

LabelledScan OfCamera(labelled::Cloud cloud, std::string name);

/// What a trial of an experiment would perceive. nullopt if no arrangement came to rest.
/// @param keep  a folder in which scans are kept, so that the next run need not arrange and scan;
/// may be empty. Scans are told apart by the experiment's name, the trial and its seed.
std::optional<LabelledScan> OfTrial(const trial::Cell& cell, const trial::TrialSpec& spec,
                                    const std::string& keep);

}  // namespace rangegrasp::bench
