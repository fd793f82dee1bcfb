#pragma once

namespace rangegrasp {

/// The grasping testbed: its task, words, commands and listings. When the program starts, before
/// any system.
void RegisterTrial();

}  // namespace rangegrasp
