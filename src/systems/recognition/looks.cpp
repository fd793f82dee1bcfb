#include "recognition/looks.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace rangegrasp::recognition {

std::vector<std::size_t> OpenObjects(const perception::Scene& scene,
                                     const std::vector<FoundObject>& found,
                                     const RecognitionOptions& options) {
  std::set<geometry::SampleId> sure;
  for (const FoundObject& one : SureOnes(found)) {
    sure.insert(one.samples.begin(), one.samples.end());
  }
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const geometry::Indices& own = scene.objects[i].points;
    const auto known = std::ranges::count_if(
        own, [&](std::uint32_t point) { return sure.contains(scene.SampleOf(point)); });
    if (own.size() < options.min_samples) continue;
    if (2 * static_cast<std::size_t>(known) < own.size()) open.push_back(i);
  }
  return open;
}

std::vector<FoundObject> SureOnes(const std::vector<FoundObject>& found) {
  std::vector<FoundObject> sure;
  std::ranges::copy_if(found, std::back_inserter(sure),
                       [](const FoundObject& one) { return one.alternatives_CB.empty(); });
  return sure;
}

std::vector<FoundObject> AsFirstSeen(std::vector<FoundObject> found) {
  for (FoundObject& one : found) {
    std::erase_if(one.samples, [](const geometry::SampleId& id) { return id.view != 0; });
  }
  std::erase_if(found, [](const FoundObject& one) { return one.samples.empty(); });
  return found;
}

}  // namespace rangegrasp::recognition
