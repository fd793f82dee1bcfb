#pragma once

#include <fmt/format.h>

#include "base/rng.h"
#include "experiment/record.h"

namespace rangegrasp::experiment {

/// A case that depends only on its group, number and seed.
inline Case SampleCase(const std::string& group, int i, std::uint64_t seed = 1) {
  return {fmt::format("{}-{:04}", group, i),
          group,
          base::DeriveSeed(base::DeriveSeed(seed, group), static_cast<std::uint64_t>(i)),
          {{"index", i}},
          i};
}

/// A result of a case with every field filled.
inline Result SampleResult(const Case& which) {
  const int i = which.position;
  return {i % 2 == 0 ? "delivered" : "dropped",
          "score",
          fmt::format("case {}", i),
          fmt::format(R"({{"lift_height_m":0.{}}})", i + 1),
          {{"scan", 0.1 + i}, {"perceive", 1.0 / (3.0 + i)}, {"case", 1e-3 * i}}};
}

inline Record SampleRecord(const std::string& group, int i, std::uint64_t seed = 1) {
  const Case which = SampleCase(group, i, seed);
  return {which, SampleResult(which)};
}

/// JSON data of `bytes` bytes.
inline std::string LargeData(std::size_t bytes) {
  const std::string begin = R"({"x":")", end = R"("})";
  return begin + std::string(bytes - begin.size() - end.size(), 'x') + end;
}

/// All fields that must not depend on how a case was run, including a field with non-text bytes.
inline std::string Row(const Record& record) {
  const auto& [c, r] = record;
  std::string row;
  for (const std::string& field :
       {c.id, c.group, std::to_string(c.seed), ToJson(c.params), std::to_string(c.position),
        r.outcome, r.stage, r.detail, r.data}) {
    row += field + "|";
  }
  return row;
}

}  // namespace rangegrasp::experiment
