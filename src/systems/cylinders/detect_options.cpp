#include "cylinders/detect_options.h"

#include "perception/perceive.h"

namespace rangegrasp::cylinders {

DetectOptions AsPublished() {
  DetectOptions options;
  base::SwitchAll<DetectAdditions>(false, options);
  return options;
}

void AdaptLengths(const perception::Sampling& sampling, DetectOptions& options) {
  perception::PerceptionOptions perception_options;
  perception_options.preprocess = options.preprocess;
  perception::AdaptLengths(sampling, perception_options);
  options.preprocess = perception_options.preprocess;
  for (perception::AdaptiveLength* length :
       {&options.curvature.radius_m, &options.curvature.line_step_m, &options.barrel.distance_m,
        &options.barrel.first_distance_m, &options.barrel.piece_m, &options.search.min_scatter_m,
        &options.accept.rim_distance_m, &options.accept.max_rim_error_m,
        &options.accept.max_radius_error_m, &options.accept.max_height_error_m,
        &options.accept.max_face_error_m, &options.accept.view_tolerance_m}) {
    length->AdaptTo(sampling);
  }
}

}  // namespace rangegrasp::cylinders
