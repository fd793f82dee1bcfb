#include "experiment/kinds.h"

#include <vector>

namespace rangegrasp::experiment {
namespace {

std::vector<TaskKind>& Kinds() {
  static std::vector<TaskKind> kinds;
  return kinds;
}

}  // namespace

void AddKind(const TaskKind& kind) { Kinds().push_back(kind); }

std::span<const TaskKind> AllKinds() { return Kinds(); }

}  // namespace rangegrasp::experiment
