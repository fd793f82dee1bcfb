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
/// for one line on its stdout (or what is there when it ends with code 0). Then all processes that
/// came from the program are killed, also if this process is killed. What else it prints is
/// discarded.
/// @throws base::RunError if no process or pipe can be made.
Reply Ask(const Program& program, std::string_view question);

/// Of a name without '/' the first file in PATH that can be executed; nullopt if there is none.
std::optional<std::filesystem::path> Find(const std::string& name);

/// One line of plain ASCII of at most so many characters, the end of the text: what is not
/// printable becomes '?', lines are joined by " | ".
std::string LastWords(std::string_view text, std::size_t max_characters);

/// A program that is given bytes and whose exit code says whether it took them; killed if this is
/// destroyed before Finish, or this process is killed.
class Feed {
 public:
  /// Program::limit_s is how long it may take no byte, and how long it may take to end after them.
  /// @param name  for messages: what is made
  /// @throws base::RunError if no process or pipe can be made.
  Feed(const Program& program, std::string name);
  ~Feed();
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  /// @throws base::RunError with the program's last words if it has ended or takes nothing more.
  void Write(std::span<const std::uint8_t> bytes);
  /// No more bytes: waits for the program's end.
  /// @throws base::RunError with its last words if it does not end, or not with code 0.
  void Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// For libraries that crash where there is no memory.
/// @throws base::RunError if a limit of this process (ulimit -v) leaves less.
void NeedMemory(std::size_t bytes);

/// A new, private temporary folder; it is removed with its contents.
class OwnFolder {
 public:
  /// @throws base::RunError if it cannot be made.
  OwnFolder();
  ~OwnFolder();
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }  ///< without links in it

 private:
  std::filesystem::path path_;
};

/// What a program in a sandbox sees of the file system: all of it to read, with these exceptions.
struct Box {
  std::filesystem::path folder;               ///< its own, which it may write
  std::vector<std::filesystem::path> hidden;  ///< these are empty; those that are absent stay so
  /// Visible within what is hidden (where the program itself lies); never one that is hidden itself
  /// or holds something hidden.
  std::vector<std::filesystem::path> shown;
};

/// The command that runs another in a sandbox (bubblewrap): files as the box says, temporary
/// folders and /run hidden, no network, other processes or privileges; it ends with its parent.
std::vector<std::string> InSandbox(const std::vector<std::string>& command, const Box& box);

/// Why no sandbox can be made here, and the cure; nullopt if one can. Starts one to find out.
std::optional<std::string> WhyNoSandbox();

}  // namespace rangegrasp::process
