#include "base/process/ask.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include "base/process/internal/guard.h"
#include "base/process/internal/pipe_signal.h"
#include "base/stopwatch.h"
#include "base/words.h"

namespace rangegrasp::process {
namespace {

using internal::Guard;
using internal::HowItEnded;
using internal::WithoutPipeSignal;

// Of what it writes to stderr so much is kept, and so much of it shown.
constexpr std::size_t kKept_bytes = 4096;
constexpr std::size_t kShown = 400;
// Between the end of its output and its own end [s]; what takes longer is killed.
constexpr double kEnding_s = 1.0;

class Conversation {
 public:
  Conversation(const Program& program, std::string_view question)
      : program_(program), question_(std::string(question) + "\n"), guard_(program) {}

  Reply Hold() {
    const WithoutPipeSignal without;
    while (!ended_) {
      const double left_s = program_.limit_s - watch_.Seconds();
      if (left_s <= 0.0) {
        Fail(fmt::format("no answer within {:g} s", program_.limit_s));
        break;
      }
      Wait(left_s);
      Write();
      ReadOut();
      ReadErr();
      if (!ended_ && guard_.out() < 0) AtEnd();
    }
    guard_.Kill();
    ReadErr();
    reply_.last_words = LastWords(err_, kShown);
    return std::move(reply_);
  }

 private:
  void Fail(const std::string& why) {
    reply_.failure = why;
    ended_ = true;
  }
  void Answer(std::size_t length) {
    out_.resize(length);
    reply_.line = std::move(out_);
    ended_ = true;
  }

  void Wait(double left_s) {
    std::array<pollfd, 3> waits{{{guard_.in(), POLLOUT, 0},  // those below 0 are passed over
                                 {guard_.out(), POLLIN, 0},
                                 {guard_.err(), POLLIN, 0}}};
    poll(waits.data(), waits.size(), 1 + static_cast<int>(left_s * 1000.0));
  }

  void Write() {
    if (guard_.in() < 0) return;
    const ssize_t n = write(guard_.in(), question_.data() + sent_, question_.size() - sent_);
    if (n > 0) sent_ += static_cast<std::size_t>(n);
    // One that does not want to know may answer all the same.
    const bool broken = n < 0 && errno != EAGAIN && errno != EINTR;
    if (broken || sent_ == question_.size()) guard_.CloseIn();
  }

  // @return whether the pipe is still open
  static bool Read(int from, std::string& text) {
    std::array<char, 65536> buffer{};
    const ssize_t n = read(from, buffer.data(), buffer.size());
    if (n > 0) text.append(buffer.data(), static_cast<std::size_t>(n));
    return n > 0 || (n < 0 && (errno == EAGAIN || errno == EINTR));
  }

  void ReadOut() {
    if (ended_ || guard_.out() < 0) return;
    const std::size_t before = out_.size();
    if (!Read(guard_.out(), out_)) guard_.CloseOut();
    const std::size_t end = out_.find('\n', before);
    if (std::min(end, out_.size()) > program_.max_answer_bytes) {
      return Fail(
          fmt::format("an answer of more than {} bytes in one line", program_.max_answer_bytes));
    }
    if (end != std::string::npos) Answer(end);
  }

  void ReadErr() {
    if (guard_.err() < 0) return;
    if (!Read(guard_.err(), err_)) guard_.CloseErr();
    if (err_.size() > kKept_bytes) err_.erase(0, err_.size() - kKept_bytes);
  }

  // Its output has ended without an end of line.
  void AtEnd() {
    const base::Stopwatch ending;
    while (guard_.ExitCode() < 0 && ending.Seconds() < kEnding_s) {
      ReadErr();
      usleep(200);
    }
    const int code = guard_.ExitCode();
    if (code == 0 && !out_.empty()) return Answer(out_.size());
    Fail(code < 0 ? std::string("closed its output without an answer")
                  : HowItEnded(code) + " without an answer");
  }

  const Program& program_;
  std::string question_;
  std::size_t sent_ = 0;
  base::Stopwatch watch_;
  Guard guard_;
  bool ended_ = false;
  std::string out_, err_;
  Reply reply_;
};

}  // namespace

Reply Ask(const Program& program, std::string_view question) {
  return Conversation(program, question).Hold();
}

std::optional<std::filesystem::path> Find(const std::string& name) {
  const auto is_program = [](const std::filesystem::path& file) {
    return std::filesystem::is_regular_file(file) && access(file.c_str(), X_OK) == 0;
  };
  if (name.find('/') != std::string::npos) {
    if (is_program(name)) return std::filesystem::absolute(name);
    return std::nullopt;
  }
  const char* path = std::getenv("PATH");
  for (const std::string& folder : base::Split(path ? path : "/usr/bin:/bin", ':')) {
    const auto file = std::filesystem::path(folder.empty() ? "." : folder) / name;
    if (is_program(file)) return std::filesystem::absolute(file);
  }
  return std::nullopt;
}

std::string LastWords(std::string_view text, std::size_t max_characters) {
  std::string words;
  for (const char c : text) {
    if (c == '\n' || c == '\r') {
      if (!words.empty() && !words.ends_with(" | ")) words += " | ";
    } else {
      words += c >= ' ' && c <= '~' ? c : '?';
    }
  }
  if (words.ends_with(" | ")) words.erase(words.size() - 3);
  if (words.size() > max_characters) words = "..." + words.substr(words.size() - max_characters);
  return words;
}

}  // namespace rangegrasp::process
