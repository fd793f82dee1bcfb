#include "base/process/sandbox.h"

#include <algorithm>

#include "base/process/ask.h"
#include "base/process/own_folder.h"

namespace rangegrasp::process {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProgram = "bwrap";

bool IsIn(const fs::path& inner, const fs::path& outer) {
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

/// Temporary folders are shared by all programs of the machine, and /run holds sockets by which
/// others can be told what to do.
std::vector<fs::path> AlwaysHidden() {
  return {"/tmp", "/var/tmp", "/run", fs::temp_directory_path()};
}

std::vector<fs::path> HiddenBy(const Box& box) {
  std::vector<fs::path> hidden;
  for (const auto& list : {AlwaysHidden(), box.hidden}) {
    for (const fs::path& path : list) {
      std::error_code error;
      const fs::path real = fs::canonical(path, error);
      if (!error && real != "/" && fs::is_directory(real)) hidden.push_back(real);
    }
  }
  // Outer ones first, since what is mounted later lies on top.
  std::sort(hidden.begin(), hidden.end());
  hidden.erase(std::unique(hidden.begin(), hidden.end()), hidden.end());
  return hidden;
}

}  // namespace

std::vector<std::string> InSandbox(const std::vector<std::string>& command, const Box& box) {
  const auto bwrap = Find(kProgram);
  std::vector<std::string> boxed = {bwrap ? bwrap->string() : kProgram,
                                    "--unshare-all",
                                    "--die-with-parent",
                                    "--new-session",
                                    "--cap-drop",
                                    "ALL",
                                    "--ro-bind",
                                    "/",
                                    "/",
                                    "--dev",
                                    "/dev",
                                    "--proc",
                                    "/proc"};
  const auto add = [&](std::initializer_list<std::string> words) {
    boxed.insert(boxed.end(), words);
  };
  const auto hidden = HiddenBy(box);
  for (const fs::path& path : hidden) add({"--tmpfs", path.string()});
  for (const fs::path& path : box.shown) {
    const fs::path real = fs::weakly_canonical(path);
    const bool holds_hidden =
        std::any_of(hidden.begin(), hidden.end(), [&](const fs::path& h) { return IsIn(h, real); });
    if (!holds_hidden) add({"--ro-bind-try", real.string(), path.string()});
  }
  add({"--bind", fs::canonical(box.folder).string(), box.folder.string()});
  for (const fs::path& path : hidden) add({"--remount-ro", path.string()});
  add({"--chdir", box.folder.string(), "--"});
  boxed.insert(boxed.end(), command.begin(), command.end());
  return boxed;
}

std::optional<std::string> WhyNoSandbox() {
  if (!Find(kProgram)) {
    return "bubblewrap (the program bwrap) is not installed: apt-get install bubblewrap";
  }
  const OwnFolder folder;
  Program trial;
  trial.command = InSandbox({"/bin/sh", "-c", "echo works"}, {folder.path(), {}, {}});
  trial.folder = folder.path();
  const Reply reply = Ask(trial, "");
  if (reply.line == "works") return std::nullopt;
  return "bubblewrap cannot start (" +
         (reply.last_words.empty() ? reply.failure : reply.last_words) +
         "): this system or container does not let programs make namespaces of their own";
}

}  // namespace rangegrasp::process
