#include "experiment/statistics.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace rangegrasp::experiment {
namespace {

double LogChoose(int n, int k) {
  return std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0);
}

}  // namespace

std::pair<double, double> WilsonInterval(int k, int n) {
  if (n < 1 || k < 0 || k > n) throw std::invalid_argument("Wilson: needs 0 <= k <= n, n >= 1");
  constexpr double z = 1.959963984540054;  // 97.5 % point of the normal
  const double p = static_cast<double>(k) / n;
  const double denominator = 1.0 + z * z / n;
  const double center = (p + z * z / (2.0 * n)) / denominator;
  const double half = z * std::sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n)) / denominator;
  // At k = 0 and k = n the bound is exactly 0 and 1; rounding must not leave it short.
  return {k == 0 ? 0.0 : std::max(0.0, center - half), k == n ? 1.0 : std::min(1.0, center + half)};
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

}  // namespace rangegrasp::experiment
