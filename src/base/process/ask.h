#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace rangegrasp::process {

/// A program that is asked: what is started, where, and what it may use.
struct Program {
  std::vector<std::string> command;  ///< the first word is a file; Find resolves names
  std::filesystem::path folder;      ///< it starts there
  /// Added to the environment that it inherits, in place of what stands there.
  std::vector<std::pair<std::string, std::string>> environment;
  double limit_s = 20.0;                            ///< from its start to its answer
  std::size_t max_answer_bytes = 16 * 1024 * 1024;  ///< longer lines are no answer
  std::uint64_t max_memory_bytes = 0;               ///< address space of a process; 0: no limit
  std::uint64_t max_file_bytes = 0;                 ///< of each file that it writes; 0: no limit
};

/// What came of it.
struct Reply {
  std::optional<std::string> line;  ///< the answer, without its end
  std::string failure;              ///< why there is none: "no answer within 20 s"
  std::string last_words;           ///< the end of what it wrote to stderr: one line of plain ASCII
};

/// Starts the program, writes the question and an end of line to its stdin, closes it, and waits
/// for one line on its stdout (or what is there when it ends with code 0). Then the program is
/// killed, with all processes that it started, also those that left its process group. If this
/// process is killed, they die too. Whatever else it prints is taken off it and forgotten, so that
/// it cannot block.
/// @throws base::RunError if no process or pipe can be made.
Reply Ask(const Program& program, std::string_view question);

/// The file of a program: of a name without '/' the first one in PATH that can be executed; nullopt
/// if there is none.
std::optional<std::filesystem::path> Find(const std::string& name);

/// One line of plain ASCII of at most so many characters, the end of the text: what is not
/// printable becomes '?', lines are joined by " | ".
std::string LastWords(std::string_view text, std::size_t max_characters);

}  // namespace rangegrasp::process
