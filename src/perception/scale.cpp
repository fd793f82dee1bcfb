#include <stdexcept>

#include "perception/perceive.h"

namespace rangegrasp::perception {

void ScaleLengths(double factor, PerceptionOptions& options) {
  if (!(factor > 0.0)) throw std::invalid_argument("ScaleLengths: the factor must be positive");
  PreprocessOptions& p = options.preprocess;
  for (double* length : {&p.preselection_m, &p.plane_distance_m, &p.table_clearance_m,
                         &p.smooth_radius_m, &p.normal_radius_m}) {
    *length *= factor;
  }
  SegmentOptions& s = options.segment;
  for (double* length : {&s.alpha_m, &s.min_alpha_m, &s.max_alpha_m}) *length *= factor;
  FeatureOptions& f = options.features;
  for (double* length : {&f.plane_distance_m, &f.rim_alpha_m, &f.bridged_rim_alpha_m,
                         &f.circle_distance_m, &f.section_m, &f.fragment_gap_m}) {
    *length *= factor;
  }
}

}  // namespace rangegrasp::perception
