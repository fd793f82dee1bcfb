#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "experiment/record.h"
#include "experiment/report.h"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace rangegrasp::cli {

/// Writes text to stdout, or to a file if one is named.
/// @throws base::RunError naming the target if it cannot be written completely.
void WriteResult(const std::string& text, const std::filesystem::path& file = {});

/// Writes a report's tables to stdout.
void WriteTables(const experiment::Report& report, const experiment::Stamp& stamp,
                 experiment::TableFormat format);

/// Checks the extension of an output file before anything is computed.
/// @param endings  extensions that the command can write, e.g. {".pcd", ".ply"}
/// @throws base::InputError naming the file and the endings.
void CheckEnding(const std::filesystem::path& file, const std::vector<std::string>& endings);

/// Refuses to write over an input, before anything is computed.
/// @throws base::InputError naming the file.
void RefuseOverwriting(const std::filesystem::path& input, const std::filesystem::path& output);

/// "1280x960" -> {1280, 960}. @throws base::InputError.
std::pair<int, int> ParseSize(const std::string& text);

/// Adds `--format text|markdown|csv|json`, and `--json` as a short form of the last; `format` must
/// live as long as the command.
void AddFormatOption(CLI::App& command, std::string& format);
/// The format for the value of that option.
experiment::TableFormat TableFormatFrom(const std::string& word);
/// For Option::transform: a whole number from min to max in decimal digits. CLI11 itself would read
/// 010 as 8 and 0x10 as 16, and clamp a number that does not fit.
CLI::Validator WholeNumber(std::uint64_t min = 0, std::uint64_t max = UINT64_MAX);
/// For Option::check: a number from min to max; CLI::Range lets nan pass.
CLI::Validator NumberBetween(double min, double max);
/// Adds `--jobs`, the number of `cases` run in parallel, with the number of cores as default.
void AddJobsOption(CLI::App& command, const char* cases, int& jobs);

/// A line with the current step of a long command, if stderr is a terminal.
class StepLine {
 public:
  /// @param title  "big.off"
  explicit StepLine(std::string title) : title_(std::move(title)) {}
  ~StepLine() { End(); }
  StepLine(const StepLine&) = delete;
  StepLine& operator=(const StepLine&) = delete;

  void Begin(const std::string& step);
  /// Removes the line; call it before anything else is written.
  void End();

 private:
  std::string title_;
  bool shown_ = false;
};

/// A run's progress: a line that is updated on a terminal. If stderr is a file or a pipe, a line
/// after `quiet_s`, which shows the time left, and then one for each tenth of the cases.
class ProgressBar {
 public:
  /// @param before   cases done by an earlier part of the run
  /// @param success  the outcome whose share is shown; empty: none
  /// @param quiet_s  minimum time between two lines in a file
  ProgressBar(int before, int total, std::string success = "", double quiet_s = 30.0)
      : before_(before), total_(total), quiet_s_(quiet_s), success_(std::move(success)) {}
  void operator()(int done_now, int, const experiment::Record& last);
  /// For steps that have no outcome.
  /// @param done_now  at most total - before
  void operator()(int done_now);

 private:
  // Whether a file gets a line now.
  bool IsDue(int done);

  int before_, total_;
  double quiet_s_;
  std::string success_;
  base::Stopwatch watch_;
  std::map<std::string, int> outcomes_;
  double shown_s_ = 0.0;  // time of the last line in a file
  int shown_tenth_ = -1;  // tenths of the cases in that line
};

}  // namespace rangegrasp::cli
