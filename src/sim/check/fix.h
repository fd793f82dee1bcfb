#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/error.h"

namespace rangegrasp::check {

/// The edits that give a numeric of a scene's files other values; none if it is not found.
std::vector<base::Edit> SetNumeric(const std::filesystem::path& scene, const std::string& name,
                                   const std::string& data);
/// The edits that multiply the stiffness of the drives of some of an arm's joints, counted from 0.
std::vector<base::Edit> StifferDrives(const std::filesystem::path& scene,
                                      const std::vector<int>& joints, double times);

/// Attributes, as in a file, that would make the equalities of a scene's hand firmer, or the
/// contacts of its fingertips; empty if they are firm already.
std::string FirmerEqualities(const std::filesystem::path& scene);
std::string FirmerTips(const std::filesystem::path& scene);

/// The effect of an edit on a file; `before` is empty for an added block.
struct Change {
  std::filesystem::path file;
  int line = 0;
  std::string before, after;
};

/// Applies one edit to an XML text. Attributes are set in place or appended; a block is indented as
/// the first child of its element. All other bytes stay. If nothing matches, nothing changes.
/// @return the changes, without the file
std::vector<Change> ApplyEdit(const base::Edit& edit, std::string& text);

/// Applies the edits of findings to copies of a model's files, NAME.fixed.xml next to NAME.xml: to
/// the edited files and to those that include or attach them. Or edits in place and keeps the
/// original bytes in NAME.xml.bak (NAME.xml.bak2 if that exists).
class Fixer {
 public:
  Fixer(const std::filesystem::path& mjcf, bool in_place)
      : mjcf_(mjcf.lexically_normal()), in_place_(in_place) {}

  /// Writes the changed files, each in one step.
  /// @param findings  first of the model, later of file()
  /// @return whether anything changed
  /// @throws base::InputError before anything is written, if such a copy already exists.
  bool Apply(const std::vector<base::Finding>& findings);

  /// Applies and checks again until nothing changes, or for a few rounds: a fix can reveal other
  /// faults.
  /// @param findings  of the model
  /// @param check  checks file()
  void Run(std::vector<base::Finding> findings,
           const std::function<std::vector<base::Finding>()>& check);

  /// The file to check: the copy, once there is one.
  std::filesystem::path file() const { return Target(mjcf_); }
  /// All changes so far, in the order in which they were made, with their present line numbers.
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
  std::map<Path, std::string> texts_;  // edited text by original
  std::map<Path, Path> targets_;       // of edited files, by original
  std::vector<Change> changes_;        // with the original as file
};

}  // namespace rangegrasp::check
