#include "base/systems.h"

#include <fmt/format.h>

#include <vector>

namespace rangegrasp::base {
namespace {

std::vector<WordNotBuilt>& Words() {
  static std::vector<WordNotBuilt> words;
  return words;
}

}  // namespace

NotBuilt::NotBuilt(const std::string& where, const WordNotBuilt& word)
    : InputError(fmt::format("{}{} '{}' belongs to the system '{}', which this program was built "
                             "without (configure with -DRANGEGRASP_SYSTEMS={} or all)",
                             where, word.kind, word.word, word.system, word.system)),
      system_(word.system) {}

void AddWordNotBuilt(const WordNotBuilt& word) { Words().push_back(word); }

std::optional<WordNotBuilt> FindNotBuilt(std::string_view kind, std::string_view word) {
  for (const WordNotBuilt& known : Words()) {
    if (known.kind == kind && known.word == word) return known;
  }
  return std::nullopt;
}

void CheckBuilt(std::string_view kind, std::string_view word, const std::string& where) {
  if (const auto found = FindNotBuilt(kind, word)) throw NotBuilt(where, *found);
}

}  // namespace rangegrasp::base
