#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace rangegrasp::base {

/// The words of an enum's values are declared once, next to it, in the order of the values (from
/// 0). The functions below find them by argument-dependent lookup:
///
///   enum class Split { kTune, kReport };
///   constexpr std::array<std::string_view, 2> WordsOf(Split) { return {"tune", "report"}; }
template <typename Enum>
concept HasWords = requires(Enum e) {
  WordsOf(e)[0];
};

/// Undefined behavior if `value` is not a value of the enum.
template <HasWords Enum>
constexpr std::string_view Word(Enum value) {
  return WordsOf(value)[static_cast<std::size_t>(value)];
}

template <HasWords Enum>
std::vector<std::string> WordList() {
  const auto words = WordsOf(Enum{});
  return {words.begin(), words.end()};
}

template <HasWords Enum>
constexpr auto ValuesOf() {
  std::array<Enum, WordsOf(Enum{}).size()> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Enum>(i);
  return all;
}

/// "'word' must be one of ...", and "; nearest: ..." if one of the words is near.
std::string MustBeOneOf(std::string_view word, const std::vector<std::string>& words);

/// @throws InputError "<what>: " and MustBeOneOf if the word is not among `words`.
std::size_t WordPosition(std::string_view word, const std::vector<std::string>& words,
                         const std::string& what);

/// @throws InputError as WordPosition.
template <HasWords Enum>
Enum FromWord(std::string_view word, const std::string& what) {
  return static_cast<Enum>(WordPosition(word, WordList<Enum>(), what));
}

/// The nearest word by edit distance, if at most a third of the letters (rounded up) are wrong, or
/// one that contains the given word (at least three letters); empty if no word is near.
std::string NearestWord(std::string_view word, const std::vector<std::string>& words);

/// The part of a message that suggests the nearest word; empty if no word is near.
/// @param text  with {} in place of the word
std::string Suggestion(std::string_view word, const std::vector<std::string>& words,
                       std::string_view text = "; nearest: '{}'");

/// "a, b, c".
std::string Join(const std::vector<std::string>& words, std::string_view separator = ", ");

/// A count with its noun, whose plural ends in s: "1 grasp", "0 grasps", "2 grasps".
std::string Counted(std::int64_t count, std::string_view thing);

/// A value for a message: its beginning, on one line.
std::string Excerpt(std::string_view text);

/// An empty text gives one empty part.
std::vector<std::string> Split(std::string_view text, char separator);

/// Whether a text is UTF-8, as JSON requires: no truncated, overlong or surrogate sequence.
bool IsUtf8(std::string_view text);

/// A text escaped for XML, for use between tags or in quotes.
std::string XmlEscaped(std::string_view text);

/// Parses a whole text as a decimal number without blanks; nullopt if it is no number, or one that
/// does not fit the type. Floating-point types also accept "nan" and "inf".
template <typename Number>
std::optional<Number> NumberFrom(std::string_view text) {
  Number number{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end) return std::nullopt;
  return number;
}

/// An addition to a published method. It has a switch, so that its effect can be measured alone.
/// The table's rows give the keys of experiment files, "as published" (all off) and the table of
/// ablations. The switches of a stage are a struct of bools, each true, with a table next to it:
///
///   struct SoupAdditions { bool salt = true; bool pepper = true; };
///   constexpr std::array<base::Addition<SoupAdditions>, 2> AdditionsOf(const SoupAdditions*) {
///     return {{{"salt", &SoupAdditions::salt, "salted"}, ...}};
///   }
///   static_assert(base::AllAdditionsListed<SoupAdditions>());  // a switch without a row
template <typename Switches>
struct Addition {
  std::string_view key;  ///< key in an experiment file
  bool Switches::*on;
  std::string_view doc;  ///< what it does and, if not obvious, what is done without it
};

template <typename Switches>
constexpr auto AdditionsTable() {
  return AdditionsOf(static_cast<const Switches*>(nullptr));
}

/// Whether the struct contains only bools and each has a row.
template <typename Switches>
constexpr bool AllAdditionsListed() {
  constexpr auto rows = AdditionsTable<Switches>();
  if (rows.size() * sizeof(bool) != sizeof(Switches)) return false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (rows[i].on == rows[k].on || rows[i].key == rows[k].key) return false;
    }
  }
  return true;
}

template <typename Switches>
constexpr void SwitchAll(bool on, Switches& switches) {
  for (const auto& row : AdditionsTable<Switches>()) switches.*row.on = on;
}

}  // namespace rangegrasp::base
