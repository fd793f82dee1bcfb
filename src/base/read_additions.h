#pragma once

#include <string>

#include "base/additions.h"
#include "base/yaml_map.h"

namespace rangegrasp::base {

/// Reads one key a switch, as their table states it.
template <typename Switches>
void ReadAdditions(YamlMap& map, Switches& switches) {
  for (const auto& row : AdditionsTable<Switches>()) {
    map.Read(std::string(row.key), switches.*row.on, std::string(row.doc));
  }
}

}  // namespace rangegrasp::base
