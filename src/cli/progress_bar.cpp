#include "cli/progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

namespace rangegrasp::cli {
namespace {

constexpr int kWidth = 30;  // in characters

}  // namespace

void ProgressBar::operator()(int done_now, int, const experiment::Record& last) {
  const int done = before_ + done_now;
  ++outcomes_[last.result.outcome];
  if (!isatty(STDERR_FILENO)) return;
  const double rate_hz = done_now / watch_.Seconds();
  const int filled = kWidth * done / total_;
  std::string counts;
  for (const auto& [outcome, count] : outcomes_) {
    counts += fmt::format(", {} {}", count, outcome);
    // Of what this part of the run has done.
    if (outcome == success_) counts += fmt::format(" ({:.0f} %)", 100.0 * count / done_now);
  }
  fmt::print(stderr, "\r[{:#<{}}{:.<{}}] {}/{}{}, {:.3g} a second, {:.0f} s left \033[K", "",
             filled, "", kWidth - filled, done, total_, counts, rate_hz, (total_ - done) / rate_hz);
  if (done == total_) fmt::print(stderr, "\n");
  std::fflush(stderr);
}

}  // namespace rangegrasp::cli
