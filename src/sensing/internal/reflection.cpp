#include "sensing/internal/reflection.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rangegrasp::sensing::internal {
namespace {

// The mirror direction of a share `gloss` of the samples blinds the camera; albedo's corner points
// are estimates for dark print under a red line.
constexpr double kDarkAlbedo = 0.05;
constexpr double kFairAlbedo = 0.10;
constexpr double kDarkLoss = 0.5;
constexpr double kBlackLoss = 0.9;
constexpr double kInkAlbedo = 0.04;
constexpr double kPaperAlbedo = 0.85;

Blob Sum(std::span<const Glint> group) {
  Blob blob;
  blob.low_px = group.front().column_px;
  blob.high_px = group.back().column_px;
  double moment = 0.0;
  double brightest = 0.0;
  for (const Glint& glint : group) {
    blob.brightness += glint.brightness;
    moment += glint.brightness * glint.column_px;
    if (glint.brightness > brightest) {
      brightest = glint.brightness;
      blob.source = glint.source;
    }
  }
  if (blob.brightness > 0.0) blob.column_px = moment / blob.brightness;
  return blob;
}

}  // namespace

double IncidenceLoss(const LineScannerOptions& options, double incidence_rad) {
  const double span_rad = options.dropout_end_rad - options.dropout_begin_rad;
  return std::clamp((incidence_rad - options.dropout_begin_rad) / span_rad, 0.0, 1.0);
}

double AlbedoLoss(double albedo) {
  if (albedo >= kFairAlbedo) return 0.0;
  if (albedo >= kDarkAlbedo) {
    return kDarkLoss * (kFairAlbedo - albedo) / (kFairAlbedo - kDarkAlbedo);
  }
  return kDarkLoss + (kBlackLoss - kDarkLoss) * (kDarkAlbedo - albedo) / kDarkAlbedo;
}

double GlossLoss(const LineScannerOptions& options, double gloss, double mirror_offset_rad) {
  return mirror_offset_rad <= options.saturation_angle_rad ? gloss : 0.0;
}

double ClarityLoss(double clarity) { return clarity; }

double SampleLoss(double albedo, double clarity) {
  return 1.0 - (1.0 - AlbedoLoss(albedo)) * (1.0 - ClarityLoss(clarity));
}

double PatchLoss(const LineScannerOptions& options, double gloss, const Encounter& encounter) {
  return 1.0 - (1.0 - IncidenceLoss(options, encounter.incidence_rad)) *
                   (1.0 - GlossLoss(options, gloss, encounter.mirror_offset_rad));
}

double PrintAlbedo(std::uint8_t red) {
  // IEC 61966-2-1.
  static const std::array<double, 256> albedo = [] {
    std::array<double, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double s = static_cast<double>(i) / 255.0;
      const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
      table[i] = kInkAlbedo + (kPaperAlbedo - kInkAlbedo) * linear;
    }
    return table;
  }();
  return albedo[red];
}

Blob BrightestBlob(std::span<Glint> glints, double width_px) {
  std::ranges::sort(glints, [](const Glint& a, const Glint& b) {
    return a.column_px != b.column_px ? a.column_px < b.column_px : a.source < b.source;
  });
  Blob best;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= glints.size(); ++i) {
    if (i < glints.size() && glints[i].column_px - glints[i - 1].column_px <= width_px) continue;
    const Blob blob = Sum(glints.subspan(begin, i - begin));
    if (blob.brightness > best.brightness) best = blob;
    begin = i;
  }
  return best;
}

}  // namespace rangegrasp::sensing::internal
