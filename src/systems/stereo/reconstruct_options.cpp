#include "stereo/reconstruct_options.h"

#include "base/units.h"

namespace rangegrasp::stereo {
namespace {

using base::kMm;

// Windows have a middle.
void ReadWindow(base::YamlMap& map, const char* key, int& value, int low, int high,
                const char* doc) {
  map.Read(key, value, low, high, doc);
  if (value % 2 == 0) map.Fail(key, "must be odd: a window has a middle");
}

void ReadMatch(base::YamlMap& map, MatchOptions& o) {
  map.Read("matching", o.method,
           "what finds the disparities; the dissertation's is block matching");
  map.Read("shrink", o.shrink, 1, 8,
           "squares of so many pixels are averaged before matching; the following are in these");
  ReadWindow(map, "block_window_px", o.block_window_px, 5, 255,
             "block: side of the window whose differences are summed, odd");
  ReadWindow(map, "semi_global_window_px", o.semi_global_window_px, 1, 15, "semi_global: the same");
  map.Read("small_step_cost", o.small_step_cost, 0.0, 1000.0,
           "semi_global: cost of a disparity that differs by one, in grey levels a pixel");
  map.Read("large_step_cost", o.large_step_cost, 0.0, 1000.0,
           "semi_global: of one that differs by more");
  map.Read("uniqueness_percent", o.uniqueness_percent, 0, 100,
           "the second best match must be worse by this share");
  map.Read("min_texture", o.min_texture, 0, 100000, "block: less slope in a window is no texture");
  map.Read("max_left_right_px", o.max_left_right_px, -1, 100,
           "matches from left and from right agree within this; -1: not checked");
  map.Read("min_patch_px", o.min_patch_px, 0, 1000000, "smaller patches of matches are removed");
  map.Read("patch_step_px", o.patch_step_px, 0, 100, "within which the disparity changes less");
  map.Read("consensus_share", o.consensus_share, 0.0, 1.0,
           "this part of the pixels of like colour round a match share it; 0: not asked for");
  map.Read("consensus_levels", o.consensus_levels, 1, 255, "like: each channel within this");
  map.Read("consensus_reach_px", o.consensus_reach_px, 1, 1000, "round it: so far away");
  map.Read("min_edges", o.min_edges, 0.0, 100.0,
           "patches with fewer edge pixels, as a share of their width, are removed; 0: all stay");
  map.Read("edge_levels", o.edge_levels, 0.0, 255.0,
           "grey changes by this from pixel to pixel at an edge");
  if (o.small_step_cost >= o.large_step_cost) {
    map.Fail(map.Has("small_step_cost") ? "small_step_cost" : "large_step_cost",
             "small_step_cost must be below large_step_cost");
  }
}

}  // namespace

void ReadReconstructOptions(base::YamlMap& map, ReconstructOptions& o) {
  ReadMatch(map, o.match);
  map.Read("remove_blue", o.remove_blue, "blue pixels are the table's: removed before matching");
  map.Read("blue_share", o.blue_share, 0.0, 1.0,
           "blue exceeds red and green by this share of itself");
  map.Read("blue_levels", o.blue_levels, 0, 255, "and by so many of 255 levels");
  ReadWindow(map, "blue_window_px", o.blue_window_px, 1, 255,
             "a pixel's colour is what most of this window's pixels have");
  map.Read("step_px", o.step_px, 1, 64, "one sample for so many pixels in both directions");
  map.Read("min_share", o.min_share, 0.0, 1.0, "of which this share must agree ...");
  map.Read("max_spread_px", o.max_spread_px, 0.0, 100.0, "... within this");
  map.Read("min_table_px", o.min_table_px, 0, 1000000,
           "smaller patches of blue are print, where no table is seen");
  map.ReadScaled("height_mm", o.volume_height_m, kMm, 10.0, 1e4,
                 "only what is lower than this above the workspace is reconstructed");
  map.ReadScaled("near_mm", o.near_m, kMm, 10.0, 1e5, "nearest depth that is searched");
  map.ReadScaled("far_mm", o.far_m, kMm, 10.0, 1e5, "furthest depth that is searched");
  map.Read("disparity_sigma_px", o.disparity_sigma_px, 0.0, 100.0,
           "standard deviation of a disparity, which the noise of a sample follows from");
  if (o.near_m >= o.far_m)
    map.Fail(map.Has("near_mm") ? "near_mm" : "far_mm", "near_mm must be below far_mm");
  map.Finish();
}

}  // namespace rangegrasp::stereo
