#include "parts/stretched/limbs.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "geometry/union_find.h"

namespace rangegrasp::parts {
namespace {

struct Piece {
  int parent = -1;                 ///< the piece that it became a part of; -1: none
  bool crumb = false;              ///< it was no limb when it did
  std::vector<std::size_t> limbs;  ///< what it falls into
  double low = 1.0;                ///< growth at which it comes into being
  double high = 1.0;               ///< at which it falls apart or vanishes
  double tip = 1.0;                ///< at which the last of it vanishes
  double weight = 0.0;
  /// Remoteness of its nearest and farthest element.
  double root = std::numeric_limits<double>::infinity();
  double end = 0.0;
  bool whole = false;  ///< it lasts longer than its limbs do, or has less than two
};

/// The join tree, from the tips of the pieces down to the core. Joints are newer than their limbs.
class Tree {
 public:
  Tree(const StandingOut& elements, const LimbOptions& options)
      : elements_(elements),
        options_(options),
        min_weight_(options.min_weight *
                    std::accumulate(elements.weight.begin(), elements.weight.end(), 0.0)),
        sets_(elements.growth.size()),
        piece_of_set_(elements.growth.size(), 0),
        piece_of_(elements.growth.size(), -1) {
    for (const std::uint32_t i : FromTheTips()) Add(i, SetsAround(i));
  }

  std::vector<std::int32_t> Labels() {
    const std::vector<std::size_t> limbs = Limbs();
    std::vector<std::int32_t> of_piece(pieces_.size(), 0);
    for (std::size_t k = 0; k < limbs.size(); ++k) {
      of_piece[limbs[k]] = static_cast<std::int32_t>(k) + 1;
    }
    std::vector<std::int32_t> label;
    for (int p : piece_of_) {
      while (p >= 0 && of_piece[static_cast<std::size_t>(p)] == 0) {
        p = pieces_[static_cast<std::size_t>(p)].parent;
      }
      label.push_back(p < 0 ? 0 : of_piece[static_cast<std::size_t>(p)]);
    }
    return label;
  }

 private:
  std::vector<std::uint32_t> FromTheTips() const {
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < elements_.growth.size(); ++i) {
      if (elements_.growth[i] > 1.0) order.push_back(i);
    }
    std::ranges::stable_sort(order, [&](std::uint32_t a, std::uint32_t b) {
      return elements_.growth[a] > elements_.growth[b];
    });
    return order;
  }

  /// Sets of what is in the tree already, next to an element.
  std::vector<std::uint32_t> SetsAround(std::uint32_t i) {
    std::vector<std::uint32_t> around;
    for (std::uint32_t k = elements_.begin[i]; k < elements_.begin[i + 1]; ++k) {
      const std::uint32_t next = elements_.neighbor[k];
      if (piece_of_[next] >= 0) around.push_back(sets_.Find(next));
    }
    std::ranges::sort(around);
    around.erase(std::ranges::unique(around).begin(), around.end());
    return around;
  }

  bool IsLimb(const Piece& piece, double low) const {
    return piece.weight >= min_weight_ && piece.tip - low >= options_.min_prominence;
  }

  void Hold(std::size_t p, double weight, double root, double end) {
    Piece& piece = pieces_[p];
    piece.weight += weight;
    piece.root = std::min(piece.root, root);
    piece.end = std::max(piece.end, end);
  }

  std::size_t NewPiece(double growth) {
    pieces_.emplace_back();
    pieces_.back().high = pieces_.back().tip = growth;
    return pieces_.size() - 1;
  }

  std::size_t Join(std::vector<std::size_t> limbs, double growth) {
    const std::size_t joint = NewPiece(growth);
    for (const std::size_t p : limbs) {
      pieces_[p].low = growth;
      pieces_[p].parent = static_cast<int>(joint);
      pieces_[joint].tip = std::max(pieces_[joint].tip, pieces_[p].tip);
      Hold(joint, pieces_[p].weight, pieces_[p].root, pieces_[p].end);
    }
    pieces_[joint].limbs = std::move(limbs);
    return joint;
  }

  /// The piece that goes on where several meet: a new one where two limbs do, else the limb or the
  /// heaviest crumb.
  std::size_t Meet(const std::vector<std::uint32_t>& around, double growth) {
    if (around.empty()) return NewPiece(growth);
    std::vector<std::size_t> limbs;
    std::size_t heaviest = piece_of_set_[around.front()];
    for (const std::uint32_t set : around) {
      const std::size_t p = piece_of_set_[set];
      if (IsLimb(pieces_[p], growth)) limbs.push_back(p);
      if (pieces_[p].weight > pieces_[heaviest].weight) heaviest = p;
    }
    if (limbs.size() > 1) return Join(std::move(limbs), growth);
    return limbs.empty() ? heaviest : limbs.front();
  }

  void Add(std::uint32_t i, const std::vector<std::uint32_t>& around) {
    const std::size_t at = Meet(around, elements_.growth[i]);
    for (const std::uint32_t set : around) {
      Piece& other = pieces_[piece_of_set_[set]];
      if (piece_of_set_[set] != at && other.parent < 0) {
        other.parent = static_cast<int>(at);
        other.crumb = true;
        Hold(at, other.weight, other.root, other.end);
      }
      sets_.Unite(set, i);
    }
    Hold(at, elements_.weight[i], elements_.remoteness[i], elements_.remoteness[i]);
    piece_of_set_[sets_.Find(i)] = at;
    piece_of_[i] = static_cast<int>(at);
  }

  bool LeadsAway(const Piece& piece) const { return piece.end >= options_.min_reach * piece.root; }

  /// How long each piece lasts, or its limbs in the mean where that is longer.
  void Weigh() {
    std::vector<double> lasts(pieces_.size(), 0.0);
    std::vector<int> limbs(pieces_.size(), 0);  // that it falls into at last and that lead away
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      Piece& piece = pieces_[p];
      const double own = piece.high - piece.low;
      double apart = 0.0;
      for (const std::size_t limb : piece.limbs) {
        apart += lasts[limb] / static_cast<double>(piece.limbs.size());
        limbs[p] += limbs[limb];
      }
      piece.whole = own >= apart || limbs[p] < 2;
      lasts[p] = std::max(own, apart);
      if (piece.whole) limbs[p] = LeadsAway(piece) ? 1 : 0;
    }
  }

  /// By falling weight.
  std::vector<std::size_t> Limbs() {
    Weigh();
    std::vector<std::size_t> limbs;
    std::vector<bool> within(pieces_.size(), false);  // a limb, or part of one
    for (std::size_t p = pieces_.size(); p-- > 0;) {
      const Piece& piece = pieces_[p];
      if (piece.crumb) continue;
      within[p] = piece.parent >= 0 && within[static_cast<std::size_t>(piece.parent)];
      if (within[p] || !piece.whole) continue;
      within[p] = true;
      if (LeadsAway(piece) && (piece.parent >= 0 || IsLimb(piece, 1.0))) limbs.push_back(p);
    }
    std::ranges::stable_sort(
        limbs, [&](std::size_t a, std::size_t b) { return pieces_[a].weight > pieces_[b].weight; });
    return limbs;
  }

  const StandingOut& elements_;
  const LimbOptions& options_;
  double min_weight_;
  geometry::UnionFind sets_;
  std::vector<std::size_t> piece_of_set_;  ///< by the set's root
  std::vector<int> piece_of_;              ///< the piece that an element was added to; -1: none
  std::vector<Piece> pieces_;
};

}  // namespace

std::vector<std::int32_t> LabelLimbs(const StandingOut& elements, const LimbOptions& options) {
  if (elements.growth.empty()) return {};
  return Tree(elements, options).Labels();
}

}  // namespace rangegrasp::parts
