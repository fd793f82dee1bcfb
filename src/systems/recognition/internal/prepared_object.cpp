#include "recognition/internal/prepared_object.h"

#include <Eigen/Geometry>
#include <iterator>

#include "base/linear_algebra.h"
#include "base/units.h"
#include "geometry/plane.h"

namespace rangegrasp::recognition::internal {
namespace {

using base::kPi;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Colors.

/// Added to the light of each channel: a few levels of a camera's noise, so that black is grey.
constexpr double kBlack = 0.002;
/// Weight of the brightness: half the light gives 0.1, as much as cream differs from white. Black
/// differs from white by 0.4, more than red from orange.
constexpr double kBrightness = 0.15;

Tone ToneOf(const geometry::Rgb& color) {
  const Vector3d light = geometry::LightOf(color).array() + kBlack;
  const double sum = light.sum();
  return Vector3d(light.x() / sum, light.z() / sum, kBrightness * std::log(sum)).cast<float>();
}

std::vector<Tone> TonesOf(const std::vector<geometry::Rgb>& colors) {
  std::vector<Tone> tones;
  std::ranges::transform(colors, std::back_inserter(tones), ToneOf);
  return tones;
}

// Point pairs.

/// Steps of the feature's angles and of the turn about a normal (12 deg, as in the paper).
constexpr double kAngleStep = kPi / 15.0;
constexpr int kPairTurns = 30;
constexpr double kPairSpacing_m = 0.009;  ///< spacing of a model's points
/// Maximum pairs per feature that vote, evenly chosen: a plane has thousands of little information.
constexpr std::size_t kMaxPairs = 100;

/// Transform that puts the point at the origin and its normal along x.
base::Pose ToAxis(const Vector3d& p, const Vector3d& n) {
  const Matrix3d R = base::TurnOnto(n, Vector3d::UnitX()).toRotationMatrix();
  return base::MakePose(R, -(R * p));
}

/// Of a point about the x axis, 0 to kPairTurns.
float TurnOf(const Vector3d& local) {
  const double angle = std::atan2(local.z(), local.y());
  return static_cast<float>((angle < 0.0 ? angle + 2.0 * kPi : angle) / (2.0 * kPi) * kPairTurns);
}

std::uint32_t Step(double cosine) {
  return static_cast<std::uint32_t>(std::acos(std::clamp(cosine, -1.0, 1.0)) / kAngleStep);
}

/// @param cloud  thinned to kPairSpacing_m
PointPairs PairsOf(const geometry::PointCloud& cloud, std::size_t point) {
  const Vector3d& p = cloud.points[point];
  const Vector3d& n = cloud.normals[point];
  PointPairs of_point{ToAxis(p, n), {}};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3d& q = cloud.points[i];
    const double length = (q - p).norm();
    if (length < kPairSpacing_m) continue;
    const Vector3d u = (q - p) / length;
    const Vector3d& m = cloud.normals[i];
    const auto step = static_cast<std::uint32_t>(length / kPairSpacing_m);
    const std::uint32_t feature =
        (step << 12) | (Step(n.dot(u)) << 8) | (Step(m.dot(u)) << 4) | Step(n.dot(m));
    of_point.pairs.push_back({feature, TurnOf(of_point.to_axis * q)});
  }
  return of_point;
}

// Poses on a table.

/// Step of the tried rotations about the vertical (10 deg); refinement turns by half of it.
constexpr double kYawStep_rad = 0.1745;
/// Lying orientations closer than this to each other are duplicates, modulo symmetry.
constexpr double kSameWay_rad = 0.6 * kYawStep_rad;
/// How far the middle of a hull may be outside a face on which it lies.
constexpr double kLyingSlack_m = 0.004;

std::vector<Matrix3d> WaysToLie(const KnownObject& object) {
  std::vector<Matrix3d> ways;
  const int yaws = static_cast<int>(std::ceil(2.0 * kPi / kYawStep_rad));
  for (const Vector3d& down_B : LyingDirections(object.mesh_B.vertices, kLyingSlack_m)) {
    const Matrix3d upright = base::TurnOnto(down_B, -Vector3d::UnitZ()).toRotationMatrix();
    for (int k = 0; k < yaws; ++k) {
      const double yaw = 2.0 * kPi * k / yaws;
      const Matrix3d way = Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) * upright;
      const bool known = std::ranges::any_of(ways, [&](const Matrix3d& other) {
        return AngleBetween(way, other, object.symmetry) < kSameWay_rad;
      });
      if (!known) ways.push_back(way);
    }
  }
  return ways;
}

// Rays.

/// Minimum cosine of the incidence (80 deg): surfaces seen at flatter angles are not measured well.
constexpr float kFlattest = 0.17f;
/// Surfaces within 60 deg of incidence (its cosine) are measured; flatter ones less often.
constexpr float kSurely = 0.5f;
/// The directions of lost samples are interpolated between measured ones up to this many apart.
constexpr std::uint32_t kMaxLost = 256;

/// Classification of each of the scene's points; nullopt for outliers.
std::vector<std::optional<Part>> PartsOf(const perception::Scene& scene,
                                         const geometry::Indices& own) {
  std::vector<std::optional<Part>> parts(scene.points_C.size(), Part::kGround);
  for (const auto point : scene.outliers) parts[point].reset();
  for (const auto point : scene.source) parts[point] = Part::kOther;
  for (const auto point : own) parts[scene.source[point]] = Part::kOwn;
  return parts;
}

/// The ball around a segment, enlarged by beside_m.
struct Ball {
  Vector3d center_C;
  double radius_m;
};
Ball BallAbout(const perception::Scene& scene, const geometry::Indices& own, double beside_m) {
  const geometry::Points points = geometry::Select(scene.cloud.points, own);
  Ball ball{geometry::Centroid(points), 0.0};
  for (const auto& p : points) ball.radius_m = std::max(ball.radius_m, (p - ball.center_C).norm());
  ball.radius_m += beside_m;
  return ball;
}

bool Meets(const Ball& ball, const Vector3d& origin, const Vector3d& direction) {
  const Vector3d middle = ball.center_C - origin;
  return (middle - middle.dot(direction) * direction).norm() <= ball.radius_m;
}

/// Adds the lost rays of a profile between two measured samples, from..to.
void AddLostBetween(const geometry::RangeImage& image, std::uint32_t from, std::uint32_t to,
                    const Ball& ball, SampleRays& rays) {
  const Vector3d& origin = image.OriginOf(to);
  const Vector3d first = (image.points_C[from] - origin).normalized();
  const Vector3d last = (image.points_C[to] - origin).normalized();
  const std::uint32_t apart = to - from;
  for (std::uint32_t k = 1; k < apart; ++k) {
    const double share = static_cast<double>(k) / apart;
    const Vector3d direction = ((1.0 - share) * first + share * last).normalized();
    if (!Meets(ball, origin, direction)) continue;
    rays.push_back({origin.cast<float>(), direction.cast<float>(), 0.0f, 1.0f, Part::kLost, 0});
  }
}

/// Adds the lost rays of an image. Without scan order, nothing is known of rays between neighbors
/// in the file: a NaN is e.g. a point outside a crop.
void AddLost(const geometry::RangeImage& image, const Ball& ball, SampleRays& rays) {
  if (!image.HasScanOrder()) return;
  const auto width = static_cast<std::uint32_t>(image.samples);
  for (std::uint32_t i = 0; i < image.points_C.size(); i += width) {
    std::uint32_t last = i + width;  // none yet
    for (std::uint32_t k = i; k < i + width; ++k) {
      if (!image.points_C[k].allFinite()) continue;
      if (last < k && k - last <= kMaxLost) AddLostBetween(image, last, k, ball, rays);
      last = k;
    }
  }
}

/// Error of an explained sample's tone, and the number of samples that it represents.
struct ToneError {
  Tone off;
  float weight;
};

/// The mean brightness error is attributed to the light, not to the object.
void AddColors(const std::vector<ToneError>& errors, double tolerance, Evidence& evidence) {
  float brightness = 0.0f, all = 0.0f;
  for (const auto& [off, weight] : errors) {
    brightness += weight * off.z();
    all += weight;
  }
  const auto per_square = static_cast<float>(1.0 / (tolerance * tolerance));
  for (const auto& [off, weight] : errors) {
    const float square = (off - Tone(0.0f, 0.0f, brightness / all)).squaredNorm() * per_square;
    evidence.colored += static_cast<double>(weight);
    evidence.agreed += static_cast<double>(weight * std::max(0.0f, 1.0f - square));
  }
}

}  // namespace

std::vector<PointPairs> ReferencesOf(const geometry::PointCloud& cloud, int count) {
  std::vector<PointPairs> references;
  const geometry::PointCloud thin = Thinned(cloud, kPairSpacing_m);
  const std::size_t step = std::max<std::size_t>(1, thin.size() / static_cast<std::size_t>(count));
  for (std::size_t i = step / 2; i < thin.size(); i += step) {
    references.push_back(PairsOf(thin, i));
  }
  return references;
}

PairTable::PairTable(const geometry::PointCloud& surface_B)
    : points_B_(Thinned(surface_B, kPairSpacing_m)) {
  for (std::size_t i = 0; i < points_B_.size(); ++i) {
    for (const auto& [feature, turn] : PairsOf(points_B_, i).pairs) {
      pairs_[feature].pairs.push_back({static_cast<std::uint16_t>(i), turn});
    }
  }
  for (auto& [feature, bucket] : pairs_) {
    std::vector<Pair>& pairs = bucket.pairs;
    const auto all = static_cast<float>(pairs.size());
    const std::size_t step = (pairs.size() + kMaxPairs - 1) / kMaxPairs;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < pairs.size(); i += step) pairs[kept++] = pairs[i];
    pairs.resize(kept);
    pairs.shrink_to_fit();
    // A common feature has little information, so its votes grow only with the square root.
    bucket.weight = std::sqrt(all) / static_cast<float>(kept);
  }
}

void PairTable::Vote(const PointPairs& scene, std::vector<Posed>& voted) const {
  constexpr int kPeaks = 2;
  thread_local Eigen::ArrayXXf votes;  // of each turn (rows) about each of the model's points
  votes.setZero(kPairTurns, static_cast<Eigen::Index>(points_B_.size()));
  for (const PointPairs::Pair& seen : scene.pairs) {
    const auto found = pairs_.find(seen.feature);
    if (found == pairs_.end()) continue;
    for (const Pair& pair : found->second.pairs) {
      float turn = seen.turn - pair.turn;
      if (turn < 0.0f) turn += kPairTurns;
      votes(std::min(static_cast<int>(turn), kPairTurns - 1), pair.reference) +=
          found->second.weight;
    }
  }
  Eigen::ArrayXf most = votes.colwise().maxCoeff();
  for (int peak = 0; peak < kPeaks; ++peak) {
    Eigen::Index at = 0;
    if (most.size() == 0 || !(most.maxCoeff(&at) > 0.0f)) return;
    Eigen::Index slot = 0;
    const auto count = static_cast<double>(votes.col(at).maxCoeff(&slot));
    const double turn = (static_cast<double>(slot) + 0.5) * 2.0 * kPi / kPairTurns;
    const base::Pose spin = base::MakePose(
        Eigen::AngleAxisd(turn, Vector3d::UnitX()).toRotationMatrix(), Vector3d::Zero());
    const auto i = static_cast<std::size_t>(at);
    const base::Pose X_CB =
        scene.to_axis.inverse() * spin * ToAxis(points_B_.points[i], points_B_.normals[i]);
    voted.push_back({X_CB, count});
    // The next peak has to be at another place of the model.
    for (std::size_t k = 0; k < points_B_.size(); ++k) {
      const double apart_m = (points_B_.points[k] - points_B_.points[i]).norm();
      if (apart_m <= 2.0 * kPairSpacing_m) most[static_cast<Eigen::Index>(k)] = 0.0f;
    }
  }
}

PreparedObject::PreparedObject(KnownObject known)
    : object(std::move(known)),
      rays(std::vector<const geometry::TriangleMesh*>{&object.mesh_B}),
      print_tones(TonesOf(object.colors.print ? object.colors.print->texels
                                              : std::vector<geometry::Rgb>())),
      plain_tones(TonesOf(object.colors.plain)),
      target(object.surface_B),
      hull_B(geometry::ConvexHull(object.mesh_B.vertices).vertices),
      axes_B(base::SymmetricEigen(geometry::Scatter(object.surface_B.points,
                                                    geometry::Centroid(object.surface_B.points)))
                 .vectors),
      round(AxisOfRevolution(object.surface_B)),
      lying(WaysToLie(object)),
      pairs(object.surface_B) {}

Tone PreparedObject::ToneAt(const geometry::Hit& hit) const {
  if (const auto texel = object.colors.TexelAt(hit)) return print_tones[*texel];
  if (plain_tones.empty()) return Tone::Constant(std::numeric_limits<float>::quiet_NaN());
  return plain_tones[hit.triangle];
}

SampleRays RaysAbout(const geometry::Observation& observation, const perception::Scene& scene,
                     const geometry::Indices& own, double beside_m) {
  SampleRays rays;
  if (own.empty()) return rays;
  const auto parts = PartsOf(scene, own);
  const Ball ball = BallAbout(scene, own, beside_m);
  for (std::uint32_t i = 0; i < scene.points_C.size(); ++i) {
    if (!parts[i]) continue;
    const auto& [view, sample] = scene.samples[i];
    const Vector3d& origin = observation.views[view].image.OriginOf(sample);
    const Vector3d to = scene.points_C[i] - origin;
    const double distance = to.norm();
    const Vector3d direction = to / distance;
    if (!Meets(ball, origin, direction)) continue;
    rays.push_back({origin.cast<float>(), direction.cast<float>(), static_cast<float>(distance),
                    1.0f, *parts[i], i});
    const auto& colors = observation.views[view].colors;
    if (!colors.empty()) rays.back().tone = ToneOf(colors[sample]);
  }
  for (const auto& view : observation.views) AddLost(view.image, ball, rays);
  return rays;
}

SampleRays Fewer(const SampleRays& rays, std::size_t count) {
  const auto of_own =
      static_cast<std::size_t>(std::ranges::count(rays, Part::kOwn, &SampleRay::part));
  const std::size_t half = std::max<std::size_t>(1, count / 2);
  const std::size_t own_step = std::max<std::size_t>(1, (of_own + half - 1) / half);
  const std::size_t step = std::max<std::size_t>(1, (rays.size() - of_own + half - 1) / half);
  SampleRays fewer;
  std::size_t own = 0;
  std::size_t others = 0;
  for (const SampleRay& ray : rays) {
    const bool is_own = ray.part == Part::kOwn;
    if ((is_own ? own++ % own_step : others++ % step) != 0) continue;
    fewer.push_back(ray);
    fewer.back().weight = static_cast<float>(is_own ? own_step : step);
  }
  return fewer;
}

double Evidence::ShapeScore(const RecognitionOptions& options) const {
  const double all =
      explained + violated + options.unexplained_weight * unexplained + options.lost_weight * lost;
  return all > 0.0 ? fit / all : 0.0;
}

double Evidence::Score(const RecognitionOptions& options) const {
  return ShapeScore(options) * (1.0 - options.color_weight * (1.0 - Color()));
}

Evidence Weigh(const PreparedObject& object, const base::Pose& X_CB, const SampleRays& rays,
               double tolerance_m, double color_tolerance, geometry::Indices* explained) {
  thread_local std::vector<geometry::Ray> asked;
  thread_local std::vector<geometry::Hit> hits;
  const Eigen::Isometry3f X_BC = X_CB.inverse().cast<float>();
  const auto tolerance = static_cast<float>(tolerance_m);
  asked.clear();
  for (const SampleRay& ray : rays) {
    asked.push_back({X_BC * ray.origin_C, X_BC.linear() * ray.direction_C, 0.0f, 10.0f});
  }
  object.rays.FirstHits(asked, hits);
  Evidence evidence;
  std::vector<ToneError> tones;
  const bool has_tones = object.has_tones();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const SampleRay& ray = rays[i];
    const double weight = static_cast<double>(ray.weight);
    if (!hits[i].found()) {
      evidence.unexplained += ray.part == Part::kOwn ? weight : 0.0;
      continue;
    }
    const float cosine = std::max(kFlattest, std::abs(hits[i].normal_W.dot(asked[i].direction_W)));
    if (ray.part == Part::kLost) {
      evidence.lost += weight * static_cast<double>(std::min(1.0f, cosine / kSurely));
      continue;
    }
    const float off = (ray.distance_m - hits[i].distance_m) * cosine;
    if (std::abs(off) <= tolerance) {
      if (ray.part == Part::kGround) continue;  // the table at the object's foot
      const double share = static_cast<double>(off / tolerance);
      evidence.fit += weight * (1.0 - share * share);
      evidence.explained += weight;
      evidence.squares_m2 += weight * static_cast<double>(off) * static_cast<double>(off);
      if (has_tones && !std::isnan(ray.tone.x())) {
        tones.push_back({ray.tone - object.ToneAt(hits[i]), ray.weight});
      }
      if (explained) explained->push_back(ray.point);
    } else if (off > 0.0f) {
      evidence.violated += weight;
    } else if (ray.part == Part::kOwn) {
      evidence.unexplained += weight;
    } else {
      evidence.hidden += weight;
    }
  }
  std::erase_if(tones, [](const ToneError& error) { return !error.off.allFinite(); });
  AddColors(tones, color_tolerance, evidence);
  return evidence;
}

}  // namespace rangegrasp::recognition::internal
