#include "cli/output.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <thread>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"

namespace rangegrasp::cli {
namespace {

// Width of a ProgressBar [characters].
constexpr int kWidth = 30;
// Limits of a picture [px]: smaller ones show nothing, larger ones exceed the offscreen buffer.
constexpr int kMinSide_px = 16;
constexpr int kMaxSide_px = 8192;

}  // namespace

void WriteResult(const std::string& text, const std::filesystem::path& file) {
  if (!file.empty()) return base::WriteFile(file, text);
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) {
    return;
  }
  if (errno == EPIPE) return;  // the reader has closed the pipe: `| head`
  throw base::RunError("stdout: the results could not be written");
}

void WriteTables(const experiment::Report& report, const experiment::Stamp& stamp,
                 experiment::TableFormat format) {
  WriteResult(experiment::Format(report, stamp, format));
}

void CheckEnding(const std::filesystem::path& file, const std::vector<std::string>& endings) {
  if (std::ranges::find(endings, base::EndingOf(file)) != endings.end()) return;
  throw base::InputError(fmt::format("{}: unsupported file type; the name must end with {}",
                                     file.string(), base::Join(endings, " or ")));
}

void RefuseOverwriting(const std::filesystem::path& input, const std::filesystem::path& output) {
  std::error_code absent;  // an output usually is
  if (!std::filesystem::equivalent(input, output, absent)) return;
  throw base::InputError(output.string() +
                         ": is an input, which would be overwritten; write to another place");
}

std::pair<int, int> ParseSize(const std::string& text) {
  int width = 0;
  int height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < kMinSide_px ||
      height < kMinSide_px || width > kMaxSide_px || height > kMaxSide_px) {
    throw base::InputError("size '" + text +
                           "' must be WIDTHxHEIGHT in pixels, 16 to 8192 each, e.g. 1280x960");
  }
  return {width, height};
}

void AddFormatOption(CLI::App& command, std::string& format) {
  command.add_option("--format", format, "format of the tables (text)")
      ->check(CLI::IsMember(base::WordList<experiment::TableFormat>()));
  command.add_flag_callback(
      "--json", [&format] { format = "json"; }, "same as --format json");
}

experiment::TableFormat TableFormatFrom(const std::string& word) {
  return base::FromWord<experiment::TableFormat>(word, "--format");
}

CLI::Validator WholeNumber(std::uint64_t min, std::uint64_t max) {
  const auto in_digits = [min, max](std::string& text) -> std::string {
    const auto number = base::NumberFrom<std::uint64_t>(text);
    if (!number || *number < min || *number > max) {
      return fmt::format("'{}' must be a whole number from {} to {}", text, min, max);
    }
    text = std::to_string(*number);  // without leading zeros
    return "";
  };
  return {in_digits, max == UINT64_MAX ? "NONNEGATIVE" : fmt::format("INT in [{} - {}]", min, max)};
}

CLI::Validator NumberBetween(double min, double max) {
  const auto check = [min, max](const std::string& text) -> std::string {
    const auto number = base::NumberFrom<double>(text);
    if (number && *number >= min && *number <= max) return "";
    return fmt::format("'{}' must be a number from {:g} to {:g}", text, min, max);
  };
  return {check, fmt::format("FLOAT in [{:g} - {:g}]", min, max)};
}

void AddJobsOption(CLI::App& command, const char* cases, int& jobs) {
  jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  command
      .add_option("--jobs", jobs,
                  fmt::format("number of {} run in parallel (default: number of cores)", cases))
      ->transform(WholeNumber(1, 1024));
}

void StepLine::Begin(const std::string& step) {
  if (!isatty(STDERR_FILENO)) return;
  fmt::print(stderr, "\r{}: {} \033[K", title_, step);
  std::fflush(stderr);
  shown_ = true;
}

void StepLine::End() {
  if (!std::exchange(shown_, false)) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
}

bool ProgressBar::IsDue(int done) {
  const double now_s = watch_.Seconds();
  const int tenth = 10 * done / total_;
  if (now_s - shown_s_ < quiet_s_ || tenth == shown_tenth_) return false;
  shown_s_ = now_s;
  shown_tenth_ = tenth;
  return true;
}

void ProgressBar::operator()(int done_now, int, const experiment::Record& last) {
  ++outcomes_[last.result.outcome];
  (*this)(done_now);
}

void ProgressBar::operator()(int done_now) {
  const int done = before_ + done_now;
  const bool on_terminal = isatty(STDERR_FILENO) == 1;
  if (!on_terminal && !IsDue(done)) return;
  const double rate_hz = done_now / watch_.Seconds();
  std::string counts;
  for (const auto& [outcome, count] : outcomes_) {
    counts += fmt::format(", {} {}", count, outcome);
    // The share of the cases that this part of the run has done.
    if (outcome == success_) counts += fmt::format(" ({:.0f} %)", 100.0 * count / done_now);
  }
  const std::string text = fmt::format("{}/{}{}, {:.3g} per second, {:.0f} s left", done, total_,
                                       counts, rate_hz, (total_ - done) / rate_hz);
  if (on_terminal) {
    const int filled = kWidth * done / total_;
    fmt::print(stderr, "\r[{:#<{}}{:.<{}}] {} \033[K", "", filled, "", kWidth - filled, text);
  } else {
    fmt::print(stderr, "progress: {}", text);
  }
  if (done == total_ || !on_terminal) fmt::print(stderr, "\n");
  std::fflush(stderr);
}

}  // namespace rangegrasp::cli
