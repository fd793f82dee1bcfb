#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

struct mjModel_;

namespace rangegrasp::sim {

/// An MJCF file as a run compiles it: with the gravity compensation that its arm asks for
/// (numeric "gravity_compensation"). It may be a scene, an arm, a hand or an object.
/// @param warnings  receives the compiler's
/// @throws base::InputError with the file and the engine's message.
std::shared_ptr<mjModel_> CompileModel(const std::filesystem::path& mjcf,
                                       std::vector<std::string>& warnings);

}  // namespace rangegrasp::sim
