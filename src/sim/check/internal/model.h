#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "sim/check/check.h"

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

/// A compiled file that is being checked, what it holds by this project's names, and what has been
/// found so far. Checks look at it one after the other; what a name does not lead to is -1 or
/// empty, and a check that needs it passes over it.
class Model {
 public:
  Model(const std::filesystem::path& mjcf, Kind kind);

  const mjModel& m() const { return *model_; }
  mjModel& m() { return *model_; }
  mjData& d() const { return *data_; }
  const std::filesystem::path& file() const { return file_; }
  Kind kind() const { return kind_; }
  bool HasArm() const { return kind_ == Kind::kScene || kind_ == Kind::kArm; }

  std::string Name(mjtObj type, int id) const;
  /// All elements whose name ends so, after any prefix.
  std::vector<int> FindAll(mjtObj type, std::string_view suffix) const;
  int Find(mjtObj type, std::string_view suffix) const;  ///< the first; -1
  /// Elements of a tuple, of one type; empty if there is none, or one of another type.
  std::vector<int> Tuple(std::string_view suffix, mjtObj type) const;
  std::vector<double> Numeric(std::string_view suffix) const;

  /// `joint "arm/joint1"` and the place in the files; of a nameless geom its body's.
  std::string Element(mjtObj type, int id) const;
  std::string Where(mjtObj type, int id) const;
  std::string WhereMesh(int mesh) const;
  /// The file that the arm's (hand's, if it has a body "hand" of its own) new elements go to.
  std::string ArmFile() const;
  std::string HandFile() const;
  const SourceLines& lines() const { return lines_; }

  /// Of an element, at its place.
  void Error(mjtObj type, int id, const std::string& what, const std::string& cure);
  void Error(const std::string& where, const std::string& element, const std::string& what,
             const std::string& cure);
  void Warn(const std::string& where, const std::string& element, const std::string& what,
            const std::string& cure);
  const std::vector<base::Finding>& findings() const { return findings_; }
  bool HasErrors() const { return base::HasError(findings_); }

  bool InSubtree(int body, int root) const;
  bool Collides(int geom) const;
  /// Of a body's name without a name "body 3".
  std::string BodyName(int body) const;
  /// Names of joints, bodies ... as a list in a sentence.
  std::string NamesOf(mjtObj type, const std::vector<int>& ids) const;
  /// What the arm's joints move and the first of its bodies that moves; -1 without joints.
  int first_moving() const { return arm_joints.empty() ? -1 : m().jnt_bodyid[arm_joints.front()]; }
  bool IsRobot(int body) const;

  /// By tuples; guessed where the file has none: the hinges between the world and the hand, or the
  /// longest chain of hinges.
  std::vector<int> arm_joints, arm_actuators;
  bool guessed_joints = false;
  int hand = -1;             ///< body
  std::vector<double> home;  ///< empty if it is missing or of another length
  void SetHome();            ///< joints to home; to the middle of their ranges without one

 private:
  void FindArm();

  std::filesystem::path file_;
  Kind kind_;
  SourceLines lines_;
  std::shared_ptr<mjModel> model_;
  std::unique_ptr<mjData, void (*)(mjData*)> data_;
  std::vector<base::Finding> findings_;
};

}  // namespace rangegrasp::check::internal
