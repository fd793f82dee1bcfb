#include "trial/trial.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/stopwatch.h"
#include "sim/info.h"
#include "trial/objects.h"

namespace rangegrasp::trial {
namespace {

using nlohmann::ordered_json;

// Stages 1 to 6 up to where they end; `data` receives what the arrangement is.
Attempt ArrangeAndTry(const Cell& cell, const TrialSpec& spec, const Detector* detector,
                      const sim::ExecutionObserver& observer, double& arrange_s,
                      ordered_json& data) {
  base::Stopwatch watch;
  Redraws redraws;
  auto arranged = ArrangeTrial(cell, spec, redraws);
  arrange_s = watch.Seconds();
  data["redraws"] = Total(redraws);
  for (const auto& [reason, count] : redraws) data["redraw_reasons"][base::Word(reason)] = count;
  if (!arranged) {
    Attempt none;
    none.stage = "arrange";
    none.detail = "no arrangement: " + Text(redraws);
    return none;
  }
  data["scene_objects"] = arranged->world.objects();
  data["touching"] = arranged->touching;
  data["pose_class"] = arranged->pose_class;
  data["friction"] = arranged->world.glove_friction(arranged->target).static_mu;
  AttemptOptions options;
  options.seed = spec.seed;
  options.target = arranged->target;
  options.detector = detector;
  options.observer = observer;
  return RunAttempt(cell, arranged->world, options);
}

}  // namespace

std::string TrialId(const TrialSpec& spec) {
  return fmt::format("{}-{:04}", spec.object, spec.index);
}

std::uint64_t TrialSeed(std::uint64_t experiment_seed, const std::string& object, int index) {
  const std::uint64_t of_object =
      base::DeriveSeed(base::DeriveSeed(experiment_seed, "trial"), object);
  return base::DeriveSeed(of_object, static_cast<std::uint64_t>(index));
}

void AddTitles(const Options& options, experiment::Stamp& stamp) {
  for (const std::string& object : options.objects) {
    stamp.data[experiment::kTitlePrefix + object] =
        sim::ObjectTitle(ObjectModelOf(options, object));
  }
}

experiment::Result NoArrangement(const Redraws& redraws) {
  return {experiment::kCrashed, "arrange", "no arrangement: " + Text(redraws), "{}", {}};
}

std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec) {
  Redraws redraws;
  return ArrangeTrial(cell, spec, redraws);
}

std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec, Redraws& redraws) {
  base::Rng rng = StageStream(spec.seed, "arrange");
  auto arranged = cell.arranger->Arrange(spec.object, rng, redraws);
  if (arranged) {
    base::Rng friction = StageStream(spec.seed, "friction");
    arranged->world.DrawFriction(friction);
  }
  return arranged;
}

experiment::Result RunTrial(const Cell& cell, const TrialSpec& spec, const Detector* detector,
                            const sim::ExecutionObserver& observer, Attempt* seen) {
  base::Stopwatch whole;
  ordered_json data = {{"pose_class", ""},   {"friction", nullptr},
                       {"redraws", 0},       {"redraw_reasons", ordered_json::object()},
                       {"scene_objects", 0}, {"touching", 0}};
  double arrange_s = 0.0;
  Attempt attempt;
  try {
    attempt = ArrangeAndTry(cell, spec, detector, observer, arrange_s, data);
  } catch (const std::exception& e) {
    attempt.stage = "arrange";
    attempt.detail = e.what();
  }
  data.update(JsonOf(attempt));
  experiment::Result result{
      std::string(base::Word(attempt.outcome)), attempt.stage, attempt.detail, data.dump(), {}};
  result.seconds.emplace_back("arrange", arrange_s);
  result.seconds.insert(result.seconds.end(), attempt.seconds.begin(), attempt.seconds.end());
  result.seconds.emplace_back("trial", whole.Seconds());
  if (seen) *seen = std::move(attempt);
  return result;
}

}  // namespace rangegrasp::trial
