#include "experiment/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace rangegrasp::experiment {
namespace {

/// All verdicts of a table together are wrong by chance this often at most.
constexpr double kSignificance = 0.05;

std::string CountsOf(const Share& own, const Share& published, const char* word) {
  return fmt::format("{} {} {}, published {} {} {}", own.k, word, own.n, published.k, word,
                     published.n);
}

/// What a kind of evidence has to say of a figure that is there.
struct Test {
  std::optional<double> p;
  std::string counts;
  const char* words;
};

Test TestOf(const TrialsEvidence& e, const PublishedFigure&) {
  return {FisherExact(e.own.k, e.own.n, e.published.k, e.published.n),
          CountsOf(e.own, e.published, "of"),
          "counts of both: Fisher's exact test, two-sided (twice the smaller tail)"};
}

Test TestOf(const ClustersEvidence& e, const PublishedFigure& figure) {
  const double trials = EffectiveTrials(e.own);
  int filled = 0;
  int n = 0;
  for (const Cluster& cluster : e.own) {
    filled += cluster.n > 0 ? 1 : 0;
    n += cluster.n;
  }
  return {ScoreTest(*figure.own / 100.0, trials, figure.published / 100.0),
          fmt::format("{} in {} groups, as {:.0f} independent ones", n, filled, trials),
          "a published rate whose counts are not known, taken as exact: score test, two-sided, "
          "with as many independent trials as vary like the groups (seams) do"};
}

Test TestOf(const EventsEvidence& e, const PublishedFigure&) {
  return {PoissonRatesExact(e.own.k, e.own.n, e.published.k, e.published.n),
          CountsOf(e.own, e.published, "in"),
          "events, of which a run may have several: exact test of two Poisson rates, two-sided"};
}

Test TestOf(const MeanEvidence& e, const PublishedFigure& figure) {
  const char* words =
      "a published mean of unknown scatter, taken as exact: Student's test of the own mean, "
      "two-sided";
  if (!e.own.standard_error) return {std::nullopt, "one measurement", words};
  return {
      StudentTest(e.own, figure.published),
      fmt::format("{} measured, +- {:.{}f}", e.own.count, *e.own.standard_error, figure.digits + 1),
      words};
}

Test TestOf(const TimesEvidence& e, const PublishedFigure& figure) {
  return {
      std::nullopt,
      fmt::format("{} timed, {:.3g} times as fast", e.measured, figure.published / *figure.own),
      "times of two computers: no test; better if more than 10 times as fast, which is more "
      "than a computer of today is faster than the published 2 GHz Core 2 Duo, worse if slower"};
}

Verdict VerdictOfTimes(double own, double published) {
  if (own * kComputersFactor < published) return Verdict::kBetter;
  return own > published ? Verdict::kWorse : Verdict::kSame;
}

Verdict VerdictOf(const PublishedFigure& figure, const std::optional<double>& p, double threshold) {
  if (std::holds_alternative<TimesEvidence>(figure.evidence)) {
    return VerdictOfTimes(*figure.own, figure.published);
  }
  if (!p || *p >= threshold) return Verdict::kSame;
  return (*figure.own < figure.published) == figure.lower_is_better ? Verdict::kBetter
                                                                    : Verdict::kWorse;
}

}  // namespace

JudgedTable Judge(const std::vector<PublishedFigure>& figures) {
  JudgedTable table;
  int tests = 0;
  for (const PublishedFigure& figure : figures) {
    Judged row{figure, "", std::nullopt, Verdict::kNoFigure};
    if (figure.own) {
      const Test test =
          std::visit([&](const auto& e) { return TestOf(e, figure); }, figure.evidence);
      row.p = test.p;
      row.counts = test.counts;
      if (std::find(table.tests.begin(), table.tests.end(), test.words) == table.tests.end()) {
        table.tests.emplace_back(test.words);
      }
    }
    tests += row.p ? 1 : 0;
    table.rows.push_back(std::move(row));
  }
  if (tests > 0) table.threshold = kSignificance / tests;
  for (Judged& row : table.rows) {
    if (row.figure.own) row.verdict = VerdictOf(row.figure, row.p, table.threshold);
  }
  return table;
}

}  // namespace rangegrasp::experiment
