#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace rangegrasp::base {

/// The words of an enum stand once, beside it, in the order of its values (which count from 0):
///
///   enum class Split { kTune, kReport };
///   constexpr std::array<std::string_view, 2> WordsOf(Split) { return {"tune", "report"}; }
///
/// WordsOf is found by argument-dependent lookup; Word, FromWord, ValuesOf and YamlMap::Read need
/// nothing else.
template <typename Enum>
concept HasWords = requires(Enum e) {
  WordsOf(e)[0];
};

/// The word of a value. Undefined for what is no value of the enum.
template <HasWords Enum>
constexpr std::string_view Word(Enum value) {
  return WordsOf(value)[static_cast<std::size_t>(value)];
}

/// All words of an enum, e.g. for the choices of an option.
template <HasWords Enum>
std::vector<std::string> WordList() {
  const auto words = WordsOf(Enum{});
  return {words.begin(), words.end()};
}

/// All values of an enum, in order.
template <HasWords Enum>
constexpr auto ValuesOf() {
  std::array<Enum, WordsOf(Enum{}).size()> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Enum>(i);
  return all;
}

/// What is said of a word that is not among words: "'word' must be one of ...; nearest: ...".
std::string MustBeOneOf(std::string_view word, const std::vector<std::string>& words);

/// The position of a word among words.
/// @throws InputError "<what>: " and MustBeOneOf if it is not among them.
std::size_t WordPosition(std::string_view word, const std::vector<std::string>& words,
                         const std::string& what);

/// The value of a word. @throws InputError as WordPosition.
template <HasWords Enum>
Enum FromWord(std::string_view word, const std::string& what) {
  return static_cast<Enum>(WordPosition(word, WordList<Enum>(), what));
}

/// The word nearest to `word` by edit distance, empty if there is none.
std::string NearestWord(std::string_view word, const std::vector<std::string>& words);

/// "a, b, c".
std::string Join(const std::vector<std::string>& words, std::string_view separator = ", ");

/// The parts of a text between separators; one empty part for an empty text.
std::vector<std::string> Split(std::string_view text, char separator);

}  // namespace rangegrasp::base
