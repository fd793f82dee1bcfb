#include "experiment/statistics.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

#include "base/statistics.h"

namespace rangegrasp::experiment {
namespace {

double LogChoose(int n, int k) {
  return std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0);
}

// The interval of a rate with the variance of n trials, which need not be whole.
std::pair<double, double> Wilson(double p, double n) {
  constexpr double z = 1.959963984540054;  // 97.5 % quantile of the normal distribution
  const double denominator = 1.0 + z * z / n;
  const double center = (p + z * z / (2.0 * n)) / denominator;
  const double half = z * std::sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n)) / denominator;
  // If no trial or every trial succeeds, the bound is exactly 0 or 1 despite rounding.
  return {p == 0.0 ? 0.0 : std::max(0.0, center - half),
          p == 1.0 ? 1.0 : std::min(1.0, center + half)};
}

double RateOf(const Count& count) { return static_cast<double>(count.k) / count.n; }

Count SumOf(const std::vector<Count>& clusters) {
  Count sum;
  for (const Count& cluster : clusters) {
    if (cluster.k < 0 || cluster.k > cluster.n) {
      throw std::invalid_argument("ClusteredInterval: needs 0 <= k <= n");
    }
    sum.k += cluster.k;
    sum.n += cluster.n;
  }
  if (sum.n < 1) throw std::invalid_argument("ClusteredInterval: needs a trial");
  return sum;
}

// Positions of the cases that are in both runs.
Pairs PairsOf(const std::vector<Record>& first, const std::vector<Record>& second) {
  std::map<std::pair<std::string, std::uint64_t>, std::size_t> by_case;
  for (std::size_t i = 0; i < first.size(); ++i) {
    by_case[{first[i].which.id, first[i].which.seed}] = i;
  }
  Pairs pairs;
  for (std::size_t i = 0; i < second.size(); ++i) {
    const auto found = by_case.find({second[i].which.id, second[i].which.seed});
    if (found != by_case.end()) pairs.emplace_back(found->second, i);
  }
  return pairs;
}

}  // namespace

std::pair<double, double> WilsonInterval(int k, int n) {
  if (n < 1 || k < 0 || k > n) throw std::invalid_argument("Wilson: needs 0 <= k <= n, n >= 1");
  return Wilson(RateOf({k, n}), n);
}

std::optional<std::pair<double, double>> MeanRateInterval(const std::vector<Count>& counts) {
  double sum = 0.0, inverse = 0.0;
  int rates = 0;
  for (const Count& count : counts) {
    if (count.k < 0 || count.k > count.n) {
      throw std::invalid_argument("MeanRateInterval: needs 0 <= k <= n");
    }
    if (count.n == 0) continue;
    sum += RateOf(count);
    inverse += 1.0 / count.n;
    ++rates;
  }
  if (rates == 0) return std::nullopt;
  return Wilson(sum / rates, rates * rates / inverse);
}

double EffectiveTrials(const std::vector<Count>& clusters) {
  const auto [k, n] = SumOf(clusters);
  const double p = static_cast<double>(k) / n;
  int filled = 0;
  double squares = 0.0;
  for (const Count& cluster : clusters) {
    filled += cluster.n > 0 ? 1 : 0;
    squares += std::pow(cluster.k - p * cluster.n, 2);
  }
  // One cluster, and all or no successes, say nothing about how much clusters differ.
  if (filled == 1 || k == 0 || k == n) return filled;
  const double variance = squares * filled / (filled - 1.0) / (1.0 * n * n);
  const double effective = variance > 0.0 ? p * (1.0 - p) / variance : n;
  return std::clamp(effective, static_cast<double>(filled), static_cast<double>(n));
}

std::pair<double, double> ClusteredInterval(const std::vector<Count>& clusters) {
  return Wilson(RateOf(SumOf(clusters)), EffectiveTrials(clusters));
}

double McNemarExact(int b, int c) {
  if (b < 0 || c < 0) throw std::invalid_argument("McNemar: counts must not be negative");
  const int n = b + c;
  double tail = 0.0;
  for (int k = 0; k <= std::min(b, c); ++k) tail += std::exp(LogChoose(n, k) - n * std::log(2.0));
  return std::min(1.0, 2.0 * tail);
}

double FisherExactLower(int k1, int n1, int k2, int n2) {
  if (k1 < 0 || k1 > n1 || k2 < 0 || k2 > n2) {
    throw std::invalid_argument("Fisher: needs 0 <= k <= n");
  }
  const int successes = k1 + k2;
  double p = 0.0;
  for (int k = std::max(0, successes - n2); k <= k1; ++k) {
    p += std::exp(LogChoose(n1, k) + LogChoose(n2, successes - k) - LogChoose(n1 + n2, successes));
  }
  return std::min(1.0, p);
}

double FisherExact(int k1, int n1, int k2, int n2) {
  const double lower = FisherExactLower(k1, n1, k2, n2);
  const double upper = FisherExactLower(n1 - k1, n1, n2 - k2, n2);
  return std::min(1.0, 2.0 * std::min(lower, upper));
}

double ScoreTest(double rate, double n, double expected) {
  const auto is_rate = [](double p) { return p >= 0.0 && p <= 1.0; };
  if (!is_rate(rate) || !is_rate(expected) || !(n > 0.0)) {
    throw std::invalid_argument("ScoreTest: needs rates from 0 to 1 and n > 0");
  }
  const double half_a_trial = std::min(0.5, 0.5 / n);
  const double p = std::clamp(expected, half_a_trial, 1.0 - half_a_trial);
  const double z = (rate - expected) / std::sqrt(p * (1.0 - p) / n);
  return std::erfc(std::abs(z) / std::sqrt(2.0));
}

double PoissonRatesExact(int k1, int n1, int k2, int n2) {
  if (k1 < 0 || k2 < 0 || n1 < 1 || n2 < 1) {
    throw std::invalid_argument("PoissonRatesExact: needs counts of 0 and more, in runs");
  }
  if (k1 + k2 == 0) return 1.0;
  const boost::math::binomial first(k1 + k2, static_cast<double>(n1) / (n1 + n2));
  const double lower = boost::math::cdf(first, k1);
  const double upper = k1 == 0 ? 1.0 : boost::math::cdf(boost::math::complement(first, k1 - 1));
  return std::min(1.0, 2.0 * std::min(lower, upper));
}

double StudentTest(const Mean& mean, double expected) {
  if (!mean.mean || !mean.standard_error) {
    throw std::invalid_argument("StudentTest: needs two values");
  }
  const double difference = std::abs(*mean.mean - expected);
  if (*mean.standard_error == 0.0) return difference > 0.0 ? 0.0 : 1.0;
  const boost::math::students_t t(static_cast<double>(mean.count) - 1.0);
  return 2.0 * boost::math::cdf(boost::math::complement(t, difference / *mean.standard_error));
}

Mean MeanOf(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto n = static_cast<double>(values.size());
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  Mean result{sum / n, std::nullopt, values.size()};
  if (values.size() < 2) return result;
  double squares = 0.0;
  for (const double value : values) squares += (value - *result.mean) * (value - *result.mean);
  result.standard_error = std::sqrt(squares / (n - 1.0) / n);
  return result;
}

Comparison Compare(const std::vector<Record>& first, const std::vector<Record>& second,
                   const std::string& success) {
  Comparison comparison;
  for (const auto& [a, b] : PairsOf(first, second)) {
    const std::string& outcome = first[a].result.outcome;
    const bool one = outcome == success;
    const bool two = second[b].result.outcome == success;
    ++comparison.pairs;
    comparison.both += one && two ? 1 : 0;
    comparison.only_first += one && !two ? 1 : 0;
    comparison.only_second += !one && two ? 1 : 0;
    comparison.same_outcome += outcome == second[b].result.outcome ? 1 : 0;
  }
  comparison.p_value = McNemarExact(comparison.only_first, comparison.only_second);
  return comparison;
}

Pairs Differing(const std::vector<Record>& first, const std::vector<Record>& second,
                const std::string& success) {
  Pairs pairs = PairsOf(first, second);
  std::erase_if(pairs, [&](const auto& pair) {
    const bool one = first[pair.first].result.outcome == success;
    return one == (second[pair.second].result.outcome == success);
  });
  return pairs;
}

std::vector<StageTime> StageTimes(const std::vector<Record>& records) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<double>> by_stage;
  for (const Record& record : records) {
    for (const auto& [stage, seconds] : record.result.seconds) {
      if (!by_stage.contains(stage)) order.push_back(stage);
      by_stage[stage].push_back(seconds);
    }
  }
  std::vector<StageTime> times;
  for (const std::string& stage : order) {
    const auto& all = by_stage[stage];
    times.push_back(
        {stage, base::InterpolatedQuantileOf(all, 0.5), base::InterpolatedQuantileOf(all, 0.95)});
  }
  return times;
}

}  // namespace rangegrasp::experiment
