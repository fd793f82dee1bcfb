#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/check/check.h"
#include "sim/internal/engine.h"

namespace rangegrasp::check::internal {

/// Depth up to which attached files are read; the engine refuses files that attach each other in a
/// ring.
constexpr int kMaxDepth = 8;

constexpr const char* kUnnamedDrive = "unnamed actuator of joint";

/// Source positions of the elements of an MJCF file and of those that it includes or attaches, by
/// kind ("body", "joint", "geom", "site", "actuator", "tuple", "numeric", "camera", "mesh",
/// "sensor") and by name in the compiled model, with the prefixes of all attachments. An actuator
/// without a name is found by the name of its joint (kind kUnnamedDrive).
class SourceLines {
 public:
  /// @throws base::InputError if the file itself is not XML; unreadable files below it are left to
  /// the engine.
  explicit SourceLines(const std::filesystem::path& mjcf);

  /// "arm.xml:33", the path as in the first file; only the first file if the element is unknown.
  std::string Of(const std::string& kind, const std::string& name) const;
  /// Its file alone, to which new elements of the same part of the model are added.
  std::string FileOf(const std::string& kind, const std::string& name) const;
  /// The element as an XPath in its file; else the first element with this name after a prefix.
  std::optional<base::Edit> EditOf(const std::string& kind, const std::string& name) const;
  /// What the file itself (with its includes, without its attachments) contains: "freejoint", and
  /// for named elements the kind and the name after its last '/': "tuple arm_joints".
  const std::set<std::string>& seen() const { return seen_; }
  /// The largest number of joints between the world and one body of the file itself.
  int longest_chain() const { return longest_chain_; }

 private:
  struct Line {
    std::string file;
    int line;
    std::string element;  // XPath
  };
  struct Reader;

  std::string root_;
  std::map<std::string, Line> lines_;  // "joint arm/joint1"
  std::set<std::string> seen_;
  int longest_chain_ = 0;
};

using Attributes = std::vector<std::pair<std::string, std::string>>;

/// `a="1" b="2"`, without the empty ones.
std::string TextOf(const Attributes& attributes);

/// Fix of a finding: edits where they are definite, and any additional text.
struct Cure {
  Cure() = default;
  Cure(const char* said) : text(said) {}             // NOLINT: a text is a cure
  Cure(std::string said) : text(std::move(said)) {}  // NOLINT
  explicit Cure(std::vector<base::Edit> made) : edits(std::move(made)) {}
  /// Inserts a block into a section of a file, or into another element of it.
  static Cure Insert(const std::string& file, const std::string& element,
                     const std::string& block) {
    return Cure({base::Edit{.file = file, .element = element, .block = block}});
  }
  Cure& operator+=(const Cure& more) {
    edits.insert(edits.end(), more.edits.begin(), more.edits.end());
    text += more.text;
    return *this;
  }
  friend Cure operator+(Cure cure, const Cure& more) { return cure += more; }
  bool empty() const { return text.empty() && edits.empty(); }

  std::string text;
  std::vector<base::Edit> edits;
};

/// A compiled file that is being checked, and the findings so far. A name that is not found gives
/// -1 or an empty value, and a check that needs it is skipped.
class Model {
 public:
  Model(const std::filesystem::path& mjcf, Kind kind);

  const mjModel& m() const { return *model_; }
  mjModel& m() { return *model_; }
  mjData& d() const { return *data_; }
  const std::filesystem::path& file() const { return file_; }
  Kind kind() const { return kind_; }
  bool HasArm() const { return kind_ == Kind::kScene || kind_ == Kind::kArm; }

  std::string Name(mjtObj type, int id) const { return std::string(mjcf::NameOf(&m(), type, id)); }
  /// All elements with this name after any prefix.
  std::vector<int> FindAll(mjtObj type, std::string_view suffix) const;
  /// The first of them, or -1.
  int Find(mjtObj type, std::string_view suffix) const { return mjcf::TryFind(&m(), type, suffix); }
  /// Elements of a tuple, all of one type; empty if there is no tuple, or it has another type.
  std::vector<int> Tuple(std::string_view suffix, mjtObj type) const;
  std::vector<double> Numeric(std::string_view suffix) const {
    return mjcf::NumericOf(&m(), suffix);
  }

  /// `joint "arm/joint1"` and its place in the files; for a nameless geom those of its body.
  std::string Element(mjtObj type, int id) const;
  std::string Where(mjtObj type, int id) const;
  /// The file to which new elements of the arm (of the hand) are added.
  std::string ArmFile() const;
  std::string HandFile() const;
  const SourceLines& lines() const { return lines_; }

  /// Sets attributes of an element; only as text if the element has no name.
  Cure Set(mjtObj type, int id, const Attributes& attributes) const;
  /// Replaces an element by another one.
  Cure Replace(mjtObj type, int id, const std::string& block) const;
  /// Sets a numeric's values; adds it to the file if there is none yet. The user writes values that
  /// are not known (`data` is empty).
  Cure SetNumeric(const std::string& name, const std::string& data, const std::string& file) const;
  /// The same for a tuple. The user completes it if there are no elements, or ones without names.
  Cure SetTuple(const std::string& name, mjtObj type, const std::vector<int>& ids,
                const std::string& file) const;
  /// Multiplies a servo's stiffness and keeps its damping ratio.
  Cure Stiffer(int actuator, double times) const;
  /// Renames a body, only in its own file, with all references to it there.
  Cure Rename(int body, const std::string& name) const;
  /// Excludes contacts between two bodies.
  Cure Exclude(int body1, int body2) const;

  void Report(bool error, std::string where, std::string element, std::string what, Cure cure) {
    findings_.push_back({error, std::move(where), std::move(element), std::move(what),
                         std::move(cure.text), std::move(cure.edits)});
  }
  /// Reports on an element, at its place.
  void Report(bool error, mjtObj type, int id, const std::string& what, const Cure& cure) {
    Report(error, Where(type, id), Element(type, id), what, cure);
  }
  /// Reports on one of this project's names, without its prefix.
  void Report(bool error, mjtObj type, const std::string& name, const std::string& what,
              const Cure& cure);
  /// Reports on several elements, at the place of the first.
  void Report(bool error, mjtObj type, const std::vector<int>& ids, const std::string& what,
              const Cure& cure);
  void Error(const auto&... of) { Report(true, of...); }
  void Warn(const auto&... of) { Report(false, of...); }
  const std::vector<base::Finding>& findings() const { return findings_; }
  bool HasErrors() const { return base::HasError(findings_); }

  bool InSubtree(int body, int root) const { return mjcf::InSubtree(&m(), body, root); }
  bool Collides(int geom) const { return mjcf::Collides(&m(), geom); }
  /// "body 3" if it has no name.
  std::string BodyName(int body) const;
  std::string BothNames(int body1, int body2) const;  ///< `bodies "a" and "b"`
  /// As a list for a sentence.
  std::string NamesOf(mjtObj type, const std::vector<int>& ids) const;
  /// Range of a joint; from -continuous_rad to +continuous_rad if it has no limits.
  std::pair<double, double> RangeOf(int joint, double continuous_rad) const {
    const mjtNum* range = m().jnt_range + 2 * joint;
    return m().jnt_limited[joint] ? std::pair(range[0], range[1])
                                  : std::pair(-continuous_rad, continuous_rad);
  }
  bool IsRobot(int body) const;
  std::vector<int> RobotBodies() const;
  /// The first body of the finger (mjcf::HandBranch) that a body of the hand belongs to.
  int Finger(int body) const { return mjcf::HandBranch(&m(), body, hand); }

  /// From tuples. Guessed if the file has none: the hinges between the world and the hand, or the
  /// longest chain of hinges.
  std::vector<int> arm_joints, arm_actuators;
  int hand = -1;                         ///< body
  std::vector<double> home;              ///< empty if missing or of another length
  int DriveOf(int joint) const;          ///< the first actuator on it, or -1
  std::vector<int> DrivesOfArm() const;  ///< of all arm_joints; empty if one has none
  void SetArm(const double* q);          ///< moves arm_joints and all that they carry
  void SetHome();  ///< moves joints to home, or without it to the middle of their ranges

 private:
  void FindArm();
  /// Kind and name by which SourceLines finds an element.
  std::pair<std::string, std::string> KeyOf(mjtObj type, int id) const;
  /// The name of a geom in its file; adds the edit that gives it one if needed. Empty if the file
  /// does not show which geom it is.
  std::string NameGeom(int geom, Cure& cure) const;
  /// The same for an actuator on a joint, in the file of the joint.
  std::string NameDrive(int actuator, Cure& cure) const;

  std::filesystem::path file_;
  Kind kind_;
  SourceLines lines_;
  sim::internal::ModelPtr model_;
  sim::internal::DataPtr data_;
  std::vector<base::Finding> findings_;
};

}  // namespace rangegrasp::check::internal
