#include "parts/shape/internal/pieces.h"

#include <algorithm>
#include <map>
#include <set>

namespace rangegrasp::parts {
namespace {

/// Pieces of faces of one label, by falling size.
struct LabelledPieces {
  std::vector<std::int32_t> of_face;
  std::vector<std::int32_t> label;
  std::vector<std::map<std::int32_t, std::size_t>> shared;  ///< edges with each other piece
};

LabelledPieces PiecesOf(const FaceGraph& faces, const std::vector<std::int32_t>& label) {
  LabelledPieces pieces;
  const auto count = static_cast<std::size_t>(LabelPieces(
      faces, std::vector<bool>(label.size(), true),
      [&](std::uint32_t f, std::uint32_t g) { return label[f] == label[g]; }, pieces.of_face));
  pieces.label.assign(count, 0);
  pieces.shared.resize(count);
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    const std::int32_t here = pieces.of_face[f];
    const auto p = static_cast<std::size_t>(here);
    pieces.label[p] = label[f];
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::int32_t there = pieces.of_face[faces.neighbor[k]];
      if (there != here) ++pieces.shared[p][there];
    }
  }
  return pieces;
}

}  // namespace

std::int32_t LabelOutside(const FaceGraph& faces, const std::vector<bool>& core,
                          std::vector<std::int32_t>& label) {
  std::vector<bool> rest = core;
  rest.flip();
  const std::int32_t pieces = LabelPieces(faces, rest, label);
  for (std::int32_t& l : label) ++l;
  return pieces;
}

void JoinCrumbs(const FaceGraph& faces, std::vector<std::int32_t>& label) {
  LabelledPieces pieces = PiecesOf(faces, label);
  std::set<std::int32_t> seen;
  std::vector<std::size_t> crumbs;
  for (std::size_t p = 0; p < pieces.label.size(); ++p) {
    if (!seen.insert(pieces.label[p]).second) crumbs.push_back(p);
  }
  for (const std::size_t p : crumbs) {
    std::map<std::int32_t, std::size_t> votes;
    for (const auto& [other, edges] : pieces.shared[p]) {
      votes[pieces.label[static_cast<std::size_t>(other)]] += edges;
    }
    const auto best =
        std::max_element(votes.begin(), votes.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    if (best != votes.end()) pieces.label[p] = best->first;
  }
  for (std::size_t f = 0; f < label.size(); ++f) {
    label[f] = pieces.label[static_cast<std::size_t>(pieces.of_face[f])];
  }
}

}  // namespace rangegrasp::parts
