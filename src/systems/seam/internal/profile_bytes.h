#pragma once

#include <string>
#include <vector>

#include "seam/profile.h"
#include "seam/profile_format.h"

namespace rangegrasp::seam {

/// The bytes of a file of profiles with this ending.
/// @throws base::InputError as WriteProfiles; the caller names the file.
std::string BytesOf(const std::vector<Profile>& profiles, const std::string& ending,
                    const ProfileFileOptions& options);

/// What is wrong with an ending that no profiles have.
std::string UnknownEnding(const std::string& ending);

}  // namespace rangegrasp::seam
