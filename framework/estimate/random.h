// Seeded random numbers whose streams depend on what they are for, never on the order of
// evaluation.
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

/// A uniform random bit generator (splitmix64) that costs nothing to seed, for use with <random>.
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

}  // namespace ilss
