#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"

namespace rangegrasp::check {

/// What an edit did to a file; of an added block `before` is empty.
struct Change {
  std::filesystem::path file;
  int line = 0;
  std::string before, after;
};

/// One edit of an XML text; all other bytes stay. Attributes are set in place or appended, a block
/// is indented as the first thing in its element. An edit that finds nothing to change changes
/// nothing.
/// @param file  for the changes
std::vector<Change> ApplyEdit(const base::Edit& edit, const std::filesystem::path& file,
                              std::string& text);

/// Makes the edits of findings in copies of a model's files, NAME.fixed.xml next to NAME.xml: of
/// the model itself, of what it includes or attaches where that is edited, and of what refers to
/// it. Or in the files themselves, each with its bytes before in FILE.bak.
class Fixer {
 public:
  Fixer(const std::filesystem::path& mjcf, bool in_place)
      : mjcf_(mjcf.lexically_normal()), in_place_(in_place) {}

  /// Writes what changes; each file in one step.
  /// @param findings  of the model, then of file()
  /// @return whether anything changed
  /// @throws base::InputError in place, before anything is written, if one has a backup already.
  bool Apply(const std::vector<base::Finding>& findings);

  /// What is to be checked: the copy, once there is one.
  std::filesystem::path file() const { return Target(mjcf_); }
  /// All that were made so far, with their lines in the files as they are now.
  std::vector<Change> changes() const;

 private:
  std::filesystem::path Original(const std::filesystem::path& file) const;
  std::filesystem::path Target(const std::filesystem::path& original) const;
  const std::string& Text(const std::filesystem::path& original);
  std::vector<std::filesystem::path> References(const std::filesystem::path& original);
  static void Back(const std::set<std::filesystem::path>& files);
  bool Refer(const std::filesystem::path& original, int depth);

  std::filesystem::path mjcf_;
  bool in_place_;
  std::map<std::filesystem::path, std::string> texts_;              // by original, as edited
  std::map<std::filesystem::path, std::filesystem::path> targets_;  // of the edited ones
  std::vector<Change> changes_;
};

}  // namespace rangegrasp::check
