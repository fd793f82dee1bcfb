#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"

namespace rangegrasp::base {

/// A word of a system that this program was built without: of a command, a task, an option, a key
/// ("views"), or a key's value ("grasp.take=handle").
struct WordNotBuilt {
  std::string_view kind;  ///< "command", "task", "option", "key", "value"
  std::string_view word;
  std::string_view system;
};

/// Something is asked for that belongs to such a system. What starts the program
/// (scripts/rangegrasp) may build the system and try again.
class NotBuilt : public InputError {
 public:
  NotBuilt(const std::string& where, const WordNotBuilt& word);
  const std::string& system() const { return system_; }

 private:
  std::string system_;
};

/// The texts must last as long as the program.
void AddWordNotBuilt(const WordNotBuilt& word);

/// nullopt: no system has such a word, or it is built.
std::optional<WordNotBuilt> FindNotBuilt(std::string_view kind, std::string_view word);

/// Nothing for other words. @param where  "file:line: " or empty, goes before the message
/// @throws NotBuilt for a word of a system that is not built.
void CheckBuilt(std::string_view kind, std::string_view word, const std::string& where = "");

}  // namespace rangegrasp::base
