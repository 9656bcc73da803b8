// Seeded random numbers whose streams depend on what they are for, never on the order of
// evaluation, and which are the same wherever the program is built. The distributions of <random>
// are not: their algorithms are left open by the standard.
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

namespace ilss {

/// Mixes 64 bits (the finaliser of splitmix64, Steele, Lea and Flood 2014).
constexpr std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// A seed for one purpose out of a seed for many.
constexpr std::uint64_t derive_seed(std::uint64_t seed, std::uint64_t purpose) {
  return mix(seed ^ mix(purpose));
}
constexpr std::uint64_t derive_seed(std::uint64_t seed, std::string_view purpose) {
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a
  for (const char c : purpose) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return derive_seed(seed, hash);
}

/// A uniform random bit generator (splitmix64) that costs nothing to seed.
class RandomBits {
 public:
  using result_type = std::uint64_t;
  explicit constexpr RandomBits(std::uint64_t seed) : state_(seed) {}
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }
  constexpr result_type operator()() {
    const std::uint64_t result = mix(state_);
    state_ += 0x9e3779b97f4a7c15u;
    return result;
  }

 private:
  std::uint64_t state_;
};

/// Uniform in [0, 1): 53 bits.
inline double draw_unit(RandomBits& random) {
  return static_cast<double>(static_cast<std::int64_t>(random() >> 11)) * 0x1p-53;
}

/// Uniform in [low, high).
inline double draw_uniform(RandomBits& random, double low, double high) {
  return low + (high - low) * draw_unit(random);
}

/// A whole number from 0 to `count` - 1, each exactly as likely. @pre count > 0
constexpr std::uint64_t draw_index(RandomBits& random, std::uint64_t count) {
  // The largest multiple of `count`; what lies above it would favour small numbers.
  const std::uint64_t whole = RandomBits::max() - RandomBits::max() % count;
  std::uint64_t bits = random();
  while (bits >= whole) bits = random();
  return bits % count;
}

/// Standard normal, exactly but for rounding: the ziggurat of 256 layers (Marsaglia & Tsang 2000,
/// with layer and place from different bits, Doornik 2005); beyond 3.65, 1 in 3,800 draws, by
/// rejection. No result goes through a function of the mathematical library, whose last bits differ
/// from one to another: it is a product with a table's entry, and comparisons that choose. Costs
/// about 4 ns.
double draw_normal(RandomBits& random);

}  // namespace ilss
