#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiment/record.h"

namespace rangegrasp::experiment {

/// k of n: successes of trials, events in runs.
struct Count {
  int k = 0;
  int n = 0;
};

/// Wilson's score interval of a rate k / n at 95 % (Wilson 1927): {low, high} within [0, 1].
/// @throws std::invalid_argument unless 0 <= k <= n and n >= 1.
std::pair<double, double> WilsonInterval(int k, int n);

/// Wilson's 95 % interval of the mean of R independent rates, with R^2 / sum(1 / n) as the number
/// of trials, as for rates with equal weights (Kish 1965, Survey Sampling, design effect of
/// weights). It is slightly too wide if the rates differ. Counts without trials are ignored;
/// nullopt if no count has trials.
/// @throws std::invalid_argument unless 0 <= k <= n for each.
std::optional<std::pair<double, double>> MeanRateInterval(const std::vector<Count>& counts);

/// The number of independent trials whose rate has the same variance as the rate of clustered
/// trials, which depend on each other within a cluster (Korn and Graubard 1998: n over the design
/// effect of a ratio of cluster totals). It is between the numbers of clusters and of trials: the
/// former if all or no trials succeed, which says nothing about the clusters; the latter if all
/// clusters have the same rate in between.
/// @throws std::invalid_argument unless 0 <= k <= n for each and there is a trial.
double EffectiveTrials(const std::vector<Count>& clusters);
/// Wilson's 95 % interval of the rate of all trials, with EffectiveTrials trials.
/// @throws std::invalid_argument as EffectiveTrials.
std::pair<double, double> ClusteredInterval(const std::vector<Count>& clusters);

/// Exact McNemar test: the two-sided p-value of b against c discordant pairs (binomial, p = 1/2).
/// @throws std::invalid_argument for a negative count.
double McNemarExact(int b, int c);

/// Fisher's exact test: the one-sided p-value that k1 of n1 is drawn from a lower rate than k2 of
/// n2 (the chance of at most k1 successes in the first sample given the margins).
/// @throws std::invalid_argument unless 0 <= k <= n for both.
double FisherExactLower(int k1, int n1, int k2, int n2);
/// Fisher's exact test, two-sided: twice the smaller one-sided p-value, at most 1.
double FisherExact(int k1, int n1, int k2, int n2);

/// The two-sided p-value that a rate of n trials (not necessarily a whole number) is drawn from the
/// rate `expected`. Its statistic z = (rate - expected) / sqrt(expected (1 - expected) / n) is
/// normal. An expected rate closer to 0 or 1 than half a trial gets the variance at that distance.
/// @throws std::invalid_argument unless both rates are within [0, 1] and n > 0.
double ScoreTest(double rate, double n, double expected);

/// The two-sided p-value that k1 events in n1 runs and k2 in n2 come at the same rate: given their
/// sum, k1 is binomial with n1 / (n1 + n2) (Przyborowski and Wilenski 1940). Twice the smaller
/// tail.
/// @throws std::invalid_argument for a negative count, or without runs.
double PoissonRatesExact(int k1, int n1, int k2, int n2);

struct Mean {
  std::optional<double> mean;            ///< absent without a value
  std::optional<double> standard_error;  ///< s / sqrt(n); absent for fewer than two values
  std::size_t count = 0;
};
Mean MeanOf(const std::vector<double>& values);

/// The two-sided p-value that independent normal values with this mean have the mean `expected`
/// (Student's t with count - 1 degrees of freedom). Values without variance give 0 or 1.
/// @throws std::invalid_argument if the mean has no standard error.
double StudentTest(const Mean& mean, double expected);

/// Pairwise comparison of the cases with the same id and seed in two runs.
struct Comparison {
  int pairs = 0;
  int both = 0;  ///< succeeded in both
  int only_first = 0;
  int only_second = 0;
  int same_outcome = 0;
  double p_value = 1.0;  ///< McNemar's exact test of only_first against only_second
};
/// @param success  the outcome that counts as success
Comparison Compare(const std::vector<Record>& first, const std::vector<Record>& second,
                   const std::string& success);

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
/// Positions (in first, in second) of the pairs with exactly one success, in the order of second.
Pairs Differing(const std::vector<Record>& first, const std::vector<Record>& second,
                const std::string& success);

/// Median and 95 % quantile of the time of a stage, over all records that have it.
struct StageTime {
  std::string stage;
  double median_s = 0.0;
  double p95_s = 0.0;
};
/// In the order in which stages first occur.
std::vector<StageTime> StageTimes(const std::vector<Record>& records);

}  // namespace rangegrasp::experiment
