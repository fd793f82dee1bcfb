#include "report/internal/packed.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

namespace rangegrasp::report::internal {
namespace {

using nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little);

constexpr double kSteps = 65535.0;
constexpr double kTurnSteps = 32767.0;

template <typename Number>
std::string Bytes(const std::vector<Number>& numbers) {
  return Base64(
      {reinterpret_cast<const unsigned char*>(numbers.data()), numbers.size() * sizeof(Number)});
}

template <typename Number>
std::string TriangleBytes(const geometry::TriangleMesh& mesh) {
  std::vector<Number> corners;
  corners.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    for (const auto corner : triangle) corners.push_back(static_cast<Number>(corner));
  }
  return Bytes(corners);
}

}  // namespace

ordered_json PackedPoints(const geometry::Points& points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  const Eigen::Vector3d low = points.empty() ? Eigen::Vector3d(0.0, 0.0, 0.0) : box.min();
  const double edge = points.empty() ? 0.0 : box.sizes().maxCoeff();
  const double step = edge > 0.0 ? edge / kSteps : 1.0;
  std::vector<std::uint16_t> steps;
  steps.reserve(3 * points.size());
  for (const Eigen::Vector3d& p : points) {
    for (int i = 0; i < 3; ++i) {
      steps.push_back(static_cast<std::uint16_t>(std::lround((p[i] - low[i]) / step)));
    }
  }
  return {{"low", {low.x(), low.y(), low.z()}}, {"step", step}, {"data", Bytes(steps)}};
}

ordered_json PackedMesh(const geometry::TriangleMesh& mesh) {
  const bool wide = mesh.vertices.size() > std::numeric_limits<std::uint16_t>::max();
  return {{"vertices", PackedPoints(mesh.vertices)},
          {"wide", wide},
          {"triangles",
           wide ? TriangleBytes<std::uint32_t>(mesh) : TriangleBytes<std::uint16_t>(mesh)}};
}

ordered_json PackedPoses(const std::vector<base::Pose>& poses) {
  geometry::Points places;
  std::vector<std::int16_t> turns;
  for (const base::Pose& X : poses) {
    places.push_back(X.translation());
    const Eigen::Quaterniond turn(X.linear());
    for (const double part : {turn.x(), turn.y(), turn.z(), turn.w()}) {
      turns.push_back(static_cast<std::int16_t>(std::lround(part * kTurnSteps)));
    }
  }
  return {{"places", PackedPoints(places)}, {"turns", Bytes(turns)}};
}

ordered_json PackedNumbers(std::span<const double> numbers) {
  constexpr std::uint16_t kNone = 65535;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double x : numbers) {
    if (!std::isfinite(x)) continue;
    low = std::min(low, x);
    high = std::max(high, x);
  }
  if (!(low <= high)) low = high = 0.0;
  const double step = high > low ? (high - low) / (kNone - 1) : 1.0;
  std::vector<std::uint16_t> steps;
  steps.reserve(numbers.size());
  for (const double x : numbers) {
    steps.push_back(std::isfinite(x) ? static_cast<std::uint16_t>(std::lround((x - low) / step))
                                     : kNone);
  }
  return {{"low", low}, {"step", step}, {"data", Bytes(steps)}};
}

std::string Base64(std::span<const unsigned char> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8U | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (unsigned k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

}  // namespace rangegrasp::report::internal
