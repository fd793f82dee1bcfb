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
  const double left_s = watch_.Seconds() / done_now * (total_ - done);
  const int filled = kWidth * done / total_;
  std::string counts;
  for (const auto& [outcome, count] : outcomes_) counts += fmt::format(", {} {}", count, outcome);
  fmt::print(stderr, "\r[{:#<{}}{:.<{}}] {}/{}{}, {:.0f} s left \033[K", "", filled, "",
             kWidth - filled, done, total_, counts, left_s);
  if (done == total_) fmt::print(stderr, "\n");
  std::fflush(stderr);
}

}  // namespace rangegrasp::cli
