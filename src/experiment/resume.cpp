#include "experiment/resume.h"

#include <fmt/format.h>

#include <unordered_map>

#include "base/error.h"

namespace rangegrasp::experiment {
namespace {

// Rows that one commit made and rows of another must not look as if they were of one.
Stamp WithBuildOf(const Stamp& stored, Stamp now) {
  const std::string is = now.build["commit"];
  now.build = stored.build;
  if (now.build["commit"] == is) return now;
  std::string& others = now.build["resumed_with"];
  if (others.find(is) == std::string::npos) others += (others.empty() ? "" : ",") + is;
  return now;
}

// The stored records as cases of a run that may have more of them.
std::vector<Record> Replaced(std::vector<Record> records, const std::vector<Case>& cases,
                             const std::string& where) {
  std::unordered_map<std::string, const Case*> by_id;
  for (const Case& c : cases) by_id.emplace(c.id, &c);
  for (Record& record : records) {
    const auto found = by_id.find(record.which.id);
    if (found == by_id.end() || found->second->seed != record.which.seed) {
      throw base::InputError(fmt::format(
          "{}: holds the case {}, which is not one of these {} cases; as many trials as it was "
          "begun with, or more, go on with it",
          where, record.which.id, cases.size()));
    }
    record.which = *found->second;
  }
  return records;
}

}  // namespace

Stamp Resume(Store& store, const Stamp& now, const std::vector<Case>& cases) {
  const Stamp stored = store.ReadStamp();
  const std::string where = store.file().parent_path().string();
  Stamp alike = stored;
  alike.identity["cases"] = Need(now.identity, "cases");
  CheckSameRun(alike, now, where);
  if (stored.identity != now.identity) {
    for (const Record& record : Replaced(store.ReadAll(), cases, where)) store.Write(record);
  }
  return WithBuildOf(stored, now);
}

}  // namespace rangegrasp::experiment
