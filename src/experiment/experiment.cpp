#include "experiment/experiment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>

#include "base/error.h"
#include "base/file.h"
#include "base/installation.h"
#include "base/pattern.h"

namespace rangegrasp::experiment {
namespace {

namespace fs = std::filesystem;

std::vector<TaskKind>& Kinds() {
  static std::vector<TaskKind> kinds;
  return kinds;
}

using base::YamlMap;

// A case may take a day. A second is less than the start of any case takes.
constexpr double kMinLimit_s = 1.0;
constexpr double kMaxLimit_s = 86400.0;
constexpr int kMaxStopAfter = 1'000'000;

// The first line of the copy of an experiment file in a results folder, up to the folder.
constexpr const char* kCopy = "# Experiment file of a run; relative paths are relative to ";

// What to do after an error in such a copy; empty for another file.
std::string CureOfCopy(const std::string& text) {
  if (!text.starts_with(kCopy)) return "";
  const std::string line = text.substr(0, text.find(".\n"));
  return "; this is the copy of a run's file, whose relative paths are relative to " +
         line.substr(std::string_view(kCopy).size()) +
         ": give the original file, or put the copy into that folder";
}

const TaskKind* FindKind(const std::string& word) {
  const auto found = std::ranges::find(Kinds(), word, &TaskKind::name);
  return found == Kinds().end() ? nullptr : &*found;
}

std::vector<std::string> KindNames() {
  std::vector<std::string> names;
  std::ranges::transform(Kinds(), std::back_inserter(names), &TaskKind::name);
  return names;
}

std::string TaskWord(YamlMap& map) {
  std::string word = "grasping";
  map.Read("task", word, "kind of experiment: " + base::Join(KindNames()));
  return word;
}

const TaskKind& ReadKind(YamlMap& map) {
  const std::string word = TaskWord(map);
  if (const TaskKind* kind = FindKind(word)) return *kind;
  base::CheckBuilt("task", word, map.file().string() + ": ");
  map.Fail("task", base::MustBeOneOf(word, KindNames()));
}

// Seed, number of trials and groups are separate values of the stamp and may be set on the command
// line. The hash excludes them, so that runs that differ in nothing else can be recognised.
std::string HashOf(const std::string& text, const std::vector<std::string>& set,
                   const TaskKind& kind) {
  std::uint64_t hash = base::Fnv1a("");
  auto lines = base::Split(text, '\n');
  lines.insert(lines.end(), set.begin(), set.end());
  for (const std::string& line : lines) {
    if (!SetsSeedOrTrials(line, kind.trials_key)) hash = base::Fnv1a(line + "\n", hash);
  }
  return base::Hex(hash);
}

void KeepGroups(const std::vector<std::string>& wanted, const fs::path& file,
                std::vector<Case>& cases) {
  if (wanted.empty()) return;
  const auto known = GroupsOf(cases);
  for (const std::string& group : wanted) {
    if (std::ranges::find(known, group) != known.end()) continue;
    throw base::InputError(
        file.string() + ": has no '" + group + "'" +
        base::Suggestion(group, known, "; did you mean '{}'?") + " (the groups of its tables are " +
        base::Join(known) +
        "; others need an experiment file that lists them, or more trials if the objects take " +
        "turns)");
  }
  std::erase_if(cases,
                [&](const Case& c) { return std::ranges::find(wanted, c.group) == wanted.end(); });
}

void SetPositions(std::vector<Case>& cases, const fs::path& file) {
  std::set<std::string> seen;
  for (Case& c : cases) {
    c.position = static_cast<int>(seen.size());
    if (seen.insert(c.id).second) continue;
    throw base::InputError(file.string() + ": case '" + c.id + "' is given twice");
  }
}

// `detector.command` is the only key that names a program.
void RefuseDetectorCommand(YamlMap map) {
  if (!map.HoldsMap("detector")) return;
  std::vector<std::string> command;
  map.Child("detector").Read("command", command, "");
  if (command.empty()) return;
  // Quoted, since untrusted words may contain control characters.
  map.Fail("detector",
           fmt::format("running cases again would start the program {}, which is named in the "
                       "results; if you trust them, allow it with --run-detector",
                       command));
}

Experiment Open(const std::string& text, const fs::path& file, const Changes& changes,
                const OnFindings& on_findings, bool run_detector) {
  std::vector<std::string> set = changes.set;
  if (!run_detector) RefuseDetectorCommand(YamlMap::FromText(text, file, set));
  YamlMap map = YamlMap::FromText(text, file, set);
  if (!map.Has("name") && !map.Has("task") && !map.Has("scene")) {
    throw base::InputError(file.string() +
                           ": is no experiment: it has neither `name` nor `task` nor `scene`; give "
                           "one that names this file");
  }
  Experiment e;
  e.kind = &ReadKind(map);
  const auto override_key = [&](const std::string& one) {
    set.push_back(one);
    map.Override(one);
  };
  if (changes.trials) override_key(fmt::format("{}={}", e.kind->trials_key, *changes.trials));
  if (changes.seed) {
    if (!e.kind->uses_seed) {
      throw base::InputError("--seed: cannot be used with task '" + e.kind->name +
                             "', which draws no random numbers");
    }
    override_key(fmt::format("seed={}", *changes.seed));
  }
  e.common = {.name = file.stem().string(), .file = file, .on_findings = on_findings};
  ReadCommon(map, e.common);
  e.task = e.kind->read(map, e.common);
  if (!e.task) return e;
  e.cases = e.task->Cases();
  SetPositions(e.cases, file);
  KeepGroups(changes.groups, file, e.cases);
  e.stamp.identity = {{"experiment", e.common.name},
                      {"task", e.kind->name},
                      {"experiment_hash", HashOf(text, set, *e.kind)},
                      {"seed", fmt::format("{}", e.common.seed)},
                      {"cases", fmt::format("{}", e.cases.size())},
                      {"groups", base::Join(GroupsOf(e.cases), ",")}};
  e.stamp.build = {{"version", base::Version()}, {"commit", base::Commit()}};
  e.stamp.data = {{"experiment_file", fs::absolute(file).lexically_normal().string()},
                  {"experiment_text", text},
                  {"set", base::Join(set, "\n")},
                  {kTrialsKey, e.kind->trials_key}};
  e.task->AddTo(e.stamp);
  return e;
}

}  // namespace

void AddKind(const TaskKind& kind) { Kinds().push_back(kind); }
std::span<const TaskKind> AllKinds() { return Kinds(); }

void ReadCommon(YamlMap& map, Common& common) {
  map.Read("name", common.name,
           "name of the experiment and of its results folder; letters, digits, '_' and '-'");
  if (base::FindMatch(common.name, "[^A-Za-z0-9_-]")) {
    map.Fail("name",
             "'" + common.name +
                 "' must consist of letters, digits, '_' and '-': it is the name of a folder");
  }
  map.Read("seed", common.seed, "seed of all random numbers");
  map.Read(
      "trial_limit_s", common.case_limit_s, kMinLimit_s, kMaxLimit_s,
      "computing time after which a trial, seam or model is stopped; if it waits, five times as "
      "long by the clock");
  map.Read("stop_after", common.stop_after, 0, kMaxStopAfter,
           "task: grasping: stop the run early if this number of first trials, taken in turn from "
           "all objects, all fail in the same way; 0: never");
}

Experiment OpenExperiment(const fs::path& file, const Changes& changes,
                          const OnFindings& on_findings) {
  const std::string text = base::ReadFile(file);
  try {
    return Open(text, file, changes, on_findings, /*run_detector=*/true);
  } catch (const base::NotBuilt&) {
    throw;  // the script that started the program may build it
  } catch (const base::InputError& error) {
    const std::string cure = CureOfCopy(text);
    if (cure.empty()) throw;
    throw base::InputError(error.what() + cure);
  }
}

Experiment OpenAgain(const Stamp& stamp, bool run_detector) {
  return Open(Need(stamp.data, "experiment_text"), Need(stamp.data, "experiment_file"),
              {.set = SetOf(stamp), .groups = base::Split(Need(stamp.identity, "groups"), ',')}, {},
              run_detector);
}

std::vector<std::string> SetOf(const Stamp& stamp) {
  auto set = base::Split(Need(stamp.data, "set"), '\n');
  std::erase(set, "");
  return set;
}

std::string FileAsRun(const Stamp& stamp) {
  const fs::path file = Need(stamp.data, "experiment_file");
  std::string text = kCopy + file.parent_path().string() + ".\n";
  text += "# What ran (--objects): " + Need(stamp.identity, "groups") + "\n";
  for (const std::string& one : SetOf(stamp)) {
    text += "# On the command line: --set '" + one + "'\n";
  }
  return text + Need(stamp.data, "experiment_text");
}

const TaskKind& KindOf(const Stamp& stamp) {
  const std::string& word = Need(stamp.identity, "task");
  if (const TaskKind* kind = FindKind(word)) return *kind;
  base::CheckBuilt("task", word, "the results: ");
  throw base::InputError("the results are of task '" + word +
                         "', which is unknown to this program; it knows " +
                         base::Join(KindNames()));
}

std::string SuccessOf(const TaskKind& kind, const Stamp& stamp) {
  return ValueOr(stamp.data, kSuccess, kind.success);
}

namespace {

// The keys of a run's experiment with their values, without the seed and the number of trials.
std::map<std::string, std::string> KeysOf(const Stamp& stamp) {
  // The text is named, not its file, which is not read: only the text may be damaged.
  const std::string name = "experiment_text";
  auto values = YamlMap::FromText(Need(stamp.data, name), name, SetOf(stamp)).Values();
  const std::string trials = KindOf(stamp).trials_key;
  std::erase_if(values, [&](const auto& of) { return SetsSeedOrTrials(of.first, trials); });
  return values;
}

// Fails, with the run's own folder, if its stamp lacks what is compared.
void CheckCompares(const Results& run) {
  InFolder(run.folder, [&] {
    Need(run.stamp.identity, "experiment");
    KeysOf(run.stamp);
  });
}

}  // namespace

std::vector<KeyDifference> DifferingKeys(const Stamp& first, const Stamp& second) {
  const auto one = KeysOf(first), two = KeysOf(second);
  auto all = one;
  all.insert(two.begin(), two.end());
  std::vector<KeyDifference> differing;
  for (const auto& [key, value] : all) {
    KeyDifference values{key, ValueOr(one, key, ""), ValueOr(two, key, "")};
    if (values.first != values.second) differing.push_back(std::move(values));
  }
  return differing;
}

RunComparison CompareRuns(const fs::path& first, const fs::path& second) {
  const Results one = ReadResults(first);
  const Results two = ReadResults(second);
  CheckCompares(one);
  CheckCompares(two);
  const TaskKind& kind = KindOf(one.stamp);
  if (KindOf(two.stamp).name != kind.name) {
    throw base::InputError(fmt::format("{}: has another task than {} ({})", second.string(),
                                       first.string(), kind.name));
  }
  const std::string success = SuccessOf(kind, one.stamp);
  if (success.empty()) {
    throw base::InputError(first.string() +
                           ": its task has no outcome that counts as success; compare the tables "
                           "(`rangegrasp table`)");
  }
  RunComparison compared{Compare(one.records, two.records, success), success, {}, {}};
  if (compared.pairs == 0) {
    throw base::InputError(
        fmt::format("{}, {}: the two runs have no case with the same id and seed", first.string(),
                    second.string()));
  }
  compared.keys = DifferingKeys(one.stamp, two.stamp);
  const std::string& name = Need(one.stamp.identity, "experiment");
  const std::string& other = Need(two.stamp.identity, "experiment");
  if (name != other) {
    compared.warning = fmt::format(
        "{} ({}) and {} ({}) are runs of different experiments: a pair has the same object and "
        "seed, perhaps not the same scene",
        first.string(), name, second.string(), other);
  } else if (const std::string second_success = SuccessOf(kind, two.stamp);
             second_success != success) {
    compared.warning =
        fmt::format("{} counts '{}' as success, {} '{}': both are compared by '{}'", first.string(),
                    success, second.string(), second_success, success);
  }
  return compared;
}

const Case& CaseOf(const Experiment& experiment, const std::string& id) {
  std::vector<std::string> ids;
  for (const Case& c : experiment.cases) {
    if (c.id == id) return c;
    ids.push_back(c.id);
  }
  throw base::InputError("no trial '" + id + "' in experiment " + experiment.common.name +
                         (ids.empty() ? "" : " (its first is '" + ids.front() + "')") +
                         base::Suggestion(id, ids));
}

namespace {

// Whether the report of these records under this stamp fails with the text that is explained.
using FailsAlike = std::function<bool(const Stamp&, const std::vector<Record>&)>;

// The name and beginning of the stamp's value without which it does not; empty if there is none.
std::string ValueAtFault(const FailsAlike& fails, const Stamp& stamp) {
  for (const auto part : {&Stamp::identity, &Stamp::data}) {
    for (const auto& [name, value] : stamp.*part) {
      Stamp without = stamp;
      (without.*part).erase(name);
      if (!fails(without, {})) {
        return fmt::format("stamp '{}' is '{}': ", base::Excerpt(name), base::Excerpt(value));
      }
    }
  }
  return "";
}

// The same for the innermost key of a record's data.
std::string KeyAtFault(const FailsAlike& fails, const Stamp& stamp, Record record) {
  const auto data = nlohmann::ordered_json::parse(record.result.data, nullptr, false);
  nlohmann::ordered_json::json_pointer at;
  std::string path;
  const auto matters = [&](const auto& item) {
    auto without = data;
    without[at].erase(item.key());
    record.result.data = without.dump();
    return !fails(stamp, {record});
  };
  while (data[at].is_object()) {
    const auto items = data[at].items();
    const auto found = std::ranges::find_if(items, matters);
    if (found == items.end()) break;
    path += (path.empty() ? "" : ".") + found.key();
    at /= found.key();
  }
  if (path.empty()) return "";
  return fmt::format("'{}' of its data is {}: ", base::Excerpt(path),
                     base::Excerpt(data[at].dump()));
}

// Why tables cannot be written: the case and its key, or the stamp's value, and what is wrong. The
// reports read thousands of values, most of them without naming the case: the one at fault is the
// one that the failure needs.
std::string ReasonOf(const TaskKind& kind, const Stamp& stamp, const std::vector<Record>& records,
                     const std::string& failure) {
  const FailsAlike fails = [&](const Stamp& with, const std::vector<Record>& some) {
    try {
      kind.report(with, some);
      return false;
    } catch (const std::exception& error) {
      return error.what() == failure;
    }
  };
  std::string reason;
  if (fails(stamp, {})) {
    reason = ValueAtFault(fails, stamp);
  } else {
    const auto fails_alone = [&](const Record& record) { return fails(stamp, {record}); };
    const auto record = std::ranges::find_if(records, fails_alone);
    if (record != records.end()) {
      reason = fmt::format("case {}: {}", record->which.id, KeyAtFault(fails, stamp, *record));
    }
  }
  // "[json.exception.type_error.302] type must be ..."
  const std::size_t end =
      failure.starts_with("[json.exception") ? failure.find("] ") : failure.npos;
  return reason + (end == failure.npos ? failure : failure.substr(end + 2));
}

}  // namespace

Report ReportOf(const Results& results) {
  const auto& [stamp, records, folder] = results;
  const std::string where = folder.empty() ? Need(stamp.identity, "experiment") : folder.string();
  const TaskKind& kind = InFolder(where, [&]() -> const TaskKind& { return KindOf(stamp); });
  const auto wanted = CasesOf(stamp, where);
  Report report;
  try {
    report = kind.report(stamp, records);
  } catch (const base::RunError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {  // e.g. from JSON, counts or words of records
    throw base::InputError(
        where + ": the tables cannot be written: " + ReasonOf(kind, stamp, records, error.what()));
  }
  if (records.size() < wanted) {
    report.notes.push_back(fmt::format(
        "{} of {} cases are missing: the run has not ended (--resume continues one that was "
        "stopped), or this is a shard",
        wanted - records.size(), wanted));
  }
  return report;
}

std::string KeyTable(const std::vector<base::KeyDoc>& keys) {
  std::string text = "| key | means | default | values |\n| --- | --- | --- | --- |\n";
  for (const base::KeyDoc& key : keys) {
    const std::string values = key.type == "mapping" ? "keys below"
                               : key.range.empty()   ? key.type
                                                     : key.range;
    text += fmt::format("| `{}` | {} | {} | {} |\n", key.path, key.doc,
                        key.required                ? "**needed**"
                        : key.default_value.empty() ? ""
                                                    : "`" + key.default_value + "`",
                        values);
  }
  return text;
}

std::vector<std::pair<std::string, std::vector<base::KeyDoc>>> KeysByTask() {
  auto common_map = YamlMap::ForDocumentation();
  Common common;
  TaskWord(common_map);
  ReadCommon(common_map, common);
  std::vector<std::pair<std::string, std::vector<base::KeyDoc>>> by_task = {
      {"", common_map.Keys()}};
  for (const TaskKind& kind : Kinds()) {
    auto map = YamlMap::ForDocumentation();
    kind.read_keys(map);
    by_task.emplace_back(kind.name, map.Keys());
  }
  return by_task;
}

std::string KeysAsMarkdown() {
  std::string text;
  for (const auto& [task, keys] : KeysByTask()) {
    const TaskKind* kind = FindKind(task);
    text += !kind ? "## Every experiment\n\n"
                  : fmt::format("\n## `task: {}`\n\n{} `--trials` sets `{}`.\n\n", kind->name,
                                kind->description, kind->trials_key);
    text += KeyTable(keys);
  }
  return text;
}

}  // namespace rangegrasp::experiment
