#pragma once

#include <filesystem>

#include "stereo/reconstruct.h"

namespace rangegrasp::cli {

/// Writes what a reconstruction was made from: rectified.png (both pictures with lines along the
/// rows), disparity.png (in colours) and disparity16.png (256 levels a pixel, 0 for none).
void WriteStereoPictures(const stereo::Reconstruction& made, const std::filesystem::path& folder);

}  // namespace rangegrasp::cli
