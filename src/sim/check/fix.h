#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/error.h"

namespace rangegrasp::check {

/// The edits that give a numeric of a scene's files other values; none where it is not found.
std::vector<base::Edit> SetNumeric(const std::filesystem::path& scene, const std::string& name,
                                   const std::string& data);
/// The edits that make the drives of some of an arm's joints, counted from 0, so many times as
/// stiff.
std::vector<base::Edit> StifferDrives(const std::filesystem::path& scene,
                                      const std::vector<int>& joints, double times);

/// What an edit did to a file; of an added block `before` is empty.
struct Change {
  std::filesystem::path file;
  int line = 0;
  std::string before, after;
};

/// One edit of an XML text. Attributes are set in place or appended, a block is indented as the
/// first thing in its element; all other bytes stay. Where nothing matches, nothing changes.
/// @return what changed, without the file
std::vector<Change> ApplyEdit(const base::Edit& edit, std::string& text);

/// Makes the edits of findings in copies of a model's files, NAME.fixed.xml next to NAME.xml: of
/// what is edited, and of what includes or attaches that. Or in place, with the bytes before in
/// NAME.xml.bak.
class Fixer {
 public:
  Fixer(const std::filesystem::path& mjcf, bool in_place)
      : mjcf_(mjcf.lexically_normal()), in_place_(in_place) {}

  /// Writes what changes, each file in one step.
  /// @param findings  of the model, then of file()
  /// @return whether anything changed
  /// @throws base::InputError before anything is written, if there is such a copy or backup
  /// already.
  bool Apply(const std::vector<base::Finding>& findings);

  /// Applies and checks again, until nothing changes or for a few rounds: what is cured shows what
  /// else is wrong.
  /// @param findings  of the model
  /// @param check  of file()
  void Run(std::vector<base::Finding> findings,
           const std::function<std::vector<base::Finding>()>& check);

  /// What is to be checked: the copy, once there is one.
  std::filesystem::path file() const { return Target(mjcf_); }
  /// Of all edits so far, in the order in which they were made, with the lines as they are now.
  std::vector<Change> changes() const;

 private:
  using Path = std::filesystem::path;

  Path Original(const Path& file) const;
  Path Target(const Path& original) const;
  std::string& Text(const Path& original);
  void Edit(const Path& original, const base::Edit& edit);
  bool Refer(const Path& original, int depth);

  Path mjcf_;
  bool in_place_;
  std::map<Path, std::string> texts_;  // by original, as edited
  std::map<Path, Path> targets_;       // of what is edited
  std::vector<Change> changes_;        // by original
};

}  // namespace rangegrasp::check
