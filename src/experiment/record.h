#pragma once

#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace rangegrasp::experiment {

/// What a case is: flat values under the task's own words, in their order.
class Params {
 public:
  using Value = std::variant<std::int64_t, double, std::string>;

  Params() = default;
  Params(std::initializer_list<std::pair<std::string, Value>> values) : values_(values) {}
  /// @throws base::InputError if the text is no JSON object of numbers and texts.
  static Params FromJson(const std::string& text);

  void Add(const std::string& name, Value value) { values_.emplace_back(name, std::move(value)); }
  bool Has(std::string_view name) const;
  // @throws base::InputError if there is none of this name, or one of another type.
  const std::string& Text(std::string_view name) const;
  int Int(std::string_view name) const;
  double Number(std::string_view name) const;
  const std::vector<std::pair<std::string, Value>>& values() const { return values_; }
  bool operator==(const Params&) const = default;

 private:
  std::vector<std::pair<std::string, Value>> values_;
};
std::string ToJson(const Params& params);

/// The smallest thing that is run, stored and repeated: one grasp trial, one seam, one method on
/// one model. It depends on the experiment and on itself alone.
struct Case {
  std::string id;          ///< unique in its experiment: letters, digits, '_', '-', '.'
  std::string group;       ///< what --objects chooses by: an object, a class, a shape of edge
  std::uint64_t seed = 0;  ///< derived from the experiment's seed and this case alone
  Params params;
  int position = 0;  ///< among the experiment's cases, from 0; the engine sets it
};

/// What running a case gave.
struct Result {
  std::string outcome;      ///< one word of the task's, or kCrashed or kTimedOut
  std::string stage;        ///< that it ended in
  std::string detail;       ///< one line for a person
  std::string data = "{}";  ///< JSON object: figures, written so that they are read back the same
  /// Time by stage [s]: all that may differ between two runs of the same case.
  std::vector<std::pair<std::string, double>> seconds;
};
/// The engine's own outcomes: the process ended without a result, or was killed at its time limit.
/// Their `data` is "{}".
inline constexpr const char* kCrashed = "crashed";
inline constexpr const char* kTimedOut = "timed_out";

/// A row of the store.
struct Record {
  Case which;
  Result result;
};

/// One JSON object; bytes that are no UTF-8 are replaced. @throws base::RunError if `data` is no
/// JSON
std::string ToJson(const Record& record);

/// Whether two records say the same but for their times.
bool SameButTimes(const Record& a, const Record& b);

/// The groups of cases or records, in the order in which they first occur.
std::vector<std::string> GroupsOf(const std::vector<Case>& cases);
std::vector<std::string> GroupsOf(const std::vector<Record>& records);

/// What a run came from: name -> value each.
struct Stamp {
  /// What two runs must share for their cases to stand in one table: experiment, hashes, seed,
  /// cases, the versions of what computes them.
  std::map<std::string, std::string> identity;
  std::map<std::string, std::string> build;  ///< version and commit: shown, not compared
  /// What the tables need besides the records: titles, published tables, the experiment file.
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

/// The value of a name, or another one where it has none.
std::string ValueOr(const std::map<std::string, std::string>& part, const std::string& name,
                    const std::string& otherwise);
/// A value that the tables cannot do without.
/// @throws base::InputError if the stamp has none (a run that was killed at its start).
const std::string& Need(const std::map<std::string, std::string>& part, const std::string& name);

/// How many cases the experiment has. @throws base::InputError if that is no whole number.
/// @param where  the stamp is from, for messages
std::size_t CasesOf(const Stamp& stamp, const std::string& where);

/// "laser_single: rangegrasp 0.2.0 (0123abcd), seed 1, ..." for below a table.
std::string LineOf(const Stamp& stamp);

/// Adds to a stage's time; a stage that is not there yet comes last.
void AddSeconds(const std::string& stage, double seconds,
                std::vector<std::pair<std::string, double>>& sums);

}  // namespace rangegrasp::experiment
