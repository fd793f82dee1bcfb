#include "grasp/score.h"

#include <algorithm>
#include <cmath>

namespace rangegrasp::grasp {
namespace {

double Square(double x) { return x * x; }

}  // namespace

double Score(const Quality& q, double friction_cone_rad, const ScoreWeights& w) {
  const double angle = std::max(q.angles.finger_rad, q.angles.thumb_rad);
  const double height_scale = q.above_m > 0.0 ? w.above_scale_m : w.below_scale_m;
  const double missing_margin = std::max(0.0, w.margin_m - q.top_margin_m) / w.margin_m;
  const double missing_room = std::clamp(1.0 - q.room_m / w.room_scale_m, 0.0, 1.0);
  double score = 1.0;
  score -= w.antipodal * std::min(Square(angle / friction_cone_rad), w.max_square);
  score -= w.pitch *
           std::min(Square((q.pitch_rad - q.best_pitch_rad) / w.pitch_scale_rad), w.max_square);
  score -= w.lever * std::min(Square(q.lever_m / w.lever_scale_m), w.max_square);
  score -= w.height * std::min(Square(q.above_m / height_scale), w.max_multiple);
  score -= w.drag * std::min(std::abs(q.drag_m) / w.drag_scale_m, w.max_multiple);
  score -= w.slope * std::min(std::abs(q.slope_m) / w.slope_scale_m, w.max_multiple);
  score -= w.shallow * std::min(missing_margin, w.max_multiple);
  score -= w.room * Square(missing_room);
  score += w.tight * std::min(q.contact_m2 / w.contact_scale_m2, 1.0);
  score += w.arm * q.thumb_to_arm;
  return score;
}

}  // namespace rangegrasp::grasp
