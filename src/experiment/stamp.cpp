#include "experiment/stamp.h"

#include <fmt/format.h>

#include "base/error.h"

namespace rangegrasp::experiment {
namespace {

std::string ValueOr(const std::map<std::string, std::string>& part, const std::string& name,
                    const std::string& otherwise) {
  const auto found = part.find(name);
  return found == part.end() ? otherwise : found->second;
}

}  // namespace

std::string TitleOf(const Stamp& stamp, const std::string& group) {
  return ValueOr(stamp.data, kTitlePrefix + group, group);
}

void CheckSameRun(const Stamp& stored, const Stamp& wanted, const std::string& where) {
  auto names = stored.identity;
  names.insert(wanted.identity.begin(), wanted.identity.end());
  for (const auto& [name, value] : names) {
    const std::string was = ValueOr(stored.identity, name, "");
    const std::string is = ValueOr(wanted.identity, name, "");
    if (was == is) continue;
    throw base::InputError(
        fmt::format("{}: was made with another {} ('{}', not '{}'); use another --out, or "
                    "--overwrite",
                    where, name, was, is));
  }
}

const std::string& Need(const std::map<std::string, std::string>& part, const std::string& name) {
  const auto found = part.find(name);
  if (found == part.end()) {
    throw base::InputError("the results have no stamp '" + name +
                           "' (a run that was killed at its start?); run the experiment again");
  }
  return found->second;
}

std::string LineOf(const Stamp& stamp) {
  std::string line =
      fmt::format("{}: rangegrasp {} ({})", ValueOr(stamp.identity, "experiment", "?"),
                  ValueOr(stamp.build, "version", "?"), ValueOr(stamp.build, "commit", "?"));
  for (const auto& [name, value] : stamp.identity) {
    if (name == "experiment" || name == "groups") continue;
    line += fmt::format(", {} {}", name, value);
  }
  return line;
}

}  // namespace rangegrasp::experiment
