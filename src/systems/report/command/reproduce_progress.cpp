#include "report/command/reproduce_progress.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

namespace rangegrasp::cli {
namespace {

/// The plan counts as if so much of it had come true before anything was measured [s].
constexpr double kTrust_s = 20.0;

std::string TimeText(double seconds) {
  return seconds < 90.0 ? fmt::format("{:.0f} s", seconds)
                        : fmt::format("{:.0f} min", seconds / 60.0);
}

}  // namespace

void ReproduceProgress::Begin(const std::string& name, const PlannedCases& run) {
  name_ = name;
  run_ = run;
  done_ = 0;
  if (isatty(STDERR_FILENO)) return;
  spdlog::info("{}: {} cases, {} of them done; {} of {} cases before it, about {} left", name_,
               run_.all, run_.stored, before_, all_.all, TimeText(LeftSeconds()));
}

void ReproduceProgress::OneDone() {
  ++done_;
  const double planned_s = run_.left_s / (run_.all - run_.stored);
  all_.left_s -= planned_s;
  spent_s_ += planned_s;
  if (!isatty(STDERR_FILENO)) return;
  fmt::print(stderr, "\r{}: {} of {} cases; {} of {} in all, about {} left\033[K", name_,
             run_.stored + done_, run_.all, before_ + run_.stored + done_, all_.all,
             TimeText(LeftSeconds()));
  std::fflush(stderr);
}

void ReproduceProgress::End() {
  const int open = run_.all - run_.stored;
  if (open > 0) all_.left_s -= run_.left_s * (open - done_) / open;
  before_ += run_.all;
  if (isatty(STDERR_FILENO)) fmt::print(stderr, "\r\033[K");
}

double ReproduceProgress::LeftSeconds() const {
  return all_.left_s * (watch_.Seconds() + kTrust_s) / (spent_s_ + kTrust_s);
}

}  // namespace rangegrasp::cli
