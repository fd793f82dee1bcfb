#include "experiment/statistics.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace rangegrasp::experiment {
namespace {

double LogChoose(int n, int k) {
  return std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0);
}

// Of a rate p of n trials; n need not be whole.
std::pair<double, double> Wilson(double p, double n) {
  constexpr double z = 1.959963984540054;  // 97.5 % point of the normal
  const double denominator = 1.0 + z * z / n;
  const double center = (p + z * z / (2.0 * n)) / denominator;
  const double half = z * std::sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n)) / denominator;
  return {std::max(0.0, center - half), std::min(1.0, center + half)};
}

}  // namespace

std::pair<double, double> WilsonInterval(int k, int n) {
  if (n < 1 || k < 0 || k > n) throw std::invalid_argument("Wilson: needs 0 <= k <= n, n >= 1");
  const auto [low, high] = Wilson(static_cast<double>(k) / n, n);
  // At k = 0 and k = n the bound is exactly 0 and 1; rounding must not leave it short.
  return {k == 0 ? 0.0 : low, k == n ? 1.0 : high};
}

std::pair<double, double> ClusteredInterval(const std::vector<Cluster>& clusters) {
  int k = 0;
  int n = 0;
  int filled = 0;
  for (const Cluster& cluster : clusters) {
    if (cluster.k < 0 || cluster.k > cluster.n) {
      throw std::invalid_argument("ClusteredInterval: needs 0 <= k <= n");
    }
    k += cluster.k;
    n += cluster.n;
    filled += cluster.n > 0 ? 1 : 0;
  }
  if (n < 1) throw std::invalid_argument("ClusteredInterval: needs a trial");
  const double p = static_cast<double>(k) / n;
  double squares = 0.0;
  for (const Cluster& cluster : clusters) squares += std::pow(cluster.k - p * cluster.n, 2);
  const double variance = filled > 1 ? squares * filled / (filled - 1.0) / (1.0 * n * n) : 0.0;
  const double effective = variance > 0.0 ? p * (1.0 - p) / variance : 0.0;
  const auto [low, high] =
      Wilson(p, std::clamp(effective, static_cast<double>(filled), static_cast<double>(n)));
  return {k == 0 ? 0.0 : low, k == n ? 1.0 : high};
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

Mean MeanOf(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto n = static_cast<double>(values.size());
  double sum = 0.0;
  for (const double value : values) sum += value;
  Mean result{sum / n, std::nullopt, values.size()};
  if (values.size() < 2) return result;
  double squares = 0.0;
  for (const double value : values) squares += (value - *result.mean) * (value - *result.mean);
  result.standard_error = std::sqrt(squares / (n - 1.0) / n);
  return result;
}

}  // namespace rangegrasp::experiment
