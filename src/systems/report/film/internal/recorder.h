#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "trial/recorder.h"

namespace rangegrasp::report {

/// Records pictures, a sheet of all pictures, and a film.
/// @throws base::InputError for an unknown camera, or if a film is requested and ffmpeg is not
/// installed.
std::unique_ptr<trial::Recorder> MakeRecorder(const trial::Cell& cell, const std::string& prefix,
                                              const experiment::ReplayOptions& options);

/// Concatenates films whose pictures have the same size.
/// @throws base::RunError if ffmpeg has failed, InputError if it is not installed; then there is no
/// file.
void JoinVideos(const std::vector<std::filesystem::path>& files, const std::filesystem::path& into);

}  // namespace rangegrasp::report
