#pragma once

#include <string>
#include <vector>

#include "seam/internal/raw_row.h"
#include "seam/profile_format.h"

namespace rangegrasp::seam {

/// Whether a file of this ending is an image: .png, .pgm, .tif, .tiff.
bool IsImageEnding(const std::string& ending);

/// The rows of the bytes of a 16-bit grey or floating-point image; the first damaged one is an
/// error.
/// @throws base::InputError naming row, column and value (the caller names the file).
std::vector<RawRow> RowsOfImage(const std::string& bytes, const std::string& ending,
                                const ProfileFileOptions& options);

}  // namespace rangegrasp::seam
