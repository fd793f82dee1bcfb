#include <fmt/format.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/process/sandbox.h"
#include "external/detector_check.h"
#include "external/outside_detector.h"
#include "trial/registry.h"

namespace rangegrasp {
namespace {

namespace fs = std::filesystem;
using external::kExternal;
using external::OutsideOptions;
using trial::Options;

void Read(base::YamlMap keys, Options& options) {
  ReadOutside(std::move(keys), trial::Of<OutsideOptions>(options, kExternal));
}

// A sandbox that is asked for can be made here, and a trial does not end before the detector's time
// is over.
void Check(const base::YamlMap& map, const Options& all, double case_limit_s) {
  const auto options = trial::Of<OutsideOptions>(all, kExternal);
  if (options.command.empty()) map.Fail("detector", "key 'command': is missing and has no default");
  if (options.limit_s >= case_limit_s) {
    map.Fail("detector", fmt::format("time_limit_s is {:g} s: it must be less than trial_limit_s "
                                     "({:g} s), which the whole trial has",
                                     options.limit_s, case_limit_s));
  }
  if (!options.sandbox) return;
  if (const auto why = process::WhyNoSandbox()) {
    map.Fail("detector", "no sandbox can be made: " + *why +
                             "; `sandbox: false` (--set detector.sandbox=false) runs the detector "
                             "without one, if you trust it");
  }
}

// A hash of the files that the command names.
void AddTo(const Options& all, experiment::Stamp& stamp) {
  const auto options = trial::Of<OutsideOptions>(all, kExternal);
  std::uint64_t hash = base::Fnv1a(options.sandbox ? "sandbox" : "");
  for (const fs::path& file : options.files) {
    if (fs::is_regular_file(file)) {
      hash = base::Fnv1a(file.filename().string() + base::ReadFile(file), hash);
    }
  }
  stamp.identity["detector_hash"] = base::Hex(hash);
}

}  // namespace

void RegisterExternal() {
  trial::AddDetector(
      {.word = trial::kDetectorWithKeys,
       .make =
           [](const Options& options, const robot::Robot& robot, grasp::SceneObserver observer) {
             return external::MakeOutsideDetector(trial::Of<OutsideOptions>(options, kExternal),
                                                  options, robot, std::move(observer));
           },
       .read = Read,
       .check = Check,
       .add_to = AddTo,
       .hide =
           [](const fs::path& folder, Options& options) {
             trial::Of<OutsideOptions>(options, kExternal).hidden.push_back(folder);
           },
       .check_answers = external::CheckAnswers});
}

}  // namespace rangegrasp
