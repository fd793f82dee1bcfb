#pragma once

#include <utility>

namespace rangegrasp::experiment {

/// Wilson's score interval of a rate k / n at 95 % (Wilson 1927): {low, high} within [0, 1].
/// @throws std::invalid_argument unless 0 <= k <= n and n >= 1.
std::pair<double, double> WilsonInterval(int k, int n);

/// Exact McNemar test: the two-sided p-value of b against c discordant pairs (binomial with p =
/// 1/2).
/// @throws std::invalid_argument for a negative count.
double McNemarExact(int b, int c);

/// Fisher's exact test: the one-sided p-value that k1 of n1 is drawn from a lower rate than k2 of
/// n2 (the chance of at most k1 successes in the first sample given the margins).
/// @throws std::invalid_argument unless 0 <= k <= n for both.
double FisherExactLower(int k1, int n1, int k2, int n2);

}  // namespace rangegrasp::experiment
