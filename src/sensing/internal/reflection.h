#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sensing/line_scanner_options.h"
#include "sim/visual_mesh.h"

namespace rangegrasp::sensing::internal {

/// Where light meets a surface; all angles [rad].
struct Encounter {
  double incidence_rad = 0.0;       ///< between the laser's ray and the normal
  double mirror_offset_rad = 3.14;  ///< between the mirrored ray and the direction to the camera
};

/// Probabilities of losing a sample that the camera could see.
/// 0 up to dropout_begin, linear to 1 at dropout_end.
double IncidenceLoss(const LineScannerOptions& options, double incidence_rad);
/// 0 from an albedo of 0.10 up, 0.5 at 0.05, 0.9 at 0, linear between.
double AlbedoLoss(double albedo);
/// The gloss itself within saturation_angle of the mirror direction, else 0: a share of the patches
/// of a surface is smooth enough to blind the camera.
double GlossLoss(const LineScannerOptions& options, double gloss, double mirror_offset_rad);
/// The clarity itself: that share of the light goes through or is mirrored away inside.
double ClarityLoss(double clarity);
/// Loss of a single sample: for darkness and clarity, independent of each other.
double SampleLoss(double albedo, double clarity);
/// Loss of a whole patch of a surface: for grazing light and gloss, likewise.
double PatchLoss(const LineScannerOptions& options, double gloss, const Encounter& encounter);

/// Diffuse albedo at 635 nm of a printed color with this red channel (sRGB): linear from the 4 %
/// that the darkest inks and coatings send back to the 85 % of white board. Estimates.
double PrintAlbedo(std::uint8_t red);

/// Light of a part of the line as the camera sees it.
struct Glint {
  double column_px = 0.0;
  double brightness = 0.0;  ///< >= 0
  std::size_t source = 0;   ///< what the caller wants to know it by
};

/// A peak of the line's image.
struct Blob {
  double column_px = 0.0;  ///< centroid
  double low_px = 0.0;     ///< extent: the columns of its outermost glints
  double high_px = 0.0;
  double brightness = 0.0;  ///< sum
  std::size_t source = 0;   ///< of its brightest glint
};

/// Splits glints where neighbors in the image lie further apart than `width_px` and returns the
/// brightest group's centroid; of equals the one with the smaller column. Sorts `glints`.
/// @return brightness 0 if there is no light.
Blob BrightestBlob(std::span<Glint> glints, double width_px);

}  // namespace rangegrasp::sensing::internal
