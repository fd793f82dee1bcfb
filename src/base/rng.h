#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace rangegrasp::base {

/// The seed of a child stream: a hash of the parent's seed and a name ("scan", "perceive", an
/// object, ...). It is the same on every machine and for any order of execution.
std::uint64_t DeriveSeed(std::uint64_t seed, std::string_view name);
/// The same for a numbered child (a trial's index, an attempt).
std::uint64_t DeriveSeed(std::uint64_t seed, std::uint64_t index);

/// A counter-based random stream: draw k is Philox4x32-10 (Salmon et al. 2011, "Parallel random
/// numbers: as easy as 1, 2, 3") of (seed, k). Distributions are implemented here, since those of
/// the standard library differ between libraries.
class Rng {
 public:
  explicit Rng(std::uint64_t seed) : seed_(seed) {}

  /// 64 uniform bits.
  std::uint64_t Next();
  /// Uniform in [0, 1).
  double Uniform();
  /// Uniform in [low, high).
  double Uniform(double low, double high);
  /// Normal with mean 0 and standard deviation 1 (Box-Muller, one value per call).
  double Normal();
  /// Uniform over 0 .. size - 1; size >= 1. Unbiased (Lemire 2019).
  std::size_t Index(std::size_t size);

 private:
  std::uint64_t seed_;
  std::uint64_t counter_ = 0;
};

}  // namespace rangegrasp::base
