#include "perception/perception_options.h"

#include <algorithm>

namespace rangegrasp::perception {
namespace {

using base::kMm;
using base::YamlMap;

/// The area of the smallest segment, and bounds of its number of points: with fewer, nothing can be
/// concluded.
constexpr double kSegment_m2 = 3.4e-4;
constexpr int kMinSegmentPoints = 8;
constexpr int kMaxSegmentPoints = SegmentOptions().min_points;

// Reads a length that adapts to the sensor unless the file gives it.
void ReadLength(YamlMap& map, const std::string& key, AdaptiveLength& length, double low_mm,
                double high_mm, const std::string& doc) {
  double value_m = length;
  map.ReadScaled(key, value_m, kMm, low_mm, high_mm,
                 doc + "; default: larger for a noisier or coarser sensor");
  if (map.Has(key)) length = value_m;
}

}  // namespace

void AdaptLengths(const Sampling& sampling, PerceptionOptions& options) {
  const auto adapt = [&](auto&... lengths) { (lengths.AdaptTo(sampling), ...); };
  PreprocessOptions& p = options.preprocess;
  SegmentOptions& s = options.segment;
  FeatureOptions& f = options.features;
  MergeOptions& m = f.merge;
  CompletionOptions& c = f.completion;
  adapt(p.preselection_m, p.plane_distance_m, p.table_clearance_m, p.filter_unit_m, p.filter_keep_m,
        p.smooth_radius_m, p.normal_radius_m);
  adapt(s.min_alpha_m, s.max_alpha_m);
  if (sampling.spacing_m > 0.0) {
    const double points = kSegment_m2 / (sampling.spacing_m * sampling.spacing_m);
    s.min_points = std::clamp(static_cast<int>(std::min(points, 1.0 * kMaxSegmentPoints)),
                              kMinSegmentPoints, kMaxSegmentPoints);
  }
  adapt(s.convexity.link_m, s.convexity.patch_m, s.convexity.step_m);
  adapt(f.top.plane_distance_m, f.top.slab_m, f.top.rim_alpha_m, f.top.bridged_rim_alpha_m);
  adapt(f.circle.distance_m, f.axis.section_m, f.axis.max_sunk_m, f.axis.lid_distance_m);
  adapt(m.fragment_gap_m, m.footprint_margin_m, m.height_margin_m, m.max_in_front_m);
  adapt(f.container.wall_m, f.container.rim_margin_m);
  adapt(c.free_margin_m, c.end_band_m, c.wall_outline_m, c.lean_margin_m, c.cell_m, c.attached_m,
        c.link_m, c.on_table_m);
}

void ReadOptions(YamlMap map, PerceptionOptions& options) {
  map.Read("segmentation", options.segment.method, "segmentation of the points above the table");
  map.Read("filter", options.preprocess.filter, "remove outliers by the compression rate");
  map.Read("isolated_outliers", options.preprocess.isolated_outliers,
           "remove only isolated outliers; off: the test exactly as printed");
  map.Read("smooth", options.preprocess.smooth, "smooth the points above the table");
  ReadLength(map, "normal_radius_mm", options.preprocess.normal_radius_m, 1.0, 50.0,
             "radius of the neighborhood for normal estimation");
  ReadLength(map, "plane_distance_mm", options.preprocess.plane_distance_m, 0.2, 50.0,
             "maximum distance of inliers from the table's plane");
  ReadLength(map, "table_clearance_mm", options.preprocess.table_clearance_m, 0.0, 50.0,
             "minimum height of object points above the table's plane");
  map.Read("containers", options.features.containers,
           "treat the walls of an open box as obstacles; off: as objects");
  base::ReadAdditions<PreprocessAdditions>(map, options.preprocess);
  base::ReadAdditions<SegmentAdditions>(map, options.segment);
  base::ReadAdditions<FeatureAdditions>(map, options.features);
  map.Finish();
}

}  // namespace rangegrasp::perception
