#include "trial/internal/single_arranger.h"

#include "trial/internal/arranging.h"
#include "trial/internal/resting.h"
#include "trial/objects.h"

namespace rangegrasp::trial::internal {
namespace {

// An arrangement that does not rest in view is drawn again, so often at most. None of the 120
// trials of laser_single needs it (seed 1); a scene where all of these fail is out of the sensor's
// view.
constexpr int kMaxDraws = 50;

class SingleArranger : public Arranger {
 public:
  SingleArranger(const Options& options, const robot::Robot& robot,
                 const sensing::LineScannerOptions& scanner)
      : options_(options),
        robot_(robot),
        scanner_(scanner),
        resting_(options, robot, options.objects) {}

  std::optional<Arrangement> Arrange(const std::string& target, base::Rng& rng,
                                     Redraws& redraws) const override {
    Arrangement trial{
        sim::World(options_.scene, {ObjectModelOf(options_, target)}, options_.physics)};
    trial.world.SetArm(robot_.home);
    for (int draw = 0; draw < kMaxDraws; ++draw) {
      const auto rest = resting_.Drop(trial.world, trial.target, rng);
      const auto wrong = rest ? PutDown(*rest->face, rng, trial) : Redraw::kOtherPose;
      if (wrong) {
        ++redraws[*wrong];
        continue;
      }
      trial.pose_class = rest->pose->label;
      return trial;
    }
    return std::nullopt;
  }

 private:
  // @return nullopt if it rests where it was put down, on that face and in view.
  std::optional<Redraw> PutDown(const sim::RestingFace& face, base::Rng& rng,
                                Arrangement& trial) const {
    const base::Pose X_WO =
        resting_.PutDown(face, robot_.workspace_radius_m, trial.world, trial.target, rng);
    if (!trial.world.Settle()) return Redraw::kNotAtRest;
    if (!Resting::IsAsPutDown(X_WO, trial.world, trial.target)) return Redraw::kOtherPose;
    if (!OutOfView(trial.world, robot_.X_WScanner, scanner_).empty()) return Redraw::kOutOfView;
    return std::nullopt;
  }

  const Options& options_;
  const robot::Robot& robot_;
  const sensing::LineScannerOptions& scanner_;
  Resting resting_;
};

}  // namespace

std::unique_ptr<Arranger> MakeSingleArranger(const Options& options, const robot::Robot& robot,
                                             const sensing::LineScannerOptions& scanner) {
  return std::make_unique<SingleArranger>(options, robot, scanner);
}

}  // namespace rangegrasp::trial::internal
