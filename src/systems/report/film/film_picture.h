#pragma once

#include <string>
#include <vector>

#include "base/image/image.h"
#include "report/film/strip_chart.h"
#include "sim/execute.h"

namespace rangegrasp::report {

/// Of a film's pictures [px]: even, as its encoder wants them.
inline constexpr int kFilmWidth_px = 1280;
inline constexpr int kFilmHeight_px = 720;
/// Of the scene, on the left; the scan stands on the right, the state below it.
inline constexpr int kFilmScene_px = 800;

/// What a film shows of one execution besides the scene: what was perceived, and the state from its
/// start to now.
class FilmState {
 public:
  explicit FilmState(std::string name) : name_(std::move(name)) {}

  void SetScan(const image::Image& perceived);
  void Add(const sim::ExecutionState& state);
  /// The film's picture. @param scene  kFilmScene_px x kFilmHeight_px
  image::Image Compose(const image::Image& scene) const;

 private:
  std::string name_;   ///< of the trial
  image::Image scan_;  // empty until there is one
  double start_s_ = 0.0;
  std::vector<double> time_s_, force_N_, felt_N_, slip_mm_;
  std::vector<draw::Mark> stages_;
};

}  // namespace rangegrasp::report
