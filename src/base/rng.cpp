#include "base/rng.h"

#include <array>
#include <cmath>

#include "base/units.h"

namespace rangegrasp::base {
namespace {

__extension__ using Uint128 = unsigned __int128;

// splitmix64's finaliser: a bijection of 64 bits with good avalanche.
std::uint64_t Mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

std::array<std::uint32_t, 4> Philox4x32(std::array<std::uint32_t, 4> c, std::uint32_t k0,
                                        std::uint32_t k1) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = 0xD2511F53ull * c[0];
    const std::uint64_t p1 = 0xCD9E8D57ull * c[2];
    c = {static_cast<std::uint32_t>(p1 >> 32) ^ c[1] ^ k0, static_cast<std::uint32_t>(p1),
         static_cast<std::uint32_t>(p0 >> 32) ^ c[3] ^ k1, static_cast<std::uint32_t>(p0)};
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
  return c;
}

}  // namespace

std::uint64_t DeriveSeed(std::uint64_t seed, std::string_view name) {
  std::uint64_t hash = Mix(seed);
  for (const char c : name) hash = Mix(hash ^ static_cast<unsigned char>(c));
  return Mix(hash ^ name.size());
}

std::uint64_t DeriveSeed(std::uint64_t seed, std::uint64_t index) {
  return Mix(Mix(seed) ^ Mix(~index));
}

std::uint64_t Rng::Next() {
  const std::uint64_t n = counter_++;
  const auto out =
      Philox4x32({static_cast<std::uint32_t>(n), static_cast<std::uint32_t>(n >> 32), 0, 0},
                 static_cast<std::uint32_t>(seed_), static_cast<std::uint32_t>(seed_ >> 32));
  return (std::uint64_t{out[1]} << 32) | out[0];
}

double Rng::Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }

double Rng::Uniform(double low, double high) { return low + (high - low) * Uniform(); }

double Rng::Normal() {
  const double u = 1.0 - Uniform();  // in (0, 1], so that the logarithm is finite
  const double v = Uniform();
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * kPi * v);
}

std::size_t Rng::Index(std::size_t size) {
  const std::uint64_t bound = size;
  const std::uint64_t threshold = (0 - bound) % bound;
  while (true) {
    const Uint128 product = static_cast<Uint128>(Next()) * bound;
    if (static_cast<std::uint64_t>(product) >= threshold) {
      return static_cast<std::size_t>(product >> 64);
    }
  }
}

}  // namespace rangegrasp::base
