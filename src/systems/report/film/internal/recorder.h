#pragma once

#include <memory>
#include <string>

#include "trial/recorder.h"

namespace rangegrasp::report {

/// Records pictures, a sheet of all pictures, and a film.
/// @throws base::InputError for an unknown camera, or a film without ffmpeg.
std::unique_ptr<trial::Recorder> MakeRecorder(const trial::Cell& cell, const std::string& prefix,
                                              const experiment::ReplayOptions& options);

}  // namespace rangegrasp::report
