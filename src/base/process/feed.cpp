#include "base/process/feed.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "base/error.h"
#include "base/process/internal/guard.h"
#include "base/process/internal/pipe_signal.h"
#include "base/stopwatch.h"

namespace rangegrasp::process {
namespace {

// Of what it writes to stderr so much is kept, and so much of it shown.
constexpr std::size_t kFeedKept_bytes = 4096;
constexpr std::size_t kFeedShown = 400;

}  // namespace

struct Feed::Impl {
  Program program;
  std::string name;
  internal::Guard guard;
  std::string err;

  Impl(const Program& what, std::string of) : program(what), name(std::move(of)), guard(program) {}

  [[noreturn]] void Fail(const std::string& why) {
    guard.Kill();
    ReadErr();
    const std::string words = LastWords(err, kFeedShown);
    throw base::RunError(fmt::format("{}: {} {}{}", name, program.command.front(), why,
                                     words.empty() ? "" : ": " + words));
  }

  // Waits for something to do, as long as it may take.
  void Wait(const base::Stopwatch& watch, const char* too_long) {
    const double left_s = program.limit_s - watch.Seconds();
    if (left_s <= 0.0) Fail(fmt::format("{} for {:g} s", too_long, program.limit_s));
    std::array<pollfd, 3> waits{
        {{guard.in(), POLLOUT, 0}, {guard.out(), POLLIN, 0}, {guard.err(), POLLIN, 0}}};
    poll(waits.data(), waits.size(), 1 + static_cast<int>(left_s * 1000.0));
    if (waits[1].revents != 0) Drain();
    if (waits[2].revents != 0) ReadErr();
  }

  // What it prints is of no use, and must not block it.
  void Drain() {
    std::array<char, 65536> buffer{};
    const ssize_t n = read(guard.out(), buffer.data(), buffer.size());
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) guard.CloseOut();
  }

  void ReadErr() {
    if (guard.err() < 0) return;
    std::array<char, 4096> buffer{};
    const ssize_t n = read(guard.err(), buffer.data(), buffer.size());
    if (n > 0) err.append(buffer.data(), static_cast<std::size_t>(n));
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) guard.CloseErr();
    if (err.size() > kFeedKept_bytes) err.erase(0, err.size() - kFeedKept_bytes);
  }

  // Reads what it still has to say, and waits for its end.
  int ExitCode() {
    const base::Stopwatch watch;
    while (guard.ExitCode() < 0) {
      if (guard.out() < 0 && guard.err() < 0) {
        if (watch.Seconds() > program.limit_s) Fail("does not end");
        usleep(1000);
      } else {
        Wait(watch, "does not end");
      }
    }
    ReadErr();
    return guard.ExitCode();
  }
};

Feed::Feed(const Program& program, std::string name)
    : impl_(std::make_unique<Impl>(program, std::move(name))) {}

Feed::~Feed() = default;

void Feed::Write(std::span<const std::uint8_t> bytes) {
  const internal::WithoutPipeSignal without;
  base::Stopwatch watch;
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const ssize_t n = write(impl_->guard.in(), bytes.data() + sent, bytes.size() - sent);
    if (n > 0) {
      sent += static_cast<std::size_t>(n);
      watch.Restart();
    } else if (errno == EAGAIN || errno == EINTR) {
      impl_->Wait(watch, "takes nothing more");
    } else {
      impl_->guard.CloseIn();
      const int code = impl_->ExitCode();
      impl_->Fail(internal::HowItEnded(code) + " before it had all");
    }
  }
}

void Feed::Finish() {
  impl_->guard.CloseIn();
  const int code = impl_->ExitCode();
  if (code != 0) impl_->Fail(internal::HowItEnded(code));
}

}  // namespace rangegrasp::process
