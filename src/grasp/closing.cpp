#include "grasp/closing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace rangegrasp::grasp {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Samples this near to a pad at the contact belong to it: the glove's 1.5 mm yields, and samples
/// are 2 mm apart. Larger: normals from round the corner count; smaller: one sample is the contact.
constexpr double kPatch_m = 0.003;
/// [m^2] so that samples right at the patch's edge have a weight.
constexpr double kMinWeight_m2 = 1e-12;

struct Sample {
  double x_T;
  std::size_t cell;   ///< of the inner side's grid
  std::size_t index;  ///< of the given points
};

struct Limits {
  double a = -kInfinity;
  double b = kInfinity;
  bool Overlap() const { return a > b; }
};

double At(const std::vector<float>& field, std::size_t cell) {
  return static_cast<double>(field[cell]);
}

/// The samples between the open jaws, where fingers or thumb may pass.
std::vector<Sample> Between(const HandProfiles::Inner& open, std::span<const Vector3d> points_A,
                            const Vector3d& origin_A) {
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < points_A.size(); ++i) {
    const Vector3d p = points_A[i] - origin_A;
    if (p.x() < open.finger_min_m || p.x() > open.thumb_max_m) continue;
    const int at = open.grid.Cell(p.y(), p.z());
    if (at < 0) continue;
    const auto cell = static_cast<std::size_t>(at);
    if (p.x() < At(open.finger, cell) || p.x() > At(open.thumb, cell)) continue;
    samples.push_back({p.x(), cell, i});
  }
  return samples;
}

Limits LimitsOf(const HandProfiles::Inner& inner, const std::vector<Sample>& samples) {
  Limits limits;
  for (const Sample& s : samples) {
    limits.a = std::max(limits.a, At(inner.finger, s.cell) - s.x_T);
    limits.b = std::min(limits.b, At(inner.thumb, s.cell) - s.x_T);
  }
  return limits;
}

/// The contact of one side: the mean of the samples within the glove's softness of it, weighted by
/// the square of how far they stand in. `side` is -1 for the fingers, at smaller x, +1 for the
/// thumb.
struct Patch {
  Vector3d point = Vector3d::Zero();
  Vector3d out = Vector3d::Zero();
  double spread_m = 0.0;
  int size = 0;
};
Patch PatchOf(const std::vector<float>& field, const std::vector<Sample>& samples,
              std::span<const Vector3d> points_A, std::span<const Vector3d> normals_A,
              double foremost, double side) {
  Patch patch;
  double weights = 0.0;
  double y_min = kInfinity;
  double y_max = -kInfinity;
  for (const Sample& s : samples) {
    const double behind = side * (At(field, s.cell) - s.x_T - foremost);
    if (behind > kPatch_m) continue;
    const double weight = (kPatch_m - behind) * (kPatch_m - behind) + kMinWeight_m2;
    const Vector3d& n = normals_A[s.index];
    patch.point += weight * points_A[s.index];
    patch.out += weight * (n.x() * side < 0.0 ? Vector3d(-n) : n);
    weights += weight;
    y_min = std::min(y_min, points_A[s.index].y());
    y_max = std::max(y_max, points_A[s.index].y());
    ++patch.size;
  }
  patch.point /= weights;
  patch.out.normalize();
  patch.spread_m = y_max - y_min;
  return patch;
}

}  // namespace

std::optional<Closing> CloseOn(HandProfiles& hand, double pitch_rad, std::size_t open_state,
                               std::span<const Vector3d> points_A,
                               std::span<const Vector3d> normals_A, double sample_area_m2,
                               const Vector3d& origin_A) {
  const std::vector<Sample> samples =
      Between(hand.InnerSide(pitch_rad, open_state), points_A, origin_A);
  const auto limits = [&](std::size_t s) {
    return LimitsOf(hand.InnerSide(pitch_rad, s), samples);
  };
  std::size_t free = open_state;
  std::size_t closed = hand.hand().states.size() - 1;
  Limits at_free = limits(free);
  Limits at_closed = limits(closed);
  if (at_free.Overlap() || !at_closed.Overlap()) return std::nullopt;
  while (closed - free > 1) {
    const std::size_t middle = (free + closed) / 2;
    const Limits at = limits(middle);
    (at.Overlap() ? closed : free) = middle;
    (at.Overlap() ? at_closed : at_free) = at;
  }

  Closing closing;
  // Where one side met nothing in the state before, the contact is the closed one.
  const bool both = std::isfinite(at_free.a) && std::isfinite(at_free.b);
  const double room = at_free.b - at_free.a;
  const double f = both ? room / (room + at_closed.a - at_closed.b) : 1.0;
  const double gap_free = hand.hand().states[free].gap_m;
  const double gap_closed = hand.hand().states[closed].gap_m;
  closing.gap_m = gap_free + f * (gap_closed - gap_free);
  closing.drag_m =
      both ? at_free.a + f * (at_closed.a - at_free.a) : 0.5 * (at_closed.a + at_closed.b);
  closing.state = both && f < 0.5 ? free : closed;
  const Limits& at = closing.state == free ? at_free : at_closed;
  const HandProfiles::Inner& inner = hand.InnerSide(pitch_rad, closing.state);
  const Patch finger = PatchOf(inner.finger, samples, points_A, normals_A, at.a, -1.0);
  const Patch thumb = PatchOf(inner.thumb, samples, points_A, normals_A, at.b, 1.0);
  closing.finger_T = finger.point - origin_A;
  closing.thumb_T = thumb.point - origin_A;
  closing.finger_out_T = finger.out;
  closing.thumb_out_T = thumb.out;
  closing.finger_spread_m = finger.spread_m;
  closing.contact_m2 = sample_area_m2 * (finger.size + thumb.size);
  return closing;
}

AntipodalAngles Antipodal(const Vector3d& finger, const Vector3d& finger_out, const Vector3d& thumb,
                          const Vector3d& thumb_out) {
  const Vector3d line = (thumb - finger).normalized();
  const auto angle = [](const Vector3d& u, const Vector3d& v) {
    return std::atan2(u.cross(v).norm(), u.dot(v));
  };
  return {angle(-finger_out, line), angle(thumb_out, line)};
}

}  // namespace rangegrasp::grasp
