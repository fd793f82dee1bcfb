#pragma once

#include <array>
#include <string_view>

#include "base/image/image.h"

namespace rangegrasp::stereo {

/// Method that finds the disparity of each pixel.
enum class MatchMethod {
  kSemiGlobal,  ///< semi-global matching (Hirschmueller 2008), eight directions
  kBlock        ///< area block matching with a sliding window, as published (section 5.3.2)
};
constexpr std::array<std::string_view, 2> WordsOf(MatchMethod) { return {"semi_global", "block"}; }

/// Lengths are in shrunk pixels. The keys in reconstruct.cpp describe each option.
struct MatchOptions {
  /// The dissertation uses block matching. Semi-global matching fills gaps in poor texture from
  /// their surroundings, at about the same cost.
  MatchMethod method = MatchMethod::kSemiGlobal;
  /// 2: half the noise, an eighth of the time (docs/results.md), and windows and steps reach twice
  /// as far. Surfaces with little texture need this more than others need full resolution.
  int shrink = 2;
  /// Window of the sum of absolute differences (SAD). Larger: less noise and fewer holes, but edges
  /// are rounded by half of it. The block's was chosen by the share of the surface and its error on
  /// pictures of the scene (docs/results.md); semi-global matching also has its neighbors.
  int block_window_px = 15;
  int semi_global_window_px = 5;
  int uniqueness_percent = 25;  ///< lower: fewer holes, but wrong matches in them
  int max_left_right_px = 1;
  int min_patch_px = 100;
  /// Relative to a patch's width (the square root of its number of pixels). A wall without texture
  /// that is matched by its noise has no edges; a white cup has its outline.
  double min_edges = 1.0;
  /// A plain wall or rail next to an object takes on the object's disparity, but only near it.
  /// Larger: fewer of these fringes, but holes in surfaces that are partly matched.
  double consensus_share = 0.4;
};

/// Disparities [px] of the left picture's pixels: left column minus right column; NaN where there
/// is no match.
using Disparity = image::Grey<float>;

/// Pixels to match: 0 where a pixel was removed.
using Mask = image::Grey8;

/// Finds the disparity of each kept pixel. Removed pixels are black in the matching and have no
/// disparity. Only the bounding rectangle of the kept pixels is processed. Single-threaded (trials
/// run in parallel); depends only on the arguments. O(pixels * disparities).
/// @param left, right  rectified, of the same size; brightness of colour pictures.
/// @param min_px, max_px  the range of the disparities, 0 <= min < max; all of it is searched.
/// @param whole_left  the left picture before pixels were removed, so that borders of removed areas
/// are not edges.
Disparity Match(const image::Grey8& left, const image::Grey8& right, const Mask& left_mask,
                const image::Image& whole_left, double min_px, double max_px,
                const MatchOptions& options);

}  // namespace rangegrasp::stereo
