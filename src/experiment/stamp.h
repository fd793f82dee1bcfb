#pragma once

#include <map>
#include <string>

namespace rangegrasp::experiment {

/// What a run came from: name -> value each.
struct Stamp {
  /// What two runs must share for their cases to stand in one table: experiment, hashes, seed,
  /// cases, the versions of what computes them.
  std::map<std::string, std::string> identity;
  std::map<std::string, std::string> build;  ///< version and commit: shown, not compared
  /// What the tables are made from besides the records: titles, published tables, the experiment
  /// file itself.
  std::map<std::string, std::string> data;

  bool operator==(const Stamp&) const = default;
};

/// Stamp::data: what a group is called in tables, "title.<group>".
inline constexpr const char* kTitlePrefix = "title.";
/// That, or the group itself where it has none.
std::string TitleOf(const Stamp& stamp, const std::string& group);

/// @throws base::InputError that begins with `where` and names the first value of `identity` in
/// which they differ.
void CheckSameRun(const Stamp& stored, const Stamp& wanted, const std::string& where);

/// A value that the tables cannot do without.
/// @throws base::InputError if the stamp has none (a run that was killed at its start).
const std::string& Need(const std::map<std::string, std::string>& part, const std::string& name);

/// "laser_single: rangegrasp 0.1.0 (0123abcd), seed 1, ..." for below a table.
std::string LineOf(const Stamp& stamp);

}  // namespace rangegrasp::experiment
