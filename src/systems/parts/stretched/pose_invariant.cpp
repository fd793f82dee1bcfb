#include "parts/stretched/pose_invariant.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>

#include "geometry/graph.h"
#include "geometry/mesh.h"

namespace rangegrasp::parts {
namespace {

struct Piece {
  int parent = -1;                 ///< the piece that it was merged into; -1: none
  bool crumb = false;              ///< it was not a limb when merged
  std::vector<std::size_t> limbs;  ///< the pieces that it splits into
  double low = 1.0;                ///< growth at which it appears
  double high = 1.0;               ///< growth at which it splits or vanishes
  double tip = 1.0;                ///< growth at which the last of it vanishes
  double weight = 0.0;
  /// Remoteness of its nearest and farthest elements.
  double root = std::numeric_limits<double>::infinity();
  double end = 0.0;
  bool whole = false;  ///< it lasts longer than its limbs, or has fewer than two
};

/// The join tree, from the tips of the pieces down to the core. Joints come after their limbs.
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

  Labels Label() {
    const std::vector<std::size_t> limbs = Limbs();
    Labels of_piece(pieces_.size(), 0);
    for (std::size_t k = 0; k < limbs.size(); ++k) {
      of_piece[limbs[k]] = static_cast<std::int32_t>(k) + 1;
    }
    Labels label;
    for (int p : piece_of_) {
      while (p >= 0 && of_piece[p] == 0) p = pieces_[p].parent;
      label.push_back(p < 0 ? 0 : of_piece[p]);
    }
    return label;
  }

 private:
  Indices FromTheTips() const {
    Indices order =
        geometry::PositionsWhere(elements_.growth, [](double growth) { return growth > 1.0; });
    std::ranges::stable_sort(order, std::greater<>(),
                             [&](std::uint32_t i) { return elements_.growth[i]; });
    return order;
  }

  /// Sets of the elements already in the tree that are next to an element.
  Indices SetsAround(std::uint32_t i) {
    Indices around;
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

  /// The piece that continues where several meet: a new one if at least two are limbs, else the
  /// only limb or the heaviest crumb.
  std::size_t Meet(const Indices& around, double growth) {
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

  void Add(std::uint32_t i, const Indices& around) {
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

  /// Computes how long each piece lasts, or the mean of its limbs if that is longer.
  void Weigh() {
    std::vector<double> lasts(pieces_.size(), 0.0);
    std::vector<int> limbs(pieces_.size(), 0);  // final limbs of each that lead away
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

  /// Limbs by decreasing weight.
  std::vector<std::size_t> Limbs() {
    Weigh();
    std::vector<std::size_t> limbs;
    std::vector<bool> within(pieces_.size(), false);  // a limb, or part of one
    for (std::size_t p = pieces_.size(); p-- > 0;) {
      const Piece& piece = pieces_[p];
      if (piece.crumb) continue;
      within[p] = piece.parent >= 0 && within[piece.parent];
      if (within[p] || !piece.whole) continue;
      within[p] = true;
      if (LeadsAway(piece) && (piece.parent >= 0 || IsLimb(piece, 1.0))) limbs.push_back(p);
    }
    std::ranges::stable_sort(limbs, std::greater<>(),
                             [&](std::size_t p) { return pieces_[p].weight; });
    return limbs;
  }

  const StandingOut& elements_;
  const LimbOptions& options_;
  double min_weight_;
  geometry::UnionFind sets_;
  std::vector<std::size_t> piece_of_set_;  ///< indexed by the set's root
  std::vector<int> piece_of_;              ///< the piece that an element was added to; -1: none
  std::vector<Piece> pieces_;
};

/// The points of an element.
std::span<const std::uint32_t> PointsOf(const Shape& shape, const std::uint32_t& element) {
  if (shape.IsMesh()) return shape.faces[element];
  return {&element, 1};
}

/// For each point the factor by which a hull must grow about `center` to contain the point.
std::vector<double> GrowthToHold(const Points& points, const geometry::TriangleMesh& hull,
                                 const Eigen::Vector3d& center) {
  std::vector<double> growth(points.size(), 0.0);
  for (const auto& [a, b, c] : hull.triangles) {
    const Eigen::Vector3d normal =
        (hull.vertices[b] - hull.vertices[a]).cross(hull.vertices[c] - hull.vertices[a]);
    const double distance = normal.dot(hull.vertices[a] - center);
    if (!(distance > 0.0)) continue;
    for (std::size_t i = 0; i < points.size(); ++i) {
      growth[i] = std::max(growth[i], normal.dot(points[i] - center) / distance);
    }
  }
  return growth;
}

Points CorePoints(const Shape& form, const Segmentation& segmentation) {
  std::vector<bool> used(form.points.size(), false);
  for (std::uint32_t i = 0; i < form.Elements(); ++i) {
    if (segmentation.label[i] != 0) continue;
    for (const std::uint32_t p : PointsOf(form, i)) used[p] = true;
  }
  return geometry::Select(form.points, geometry::PositionsOf(used));
}

/// The largest value of an element's points; 0 for elements of the core.
std::vector<double> OfElements(const Shape& form, const Segmentation& segmentation,
                               const std::vector<double>& of_point) {
  std::vector<double> value(form.Elements(), 0.0);
  for (std::uint32_t i = 0; i < value.size(); ++i) {
    if (segmentation.label[i] == 0) continue;
    for (const std::uint32_t p : PointsOf(form, i)) value[i] = std::max(value[i], of_point[p]);
  }
  return value;
}

void JoinAsIn(const Shape& shape, StandingOut& out) {
  const auto take = [&out](auto graph) {
    out.begin = std::move(graph.begin);
    out.neighbor = std::move(graph.neighbor);
  };
  shape.IsMesh() ? take(BuildFaceGraph(shape)) : take(BuildVertexGraph(shape));
  out.weight =
      shape.IsMesh() ? BuildFaceFrames(shape).area : std::vector<double>(shape.points.size(), 1.0);
}

/// Grows the core's hull of a segmented shape about its middle, as Katz et al. (2005) grow their
/// core, into each protrusion until that splits into limbs (LabelLimbs).
/// @param shape  the original shape, which defines the neighbors of elements
/// @param form   the same shape with the positions in which it was segmented
/// @param remoteness  mean geodesic distance of each point to the whole shape
Segmentation GrowCore(const Shape& shape, const Shape& form, const Segmentation& segmentation,
                      const std::vector<double>& remoteness, const LimbOptions& options) {
  const geometry::TriangleMesh hull = geometry::ConvexHull(CorePoints(form, segmentation));
  if (hull.triangles.empty()) return segmentation;
  StandingOut out;
  out.growth = OfElements(form, segmentation,
                          GrowthToHold(form.points, hull, geometry::Centroid(hull.vertices)));
  out.remoteness = OfElements(form, segmentation, remoteness);
  JoinAsIn(shape, out);
  Segmentation grown = segmentation;
  grown.label = LabelLimbs(out, options);
  grown.parts = 1 + *std::ranges::max_element(grown.label);
  return grown;
}

/// Majorisation steps per point. Measured on four-legged and armadillo models: all landmarks and 10
/// steps come within 1 % of the stress of 30 steps. The linear placement alone has 35-90 % more
/// stress; the nearest landmarks alone, or interpolation between them, give a rough surface.
constexpr int kPlacementSteps = 10;

struct Stretched {
  Shape form;
  std::vector<double> remoteness;  ///< per point: mean distance to the landmarks
};

Stretched Stretch(const Shape& shape, const PoseInvariantOptions& options) {
  if (options.landmarks < 4) {
    throw std::invalid_argument("PoseInvariant: landmarks must be >= 4");
  }
  const LandmarkDistances spread = SpreadLandmarks(GeodesicGraph(shape), options.landmarks);
  const Embedding embedding = Smacof(BetweenLandmarks(spread), options.smacof);
  const LandmarkPlacement placement(embedding.positions);

  Stretched result{shape, {}};
  Points& points = result.form.points;
  const Eigen::MatrixXd to_landmarks = spread.distance.transpose();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto distances = to_landmarks.col(i);
    points[i] = placement.Place(distances, kPlacementSteps);
    result.remoteness.push_back(distances.mean());
  }
  for (std::size_t k = 0; k < spread.landmark.size(); ++k) {
    points[spread.landmark[k]] = embedding.positions.row(k);
  }
  // An embedding may be a mirror image: faces must still be oriented outwards.
  if (geometry::Volume({points, shape.faces}) < 0.0) {
    for (Eigen::Vector3d& p : points) p.z() = -p.z();
  }
  return result;
}

}  // namespace

Labels LabelLimbs(const StandingOut& elements, const LimbOptions& options) {
  if (elements.growth.empty()) return {};
  return Tree(elements, options).Label();
}

Shape PoseInvariant(const Shape& shape, const PoseInvariantOptions& options) {
  return Stretch(shape, options).form;
}

Segmentation SegmentPoseInvariant(const Shape& shape, const PoseInvariantOptions& options) {
  const Stretched stretched = Stretch(shape, options);
  const Segmentation segmentation = SegmentByMirroring(stretched.form, options.mirror);
  if (!segmentation.has_core || !options.grow_core) return segmentation;
  return GrowCore(shape, stretched.form, segmentation, stretched.remoteness, options.limbs);
}

}  // namespace rangegrasp::parts
