#include "tasks/grasping/arranger.h"

#include <fmt/format.h>

#include "core/words.h"
#include "tasks/grasping/internal/clutter_arranger.h"
#include "tasks/grasping/internal/scattered_arranger.h"
#include "tasks/grasping/internal/single_arranger.h"

namespace rangegrasp::tasks::grasping {

int Total(const Redraws& redraws) {
  int total = 0;
  for (const auto& [reason, count] : redraws) total += count;
  return total;
}

std::string Text(const Redraws& redraws) {
  std::string text;
  for (const auto& [reason, count] : redraws) {
    text += fmt::format("{}{} x{}", text.empty() ? "" : ", ", core::Word(reason), count);
  }
  return text;
}

std::unique_ptr<Arranger> MakeArranger(const Options& options, const robot::Robot& robot,
                                       const sensing::LineScannerOptions& scanner) {
  switch (options.arranger) {
    case ArrangerKind::kTouching:
    case ArrangerKind::kBox:
    case ArrangerKind::kPile:
      return internal::MakeClutterArranger(options, robot, scanner);
    case ArrangerKind::kScattered:
      return internal::MakeScatteredArranger(options, robot, scanner);
    case ArrangerKind::kSingle:
      break;
  }
  return internal::MakeSingleArranger(options, robot, scanner);
}

}  // namespace rangegrasp::tasks::grasping
