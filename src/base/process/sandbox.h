#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace rangegrasp::process {

/// What a program in a sandbox sees of the file system: all of it, to read, but for
struct Box {
  std::filesystem::path folder;               ///< its own, which it may write
  std::vector<std::filesystem::path> hidden;  ///< these are empty; those that are absent stay so
  /// Of what is hidden these are seen all the same (where the program itself lies); never one that
  /// is hidden itself or holds something hidden.
  std::vector<std::filesystem::path> shown;
};

/// The command that runs another in a sandbox (bubblewrap): files as the box says, temporary
/// folders and /run hidden, no network, no other processes in sight, no privileges; dies with its
/// parent.
std::vector<std::string> InSandbox(const std::vector<std::string>& command, const Box& box);

/// Why no sandbox can be made here, and the cure; nullopt if one can. Starts one to find out.
std::optional<std::string> WhyNoSandbox();

}  // namespace rangegrasp::process
