#include "grasp/selector.h"

#include <deque>

namespace rangegrasp::grasp {
namespace {

std::deque<GraspSelector>& Selectors() {
  static std::deque<GraspSelector> selectors;
  return selectors;
}

}  // namespace

void AddGraspSelector(const GraspSelector& selector) { Selectors().push_back(selector); }

const GraspSelector* FindGraspSelector(const std::string& word) {
  for (const GraspSelector& selector : Selectors()) {
    if (selector.word == word) return &selector;
  }
  return nullptr;
}

std::vector<std::string> GraspSelectorWords() {
  std::vector<std::string> words = {kAnywhere};
  for (const GraspSelector& selector : Selectors()) words.push_back(selector.word);
  return words;
}

}  // namespace rangegrasp::grasp
