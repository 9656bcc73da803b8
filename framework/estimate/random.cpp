#include "framework/estimate/random.h"

#include <array>
#include <bit>
#include <cmath>

namespace ilss {
namespace {

// Of additions, multiplications and divisions alone, so that they are the same everywhere; good to
// a few units in the last place.

constexpr double ln2 = 0.69314718055994530942;

constexpr double square_root(double x) {
  double root = x > 1 ? x : 1;
  for (int step = 0; step < 60; ++step) root = (root + x / root) / 2;
  return root;
}

/// For normal x > 0.
constexpr double natural_logarithm(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const auto exponent = static_cast<double>(static_cast<int>(bits >> 52) - 1023);
  const auto mantissa =
      std::bit_cast<double>((bits & 0x000fffffffffffffu) | 0x3ff0000000000000u);  // in [1, 2)
  // ln m = 2 artanh((m - 1) / (m + 1))
  const double ratio = (mantissa - 1) / (mantissa + 1);
  double sum = 0;
  for (int odd = 33; odd > 0; odd -= 2) sum = 1.0 / odd + ratio * ratio * sum;
  return exponent * ln2 + 2 * ratio * sum;
}

/// For x from -100 to 0.
constexpr double exponential(double x) {
  double result = 1;
  for (; x < -ln2; x += ln2) result /= 2;
  double sum = 1;
  for (int n = 18; n > 0; --n) sum = 1 + x / n * sum;
  return result * sum;
}

/// The normal density over its value at 0.
constexpr double density(double x) { return exponential(-x * x / 2); }

/// Layers of equal area under the density for x > 0, one on the other: layer i reaches to edge[i]
/// and lies between the heights density(edge[i]) and density(edge[i + 1]). The lowest takes in the
/// tail beyond `tail`, and edge[0] is how wide it would be as a rectangle.
struct Ziggurat {
  static constexpr std::size_t layers = 256;
  static constexpr double tail = 3.6541528853610088;
  static constexpr double area = 0.0049286732339746553;
  std::array<double, layers + 1> edge{};
  std::array<double, layers + 1> height{};

  constexpr Ziggurat() {
    edge[0] = area / density(tail);
    edge[1] = tail;
    height[1] = density(tail);
    for (std::size_t i = 2; i < layers; ++i) {
      height[i] = height[i - 1] + area / edge[i - 1];
      edge[i] = square_root(-2 * natural_logarithm(height[i]));
    }
    edge[layers] = 0;
    height[layers] = 1;
  }
};
constexpr Ziggurat ziggurat;

/// Beyond the ziggurat's edge: uniform up to where 5e-18 of all are left, accepted by the density.
double draw_tail(RandomBits& random) {
  constexpr double reach = 5;
  while (true) {
    const double x = Ziggurat::tail + reach * draw_unit(random);
    if (draw_unit(random) * ziggurat.height[1] < density(x)) return x;
  }
}

}  // namespace

double draw_normal(RandomBits& random) {
  while (true) {
    const std::uint64_t bits = random();
    const std::size_t layer = bits & 255;
    const double place = static_cast<double>(static_cast<std::int64_t>(bits) >> 10) * 0x1p-53;
    const double x = place * ziggurat.edge[layer];
    if (std::abs(x) < ziggurat.edge[layer + 1]) return x;
    if (layer == 0) return std::copysign(draw_tail(random), x);
    const double low = ziggurat.height[layer];
    const double high = ziggurat.height[layer + 1];
    if (low + (high - low) * draw_unit(random) < density(x)) return x;
  }
}

}  // namespace ilss
