#pragma once

#include <array>
#include <string_view>

#include "base/image/image.h"

namespace rangegrasp::stereo {

/// What finds the disparity of each pixel.
enum class MatchMethod {
  kSemiGlobal,  ///< semi-global matching (Hirschmueller 2008), eight directions
  kBlock        ///< area block matching with a sliding window, as published (section 5.3.2)
};
constexpr std::array<std::string_view, 2> WordsOf(MatchMethod) { return {"semi_global", "block"}; }

/// Lengths are in pixels that are shrunk. What each does stands with its key (reconstruct.cpp).
struct MatchOptions {
  /// The dissertation's is block matching. Semi-global matching closes the gaps in poor texture by
  /// what surrounds them, at about the same cost.
  MatchMethod method = MatchMethod::kSemiGlobal;
  /// Two: half the noise, and windows and steps reach twice as far, which surfaces with little
  /// texture need more than others need a whole pixel, in an eighth of the time (docs/results.md).
  int shrink = 2;
  /// Of the sum of absolute differences (SAD). Larger: less noise and fewer holes, and edges that
  /// are rounder by half of it. The block's was chosen by the share of the surface and its error on
  /// pictures of the scene (docs/results.md); semi-global matching has its neighbors to hold on to.
  int block_window_px = 15;
  int semi_global_window_px = 5;
  /// Larger: smoother, and steps are lost.
  double small_step_cost = 8.0;
  double large_step_cost = 32.0;
  /// Less of both: fewer holes, and wrong matches in them. Texture is the sum of slopes, cut off at
  /// the prefilter's 31.
  int uniqueness_percent = 25;
  int min_texture = 10;
  int max_left_right_px = 1;
  int min_patch_px = 100;
  int patch_step_px = 1;
  /// Of a patch's width (the root of its number of pixels). A wall without texture, matched by its
  /// noise, has no edges; a white cup has its outline.
  double min_edges = 1.0;
  /// A plain wall or rail next to an object takes on the object's disparity, but only near it.
  /// Larger: fewer of these fringes, and holes in surfaces that are matched in parts.
  double consensus_share = 0.4;
  int consensus_levels = 20;
  int consensus_reach_px = 24;
  double edge_levels = 5.0;  ///< above what noise of a shrunk picture does
};

/// Disparities [px] of the left picture's pixels: its column minus the right one's; NaN where there
/// is no match.
using Disparity = image::Grey<float>;

/// Which pixels are matched: 0 where a pixel was removed.
using Mask = image::Grey8;

/// Finds the disparity of each kept pixel. Removed pixels are black to the matching and have no
/// disparity. Only the rectangle round the kept pixels is looked at. Single-threaded (trials run in
/// parallel); depends on the arguments alone. O(pixels * disparities).
/// @param left, right  rectified, of one size; of colour pictures their brightness is matched.
/// @param min_px, max_px  the range of the disparities, 0 <= min < max; the search covers it whole.
/// @param whole_left  the left picture before anything was removed: where removed pixels end is no
/// edge of it.
/// @throws std::invalid_argument if an option is out of range or sizes differ.
Disparity Match(const image::Grey8& left, const image::Grey8& right, const Mask& left_mask,
                const image::Image& whole_left, double min_px, double max_px,
                const MatchOptions& options);

}  // namespace rangegrasp::stereo
