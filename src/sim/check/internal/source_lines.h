#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>

namespace rangegrasp::check::internal {

/// Where the elements of an MJCF file stand, those of the files that it includes or attaches among
/// them. Elements are known by their kind ("body", "joint", "geom", "site", "actuator", "tuple",
/// "numeric", "camera", "mesh", "sensor") and the name that they have in the compiled model, with
/// the prefixes of all attachments.
class SourceLines {
 public:
  /// @throws base::InputError if the file itself is no XML; files below it that cannot be read are
  /// left to the engine.
  explicit SourceLines(const std::filesystem::path& mjcf);

  /// "arm.xml:33", the path as the first file gives it; the first file alone if it is unknown.
  std::string Of(const std::string& kind, const std::string& name) const;
  /// Where new elements for the part of the model go that an element belongs to: its file alone.
  std::string FileOf(const std::string& kind, const std::string& name) const;
  /// The line of the `<joint>` in the `<default>` of a file: the one place to change all joints.
  /// Empty if there is none.
  std::string JointDefaultOf(const std::string& file) const;
  /// What the file itself (with what it includes, without what it attaches) holds: "freejoint", and
  /// of named elements the kind and what follows the last '/' of the name: "tuple arm_joints".
  const std::set<std::string>& seen() const { return seen_; }
  /// The most joints that lie between the world and one body of the file itself.
  int longest_chain() const { return longest_chain_; }

 private:
  struct Line {
    std::string file;
    int line;
  };
  struct Reader;

  std::string root_;
  std::map<std::string, Line> lines_;         // "joint arm/joint1"
  std::map<std::string, int> joint_default_;  // by file
  std::set<std::string> seen_;
  int longest_chain_ = 0;
};

}  // namespace rangegrasp::check::internal
