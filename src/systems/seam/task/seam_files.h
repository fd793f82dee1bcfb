#pragma once

#include <string>

#include "seam/stitching/closed_loop.h"
#include "seam/stitching/recording.h"

/// Text files that show a seam or a run.
namespace rangegrasp::seam_task {

/// A line a profile: its number, from 1, and the column where its edge is; nothing without one.
std::string LabelsCsv(const stitching::Recording& recording);
/// A line a point of the needle's path.
std::string PathCsv(const stitching::TrackResult& track);
/// The packets as they were sent, a line each.
std::string PacketsXml(const stitching::TrackResult& track);

}  // namespace rangegrasp::seam_task
