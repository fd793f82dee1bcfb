#include "experiment/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>

#include "base/error.h"
#include "base/words.h"

namespace rangegrasp::experiment {
namespace {

using nlohmann::ordered_json;

ordered_json JsonOf(const Params& params) {
  ordered_json json = ordered_json::object();
  for (const auto& [name, value] : params.values()) {
    std::visit([&](const auto& v) { json[name] = v; }, value);
  }
  return json;
}

// Nullopt for what is neither a number nor a text, and for a number that does not fit.
std::optional<Params::Value> ValueOf(const ordered_json& json) {
  if (json.is_string()) return json.get<std::string>();
  if (json.is_number_float()) return json.get<double>();
  if (json.is_number_unsigned() && !std::in_range<std::int64_t>(json.get<std::uint64_t>())) {
    return std::nullopt;
  }
  if (json.is_number_integer()) return json.get<std::int64_t>();
  return std::nullopt;
}

// The value of a name as a T.
template <typename T>
const T& Get(const Params& params, std::string_view name) {
  for (const auto& [known, value] : params.values()) {
    if (known != name) continue;
    if (const T* found = std::get_if<T>(&value)) return *found;
    break;
  }
  throw base::InputError(fmt::format("the parameters of a case lack '{}', or its type is wrong: {}",
                                     name, base::Excerpt(ToJson(params))));
}

// The distinct words of all items, in the order of their first occurrence.
template <typename All, typename WordOf>
std::vector<std::string> FirstOfEach(const All& all, WordOf word_of) {
  std::vector<std::string> words;
  for (const auto& one : all) {
    const std::string word = word_of(one);
    if (std::ranges::find(words, word) == words.end()) words.push_back(word);
  }
  return words;
}

}  // namespace

Params Params::FromJson(const std::string& text) {
  const auto json = ordered_json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) {
    throw base::InputError(
        fmt::format("its parameters are damaged: '{}' is no JSON object", base::Excerpt(text)));
  }
  Params params;
  for (const auto& [name, value] : json.items()) {
    auto known = ValueOf(value);
    if (!known) {
      throw base::InputError(fmt::format(
          "its parameters are damaged: '{}' is {}; it must be a text, a number or a whole number "
          "of 64 bits",
          base::Excerpt(name),
          value.is_structured() ? value.type_name() : base::Excerpt(value.dump())));
    }
    params.Add(name, std::move(*known));
  }
  return params;
}

bool Params::Has(std::string_view name) const {
  return std::ranges::any_of(values_, [&](const auto& value) { return value.first == name; });
}

const std::string& Params::Text(std::string_view name) const {
  return Get<std::string>(*this, name);
}

int Params::Int(std::string_view name) const {
  const std::int64_t value = Get<std::int64_t>(*this, name);
  if (std::in_range<int>(value)) return static_cast<int>(value);
  throw base::InputError(
      fmt::format("the parameters of a case: '{}' is {}, which does not fit 32 bits", name, value));
}

double Params::Number(std::string_view name) const { return Get<double>(*this, name); }

std::string ToJson(const Params& params) { return JsonOf(params).dump(); }

std::string ToJson(const Record& record) {
  const auto& [which, result] = record;
  try {
    ordered_json json = {{"id", which.id},
                         {"group", which.group},
                         {"seed", which.seed},
                         {"params", JsonOf(which.params)},
                         {"outcome", result.outcome},
                         {"stage", result.stage},
                         {"detail", result.detail},
                         {"data", ordered_json::parse(result.data)},
                         {"seconds", ordered_json::object()}};
    for (const auto& [stage, seconds] : result.seconds) json["seconds"][stage] = seconds;
    return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  } catch (const ordered_json::exception&) {
    throw base::RunError(fmt::format("case {}: its record is damaged: '{}' is no JSON object",
                                     which.id, base::Excerpt(result.data)));
  }
}

bool SameButTimes(const Record& a, const Record& b) {
  const auto all = [](const Record& r) {
    return std::tie(r.which.id, r.which.group, r.which.seed, r.which.params, r.result.outcome,
                    r.result.stage, r.result.detail, r.result.data);
  };
  return all(a) == all(b);
}

std::vector<std::string> GroupsOf(const std::vector<Case>& cases) {
  return FirstOfEach(cases, [](const Case& c) { return c.group; });
}

std::vector<std::string> GroupsOf(const std::vector<Record>& records) {
  return FirstOfEach(records, [](const Record& record) { return record.which.group; });
}

void AddSeconds(const std::string& stage, double seconds,
                std::vector<std::pair<std::string, double>>& sums) {
  const auto found = std::ranges::find(sums, stage, [](const auto& sum) { return sum.first; });
  if (found == sums.end()) {
    sums.emplace_back(stage, seconds);
  } else {
    found->second += seconds;
  }
}

std::string ValueOr(const std::map<std::string, std::string>& part, const std::string& name,
                    const std::string& otherwise) {
  const auto found = part.find(name);
  return found == part.end() ? otherwise : found->second;
}

std::string TitleOf(const Stamp& stamp, const std::string& group) {
  return ValueOr(stamp.data, kTitlePrefix + group, group);
}

bool SetsSeedOrTrials(std::string_view line, std::string_view trials_key) {
  const auto key = line.substr(0, line.find_first_of("=:"));
  return key == "seed" || key == trials_key;
}

void AddCommit(const std::string& commit, Stamp& stamp) {
  if (commit.empty() || commit == ValueOr(stamp.build, "commit", "")) return;
  std::string& others = stamp.build["resumed_with"];
  if (others.find(commit) == std::string::npos) others += (others.empty() ? "" : ",") + commit;
}

namespace {

// Lines of an experiment file that a message shows.
constexpr std::size_t kShownLines = 3;

constexpr const char* kText = "experiment_text";

// The lines of a stamp's value that decide results: not comments, the seed or the number of trials.
std::vector<std::string> DecidingLines(const Stamp& stamp, const char* name,
                                       const std::string& trials) {
  auto lines = base::Split(ValueOr(stamp.data, name, ""), '\n');
  for (std::string& line : lines) line.erase(line.find_last_not_of(" \t\r") + 1);
  std::erase_if(lines, [&](const std::string& line) {
    const auto first = line.find_first_not_of(" \t");
    return first == std::string::npos || line[first] == '#' || SetsSeedOrTrials(line, trials);
  });
  return lines;
}

// The first of the lines that are not in `others`.
std::string OnlyIn(std::vector<std::string> lines, const std::vector<std::string>& others) {
  std::erase_if(lines,
                [&](const std::string& line) { return std::ranges::count(others, line) > 0; });
  for (std::string& line : lines) line.erase(0, line.find_first_not_of(" \t"));
  if (lines.size() > kShownLines) lines[kShownLines] = "...";
  lines.resize(std::min(lines.size(), kShownLines + 1));
  return base::Join(lines);
}

// How two runs differ in a value of their identity; empty if they differ only in comments.
std::string Difference(const std::string& name, const Stamp& stored, const Stamp& wanted) {
  const auto pair = [&](const std::string& was, const std::string& is) {
    const auto shown = [](const std::string& value) { return value.empty() ? "none" : value; };
    return fmt::format("{} instead of {}", shown(was), shown(is));
  };
  if (name != "experiment_hash") {
    return name + " " +
           pair(ValueOr(stored.identity, name, ""), ValueOr(wanted.identity, name, ""));
  }
  const std::string differs = "the experiment files differ";
  const std::string trials = ValueOr(wanted.data, kTrialsKey, "trials_per_object");
  for (const auto& [part, words] : {std::pair{"set", std::string("--set")}, {kText, differs}}) {
    const auto was = DecidingLines(stored, part, trials), is = DecidingLines(wanted, part, trials);
    if (was == is) continue;
    const std::string only_was = OnlyIn(was, is), only_is = OnlyIn(is, was);
    return only_was == only_is ? words + " in their order" : words + ": " + pair(only_was, only_is);
  }
  return stored.data.contains(kText) && wanted.data.contains(kText) ? "" : differs;
}

}  // namespace

void CheckSameRun(const Stamp& stored, const Stamp& wanted, const std::string& where,
                  const std::string& remedy) {
  auto names = stored.identity;
  names.insert(wanted.identity.begin(), wanted.identity.end());
  for (const auto& [name, value] : names) {
    if (ValueOr(stored.identity, name, "") == ValueOr(wanted.identity, name, "")) continue;
    const std::string difference = Difference(name, stored, wanted);
    if (difference.empty()) continue;
    throw base::InputError(
        fmt::format("{}: contains results of another run ({}); {}", where, difference, remedy));
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

std::size_t CasesOf(const Stamp& stamp, const std::string& where) {
  const std::string text = ValueOr(stamp.identity, "cases", "");
  if (const auto cases = base::NumberFrom<std::size_t>(text)) return *cases;
  throw base::InputError(where + ": the number of cases is '" + text +
                         "', not a whole number: the results are damaged, or the run was killed "
                         "at its start");
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
