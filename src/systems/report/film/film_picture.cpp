#include "report/film/film_picture.h"

#include <fmt/format.h>

#include "base/units.h"
#include "report/film/sheet.h"

namespace rangegrasp::report {
namespace {

constexpr int kRight_px = kFilmWidth_px - kFilmScene_px;
constexpr int kScan_px = kFilmHeight_px / 2;  // its height
/// A white band for the title, which is not to be read on a dark arm.
constexpr int kTitleWidth_px = 420;
constexpr int kTitleHeight_px = 36;
/// So far up the axes reach at least: the shipped hand's first grip, and a slip that is seen.
constexpr double kForce_N = 20.0;
constexpr double kSlip_mm = 5.0;

const draw::Color kCommand(0.85F, 0.37F, 0.01F, 1.0F);
const draw::Color kFelt(0.12F, 0.47F, 0.71F, 1.0F);
const draw::Color kSlip(0.17F, 0.55F, 0.20F, 1.0F);

}  // namespace

void FilmState::SetScan(const image::Image& perceived) {
  scan_ = draw::Fitted(perceived, kRight_px, kScan_px);
}

void FilmState::Add(const sim::ExecutionState& state) {
  if (stages_.empty() || stages_.back().name != state.stage) {
    if (stages_.empty()) start_s_ = state.time_s;  // the axis is of the execution's own time
    stages_.push_back({state.time_s - start_s_, state.stage});
  }
  time_s_.push_back(state.time_s - start_s_);
  force_N_.push_back(state.force_N);
  felt_N_.push_back(state.felt_N);
  slip_mm_.push_back(state.slip_m * base::kMmPerM);
}

image::Image FilmState::Compose(const image::Image& scene) const {
  image::Image picture = draw::Blank(kFilmWidth_px, kFilmHeight_px);
  draw::Paste(scene, 0, 0, picture);
  if (scan_.width > 0) draw::Paste(scan_, kFilmScene_px, 0, picture);
  const std::vector<draw::Trace> traces = {{"grip force, told [N]", force_N_, kForce_N, kCommand},
                                           {"grip force, felt [N]", felt_N_, kForce_N, kFelt},
                                           {"slip in the hand [mm]", slip_mm_, kSlip_mm, kSlip}};
  draw::Paste(draw::DrawStrips(time_s_, traces, stages_, kRight_px, kFilmHeight_px - kScan_px),
              kFilmScene_px, kScan_px, picture);
  const std::string stage = stages_.empty() ? "" : stages_.back().name;
  draw::Paste(draw::Blank(kTitleWidth_px, kTitleHeight_px), 0, 0, picture);
  draw::WriteText(fmt::format("{}   {}", name_, stage), 12, 25, 0.65, picture);
  return picture;
}

}  // namespace rangegrasp::report
