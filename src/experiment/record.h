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

/// The parameters of a case: a flat list of values, named and ordered by the task.
class Params {
 public:
  using Value = std::variant<std::int64_t, double, std::string>;

  Params() = default;
  Params(std::initializer_list<std::pair<std::string, Value>> values) : values_(values) {}
  /// @throws base::InputError if the text is not a JSON object of numbers and texts.
  static Params FromJson(const std::string& text);

  void Add(const std::string& name, Value value) { values_.emplace_back(name, std::move(value)); }
  bool Has(std::string_view name) const;
  // @throws base::InputError if there is no value of this name, or it has another type.
  const std::string& Text(std::string_view name) const;
  int Int(std::string_view name) const;
  double Number(std::string_view name) const;
  const std::vector<std::pair<std::string, Value>>& values() const { return values_; }
  bool operator==(const Params&) const = default;

 private:
  std::vector<std::pair<std::string, Value>> values_;
};
std::string ToJson(const Params& params);

/// The smallest unit that is run, stored and repeated: one grasp trial, one seam, one method on one
/// model. It depends only on the experiment and on itself.
struct Case {
  std::string id;          ///< unique in its experiment: letters, digits, '_', '-', '.'
  std::string group;       ///< selected by --objects: an object, a class, a shape of edge
  std::uint64_t seed = 0;  ///< derived only from the experiment's seed and this case
  Params params;
  int position = 0;  ///< index among the experiment's cases, from 0; set by the engine
};

/// The result of running a case.
struct Result {
  std::string outcome;      ///< one of the task's words, or kCrashed or kTimedOut
  std::string stage;        ///< stage in which it ended
  std::string detail;       ///< one line for the user
  std::string data = "{}";  ///< JSON object of figures, written so that reading gives equal values
  /// Time per stage [s]: the only part that may differ between two runs of the same case.
  std::vector<std::pair<std::string, double>> seconds;
};
// Outcomes set by the engine; their `data` is "{}".
inline constexpr const char* kCrashed = "crashed";     ///< the process ended without a result
inline constexpr const char* kTimedOut = "timed_out";  ///< it was killed at its time limit

/// A row of the store.
struct Record {
  Case which;
  Result result;
};

/// The record as one JSON object; invalid UTF-8 is replaced.
/// @throws base::RunError if `data` is not JSON
std::string ToJson(const Record& record);

/// Whether two records are equal except for their times.
bool SameButTimes(const Record& a, const Record& b);

/// The groups of cases or records, in the order in which they first occur.
std::vector<std::string> GroupsOf(const std::vector<Case>& cases);
std::vector<std::string> GroupsOf(const std::vector<Record>& records);

/// The origin of a run, as maps name -> value.
struct Stamp {
  /// Values that must be equal for the cases of two runs to appear in one table: experiment,
  /// hashes, seed, cases, and the versions of the software that computes them.
  std::map<std::string, std::string> identity;
  std::map<std::string, std::string> build;  ///< version and commit: shown, not compared
  /// Data for the tables in addition to records: titles, published tables, the experiment file.
  std::map<std::string, std::string> data;

  bool operator==(const Stamp&) const = default;
};

/// Name in Stamp::data of the key that --trials sets (TaskKind::trials_key). Older stamps lack it.
inline constexpr const char* kTrialsKey = "trials_key";
/// Name in Stamp::data of a run's success, if it is not TaskKind::success.
inline constexpr const char* kSuccess = "success";

/// Name of a group's title for tables in Stamp::data: "title.<group>".
inline constexpr const char* kTitlePrefix = "title.";
/// The title of a group, or the group itself if it has none.
std::string TitleOf(const Stamp& stamp, const std::string& group);

/// Whether a line of an experiment file ("seed: 1") or of --set ("seed=1") sets the seed or the
/// number of trials, which the experiment's hash leaves out: each is a value of the stamp.
bool SetsSeedOrTrials(std::string_view line, std::string_view trials_key);

/// Adds a commit to those that made a run's rows besides the first one, so that rows from different
/// commits do not look as if they came from one commit.
void AddCommit(const std::string& commit, Stamp& stamp);

/// Experiment files that differ only in lines that are comments are the same.
/// @throws base::InputError: `where`, the first value that differs, and the remedy.
void CheckSameRun(const Stamp& stored, const Stamp& wanted, const std::string& where,
                  const std::string& remedy);

/// The value of a name, or `otherwise` if it has none.
std::string ValueOr(const std::map<std::string, std::string>& part, const std::string& name,
                    const std::string& otherwise);
/// A value that the tables require.
/// @throws base::InputError if the stamp lacks it (a run that was killed at its start).
const std::string& Need(const std::map<std::string, std::string>& part, const std::string& name);

/// The number of cases of the experiment. @throws base::InputError if it is not a whole number.
/// @param where  origin of the stamp, for messages
std::size_t CasesOf(const Stamp& stamp, const std::string& where);

/// The line below a table: "laser_single: rangegrasp 0.2.0 (0123abcd), seed 1, ...".
std::string LineOf(const Stamp& stamp);

/// Adds to a stage's time; a new stage is appended.
void AddSeconds(const std::string& stage, double seconds,
                std::vector<std::pair<std::string, double>>& sums);

}  // namespace rangegrasp::experiment
