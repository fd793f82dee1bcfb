#include "cli/step_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <utility>

namespace rangegrasp::cli {
namespace {

using std::chrono::milliseconds;

/// What is done sooner needs no line.
constexpr milliseconds kPatience{1000};
constexpr milliseconds kPeriod{200};

}  // namespace

StepLine::StepLine(std::string title) : title_(std::move(title)) {
  if (!isatty(STDERR_FILENO)) return;
  thread_ = std::jthread([this](const std::stop_token& stop) { Tick(stop); });
}

void StepLine::Begin(const std::string& step) {
  const std::lock_guard lock(mutex_);
  step_ = step;
}

void StepLine::End() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

void StepLine::Tick(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  bool shown = false;
  const auto stopped = [&](milliseconds wait) {
    return ends_.wait_for(lock, stop, wait, [&] { return stop.stop_requested(); });
  };
  for (auto wait = kPatience; !stopped(wait); wait = kPeriod) {
    fmt::print(stderr, "\r{}: {}, {:.0f} s \033[K", title_, step_, watch_.Seconds());
    std::fflush(stderr);
    shown = true;
  }
  if (!shown) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
}

}  // namespace rangegrasp::cli
