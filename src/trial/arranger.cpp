#include "trial/arranger.h"

#include <fmt/format.h>

#include "base/words.h"

namespace rangegrasp::trial {

int Total(const Redraws& redraws) {
  int total = 0;
  for (const auto& [reason, count] : redraws) total += count;
  return total;
}

std::string Text(const Redraws& redraws) {
  std::string text;
  for (const auto& [reason, count] : redraws) {
    text += fmt::format("{}{} x{}", text.empty() ? "" : ", ", base::Word(reason), count);
  }
  return text;
}

}  // namespace rangegrasp::trial
