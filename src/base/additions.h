#pragma once

#include <string_view>

namespace rangegrasp::base {

/// A published method, and what this program adds to it: each addition is a switch of its own, so
/// that its worth can be measured alone, and all of them off are the method as published.
///
/// The switches of one stage are a struct of nothing but bools, each true (the improved method),
/// and a table with one row each stands beside it, found by argument-dependent lookup:
///
///   struct SoupAdditions { bool salt = true; bool pepper = true; };
///   constexpr std::array<base::Addition<SoupAdditions>, 2> AdditionsOf(const SoupAdditions*) {
///     return {{{"salt", &SoupAdditions::salt, "salted"}, ...}};
///   }
///   static_assert(base::AllAdditionsListed<SoupAdditions>());
///
/// What has no row does not compile, so that no addition is forgotten: the keys of experiment
/// files, "as published" and the table of what each is worth are all made from these rows.
template <typename Switches>
struct Addition {
  std::string_view key;  ///< in an experiment's file
  bool Switches::*on;
  std::string_view doc;  ///< what it does; where it is not plain, what is done without it
};

template <typename Switches>
constexpr auto AdditionsTable() {
  return AdditionsOf(static_cast<const Switches*>(nullptr));
}

/// One row a byte of the struct: it holds bools alone, and every one of them is listed.
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
