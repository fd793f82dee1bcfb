#include "external/outside_options.h"

#include <fmt/format.h>

#include "base/process/ask.h"

namespace rangegrasp::external {
namespace {

using base::YamlMap;

void ResolveCommand(const YamlMap& map, OutsideOptions& options) {
  auto& command = options.command;
  const auto folder = std::filesystem::absolute(map.file()).parent_path();
  for (std::string& word : command) {
    const bool is_name = &word == &command.front() && word.find('/') == std::string::npos;
    const auto beside = (folder / word).lexically_normal();
    std::error_code ignored;  // of words that are no names of files at all
    if (is_name || word.empty() || !std::filesystem::exists(beside, ignored)) {
      if (word.ends_with(".py")) map.Fail("command", fmt::format("no file {}", beside.string()));
      continue;
    }
    word = beside.string();
    options.files.push_back(beside);
  }
  const auto program = process::Find(command.front());
  if (!program) {
    map.Fail("command", fmt::format("no program '{}' that can be executed (a name is looked for in "
                                    "PATH, a path from the experiment's folder)",
                                    command.front()));
  }
  command.front() = program->string();
}

}  // namespace

void ReadOutside(YamlMap map, OutsideOptions& options) {
  if (!map.Names().empty()) map.Require("command");
  map.Read("command", options.command,
           "a program of your own with its arguments, e.g. [python3, my_detector.py]; files are "
           "looked for from the experiment's folder");
  map.Read("time_limit_s", options.limit_s, 0.1, 86400.0,
           "from its start to its answer; less than trial_limit_s");
  map.Read("sandbox", options.sandbox,
           "it runs without network, writes its own folder only and sees no results (bubblewrap)");
  map.Read("memory_mb", options.memory_mb, 0, 10'000'000,
           "address space of each of its processes; 0: no limit");
  map.Read("file_mb", options.file_mb, 0, 10'000'000,
           "size of each file that it writes; 0: no limit");
  map.Finish();
  if (!options.command.empty()) ResolveCommand(map, options);
}

}  // namespace rangegrasp::external
