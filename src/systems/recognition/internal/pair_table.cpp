#include "recognition/internal/pair_table.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "recognition/internal/thin.h"

namespace rangegrasp::recognition::internal {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
/// Steps of the feature's angles and of the turn about a normal (12 deg, as in the paper).
constexpr double kAngleStep = kPi / 15.0;
constexpr int kPairTurns = 30;
/// Of pairs of one feature so many vote, evenly: those of a plane with itself are thousands, and
/// say little.
constexpr std::size_t kMaxPairs = 100;

/// Turns the normal to x, with the point at the origin.
base::Pose ToAxis(const Vector3d& p, const Vector3d& n) {
  const Eigen::Matrix3d R =
      Eigen::Quaterniond::FromTwoVectors(n, Vector3d::UnitX()).toRotationMatrix();
  return base::MakePose(R, -(R * p));
}

double AngleAbout(const base::Pose& to_axis, const Vector3d& q) {
  const Vector3d local = to_axis * q;
  return std::atan2(local.z(), local.y());
}

std::uint32_t Step(double cosine) {
  return static_cast<std::uint32_t>(std::acos(std::clamp(cosine, -1.0, 1.0)) / kAngleStep);
}

}  // namespace

std::uint32_t PairTable::Key(const Vector3d& p, const Vector3d& n, const Vector3d& q,
                             const Vector3d& m) const {
  const Vector3d d = q - p;
  const double length = d.norm();
  const auto step = static_cast<std::uint32_t>(length / spacing_m_);
  const Vector3d u = d / length;
  return (step << 12) | (Step(n.dot(u)) << 8) | (Step(m.dot(u)) << 4) | Step(n.dot(m));
}

void PairTable::Thin(Bucket& bucket) {
  std::vector<Pair>& pairs = bucket.pairs;
  bucket.all = static_cast<float>(pairs.size());
  const std::size_t step = (pairs.size() + kMaxPairs - 1) / kMaxPairs;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < pairs.size(); i += step) pairs[kept++] = pairs[i];
  pairs.resize(kept);
  pairs.shrink_to_fit();
}

PairTable::PairTable(const geometry::PointCloud& surface_B, double spacing_m)
    : spacing_m_(spacing_m) {
  const auto kept = Thinned(surface_B.points, spacing_m);
  points_B_ = {geometry::Select(surface_B.points, kept), geometry::Select(surface_B.normals, kept)};
  for (std::uint32_t i = 0; i < points_B_.size(); ++i) {
    const base::Pose to_axis = ToAxis(points_B_.points[i], points_B_.normals[i]);
    for (std::uint32_t j = 0; j < points_B_.size(); ++j) {
      const Vector3d d = points_B_.points[j] - points_B_.points[i];
      if (i == j || d.norm() < spacing_m) continue;
      diameter_m_ = std::max(diameter_m_, d.norm());
      const auto key =
          Key(points_B_.points[i], points_B_.normals[i], points_B_.points[j], points_B_.normals[j]);
      pairs_[key].pairs.push_back({static_cast<std::uint16_t>(i),
                                   static_cast<float>(AngleAbout(to_axis, points_B_.points[j]))});
    }
  }
  for (auto& [key, bucket] : pairs_) Thin(bucket);
}

void PairTable::Vote(const geometry::PointCloud& scene_C, std::uint32_t reference,
                     std::size_t peaks, std::vector<Voted>& voted) const {
  const Vector3d& p = scene_C.points[reference];
  const Vector3d& n = scene_C.normals[reference];
  const base::Pose to_axis = ToAxis(p, n);
  thread_local std::vector<float> votes;
  votes.assign(points_B_.size() * kPairTurns, 0.0f);
  for (std::uint32_t j = 0; j < scene_C.size(); ++j) {
    const Vector3d& q = scene_C.points[j];
    const double distance = (q - p).norm();
    if (j == reference || distance < spacing_m_ || distance > diameter_m_) continue;
    const auto found = pairs_.find(Key(p, n, q, scene_C.normals[j]));
    if (found == pairs_.end()) continue;
    // A common feature says little: each pair of the scene has a vote in all, shared out softly.
    const Bucket& bucket = found->second;
    const float weight = std::sqrt(bucket.all) / static_cast<float>(bucket.pairs.size());
    const double angle = AngleAbout(to_axis, q);
    for (const Pair& pair : bucket.pairs) {
      double turn = angle - static_cast<double>(pair.angle);
      if (turn < 0.0) turn += 2.0 * kPi;
      if (turn < 0.0) turn += 2.0 * kPi;
      const auto slot = std::min(static_cast<int>(turn / (2.0 * kPi) * kPairTurns), kPairTurns - 1);
      votes[pair.reference * static_cast<std::size_t>(kPairTurns) +
            static_cast<std::size_t>(slot)] += weight;
    }
  }
  for (std::size_t peak = 0; peak < peaks; ++peak) {
    const auto best = std::ranges::max_element(votes);
    if (best == votes.end() || *best <= 0.0f) return;
    const auto at = static_cast<std::size_t>(best - votes.begin());
    const std::size_t i = at / kPairTurns;
    const double turn = (static_cast<double>(at % kPairTurns) + 0.5) * 2.0 * kPi / kPairTurns;
    const base::Pose spin = base::MakePose(
        Eigen::AngleAxisd(turn, Vector3d::UnitX()).toRotationMatrix(), Vector3d::Zero());
    const base::Pose X_CB =
        to_axis.inverse() * spin * ToAxis(points_B_.points[i], points_B_.normals[i]);
    voted.push_back({X_CB, static_cast<double>(*best)});
    // The next peak is of another place of the model.
    for (std::size_t k = 0; k < points_B_.size(); ++k) {
      if ((points_B_.points[k] - points_B_.points[i]).norm() > 2.0 * spacing_m_) continue;
      std::fill_n(votes.begin() + static_cast<std::ptrdiff_t>(k * kPairTurns), kPairTurns, 0.0f);
    }
  }
}

}  // namespace rangegrasp::recognition::internal
