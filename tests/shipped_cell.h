#pragma once

namespace rangegrasp::testing_support {

/// The first three lines of an experiment file outside the project: the shipped scene, scanner and
/// objects.
inline constexpr const char* kShippedCell =
    "scene: " RANGEGRASP_SOURCE_DIR "/scenes/tabletop.xml\nsensor: " RANGEGRASP_SOURCE_DIR
    "/models/sensors/line_scanner.yaml\n"
    "object_folders: [" RANGEGRASP_SOURCE_DIR "/models/objects]\n";

}  // namespace rangegrasp::testing_support
