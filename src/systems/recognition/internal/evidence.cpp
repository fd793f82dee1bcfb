#include "recognition/internal/evidence.h"

#include <algorithm>
#include <cmath>

namespace rangegrasp::recognition::internal {
namespace {

/// A surface that is met at a flatter angle (80 deg) is not measured well.
constexpr float kFlattest = 0.17f;
/// One that is met at less than 60 deg (its cosine) gives an answer, unless it hides from the
/// sensor's camera; a flatter one the less, the flatter it is.
constexpr float kSurely = 0.5f;
/// Directions between two measured samples of a profile are known by them up to this many apart.
constexpr std::uint32_t kMaxLost = 256;

/// What each of the scene's points was taken for; strays for nothing (not in the list).
std::vector<std::uint8_t> PartsOf(const perception::Scene& scene, const geometry::Indices& own) {
  constexpr auto kStray = static_cast<std::uint8_t>(255);
  std::vector<std::uint8_t> parts(scene.points_C.size(), static_cast<std::uint8_t>(Part::kGround));
  for (const auto point : scene.outliers) parts[point] = kStray;
  for (const auto point : scene.source) parts[point] = static_cast<std::uint8_t>(Part::kOther);
  for (const auto point : own) parts[scene.source[point]] = static_cast<std::uint8_t>(Part::kOwn);
  return parts;
}

/// The ball about a segment, made larger.
struct Ball {
  Eigen::Vector3d center_C;
  double radius_m;
};
Ball BallAbout(const perception::Scene& scene, const geometry::Indices& own, double beside_m) {
  const geometry::Points points = geometry::Select(scene.cloud.points, own);
  Ball ball{geometry::Centroid(points), 0.0};
  for (const auto& p : points) ball.radius_m = std::max(ball.radius_m, (p - ball.center_C).norm());
  ball.radius_m += beside_m;
  return ball;
}

bool Meets(const Ball& ball, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d middle = ball.center_C - origin;
  return (middle - middle.dot(direction) * direction).norm() <= ball.radius_m;
}

/// The rays of a profile between two measured samples, from..to, of which nothing came back.
void AddLostBetween(const geometry::RangeImage& image, std::uint32_t from, std::uint32_t to,
                    const Ball& ball, SampleRays& rays) {
  const Eigen::Vector3d& origin = image.OriginOf(to);
  const Eigen::Vector3d first = (image.points_C[from] - origin).normalized();
  const Eigen::Vector3d last = (image.points_C[to] - origin).normalized();
  const std::uint32_t apart = to - from;
  for (std::uint32_t k = 1; k < apart; ++k) {
    const double share = static_cast<double>(k) / apart;
    const Eigen::Vector3d direction = ((1.0 - share) * first + share * last).normalized();
    if (!Meets(ball, origin, direction)) continue;
    rays.push_back({origin.cast<float>(), direction.cast<float>(), 0.0f, 1.0f, Part::kLost, 0});
  }
}

void AddLost(const geometry::RangeImage& image, const Ball& ball, SampleRays& rays) {
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

/// By how much the tones of explained samples are off.
class ToneErrors {
 public:
  void Add(const Eigen::Vector3f& off, float weight) {
    if (!off.allFinite()) return;
    errors_.push_back({off, weight});
    brightness_ += weight * off.z();
    weight_ += weight;
  }

  /// The brightness of all together is the light's, not the object's.
  void AddTo(Evidence& evidence, double tolerance) const {
    if (errors_.empty()) return;
    const float brighter = brightness_ / weight_;
    const auto per_square = static_cast<float>(1.0 / (tolerance * tolerance));
    for (const auto& [off, weight] : errors_) {
      const float square = (off - Eigen::Vector3f(0.0f, 0.0f, brighter)).squaredNorm() * per_square;
      evidence.colored += static_cast<double>(weight);
      evidence.agreed += static_cast<double>(weight * std::max(0.0f, 1.0f - square));
    }
  }

 private:
  struct Error {
    Eigen::Vector3f off;
    float weight;
  };
  std::vector<Error> errors_;
  float brightness_ = 0.0f, weight_ = 0.0f;
};

}  // namespace

SampleRays RaysAbout(const geometry::Observation& observation, const perception::Scene& scene,
                     const geometry::Indices& own, double beside_m) {
  SampleRays rays;
  if (own.empty()) return rays;
  const auto parts = PartsOf(scene, own);
  const Ball ball = BallAbout(scene, own, beside_m);
  for (std::uint32_t i = 0; i < scene.points_C.size(); ++i) {
    if (parts[i] > static_cast<std::uint8_t>(Part::kGround)) continue;
    const auto& sample = scene.samples[i];
    const Eigen::Vector3d& origin = observation.views[sample.view].image.OriginOf(sample.sample);
    const Eigen::Vector3d to = scene.points_C[i] - origin;
    const double distance = to.norm();
    const Eigen::Vector3d direction = to / distance;
    if (!Meets(ball, origin, direction)) continue;
    rays.push_back({origin.cast<float>(), direction.cast<float>(), static_cast<float>(distance),
                    1.0f, static_cast<Part>(parts[i]), i});
    const auto& colors = observation.views[sample.view].colors;
    if (!colors.empty()) rays.back().tone = ToneOf(colors[sample.sample]);
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
  ToneErrors tones;
  const bool has_tones = object.tones.known();
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
      if (has_tones) tones.Add(ray.tone - object.tones.At(hits[i]), ray.weight);
      if (explained) explained->push_back(ray.point);
    } else if (off > 0.0f) {
      evidence.violated += weight;
    } else if (ray.part == Part::kOwn) {
      evidence.unexplained += weight;
    } else {
      evidence.hidden += weight;
    }
  }
  tones.AddTo(evidence, color_tolerance);
  return evidence;
}

}  // namespace rangegrasp::recognition::internal
