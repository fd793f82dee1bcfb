#pragma once

#include <filesystem>
#include <span>

#include "recognition/library.h"
#include "sim/world.h"

namespace rangegrasp::recognition {

/// What is seen of each object, as a library.
/// @throws base::InputError naming the file of what is no object.
recognition::Library LibraryOf(std::span<const sim::ObjectModel> objects,
                               const recognition::LibraryOptions& options = {});

/// The library of a folder, or of several: each NAME/NAME.xml in it is a known object; of two with
/// the same name that of the first folder counts.
/// @throws base::InputError naming the folder without one.
recognition::Library LoadLibrary(std::span<const std::filesystem::path> folders,
                                 const recognition::LibraryOptions& options = {});

}  // namespace rangegrasp::recognition
