#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace rangegrasp::process {

/// A program to run: its command, working folder, environment and limits.
struct Program {
  std::vector<std::string> command;  ///< the first word is a file path; Find resolves names
  std::filesystem::path folder;      ///< working folder
  /// Variables added to the inherited environment; they replace those of the same name.
  std::vector<std::pair<std::string, std::string>> environment;
  double limit_s = 20.0;                            ///< time limit from start to answer
  std::size_t max_answer_bytes = 16 * 1024 * 1024;  ///< longer lines are rejected
  std::uint64_t max_memory_bytes = 0;               ///< address space per process; 0: no limit
  std::uint64_t max_file_bytes = 0;                 ///< size of each file it writes; 0: no limit
};

/// The result of asking a program.
struct Reply {
  std::optional<std::string> line;  ///< the answer, without its line break
  std::string failure;              ///< why there is no answer: "no answer within 20 s"
  std::string last_words;           ///< the end of its stderr output: one line of plain ASCII
};

/// Starts the program, writes the question and a line break to its stdin, closes stdin, and waits
/// for one line on its stdout (or for any output if it exits with code 0). Then the program and all
/// processes it started are killed, even if this process is killed. Any other output is discarded.
/// @throws base::RunError if no process or pipe can be created.
Reply Ask(const Program& program, std::string_view question);

/// The first executable file in PATH for a name without '/'; nullopt if there is none.
std::optional<std::filesystem::path> Find(const std::string& name);

/// The end of a text as one line of plain ASCII with at most this many characters: non-printable
/// characters become '?', lines are joined by " | ".
std::string LastWords(std::string_view text, std::size_t max_characters);

/// A program that reads bytes and whose exit code says whether it accepted them. It is killed if
/// this object is destroyed before Finish, or if this process is killed.
class Feed {
 public:
  /// Program::limit_s limits the time without an accepted byte, and from Finish to the exit.
  /// @param name  what the program produces, for messages
  /// @throws base::RunError if no process or pipe can be created.
  Feed(const Program& program, std::string name);
  ~Feed();

  /// @throws base::RunError with the end of its stderr if it has ended or accepts no more bytes.
  void Write(std::span<const std::uint8_t> bytes);
  /// Ends the input and waits for the program to exit.
  /// @throws base::RunError with the end of its stderr if it does not exit, or not with code 0.
  void Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Checks that memory is available, for libraries that crash without it.
/// @throws base::RunError if a limit of this process (ulimit -v) leaves less.
void NeedMemory(std::size_t bytes);

/// A new, private temporary folder; the destructor removes it with its contents.
class OwnFolder {
 public:
  /// @throws base::RunError if it cannot be made.
  OwnFolder();
  ~OwnFolder();
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }  ///< without symbolic links

 private:
  std::filesystem::path path_;
};

/// What a sandboxed program sees of the file system: everything is readable, with these exceptions.
struct Box {
  std::filesystem::path folder;               ///< the program's own folder, writable
  std::vector<std::filesystem::path> hidden;  ///< appear empty; absent ones stay absent
  /// Folders that stay visible inside hidden ones (where the program itself is located). A folder
  /// that is hidden itself or contains a hidden one is never shown.
  std::vector<std::filesystem::path> shown;
};

/// The command that runs another command in a sandbox (bubblewrap): files as in `box`, temporary
/// folders and /run hidden, no network, other processes or privileges. It ends with its parent.
std::vector<std::string> InSandbox(const std::vector<std::string>& command, const Box& box);

/// Why no sandbox can be created here, and the fix; nullopt if one can. Starts one as a test.
std::optional<std::string> WhyNoSandbox();

}  // namespace rangegrasp::process
