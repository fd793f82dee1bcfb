#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "trial/recorder.h"

namespace rangegrasp::report {

/// Pictures, a sheet of them all, and a film.
/// @throws base::InputError if a film is asked for and there is no ffmpeg.
std::unique_ptr<trial::Recorder> MakeRecorder(const trial::Cell& cell, const std::string& prefix,
                                              const experiment::ReplayOptions& options);

/// One film after the other as one, whose pictures have the same size.
/// @throws base::RunError if ffmpeg has failed, InputError if there is none.
void JoinVideos(const std::vector<std::filesystem::path>& files, const std::filesystem::path& into);

}  // namespace rangegrasp::report
