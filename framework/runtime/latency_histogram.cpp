#include "framework/runtime/latency_histogram.h"

#include <cmath>
#include <numeric>

namespace ilss {

void LatencyHistogram::merge(const LatencyHistogram& other) noexcept {
  for (std::size_t i = 0; i < bucket_count; ++i) buckets_[i] += other.buckets_[i];
  sum_ += other.sum_;
  max_ = std::max(max_, other.max_);
}

std::uint64_t LatencyHistogram::count() const {
  return std::accumulate(buckets_.begin(), buckets_.end(), std::uint64_t{0});
}

double LatencyHistogram::mean() const {
  const std::uint64_t recorded = count();
  return recorded == 0 ? 0 : static_cast<double>(sum_) / static_cast<double>(recorded);
}

std::uint64_t LatencyHistogram::upper_end(std::size_t bucket) {
  constexpr std::size_t octave = std::size_t{1} << precision_bits;
  if (bucket < 2 * octave) return bucket;
  const std::size_t shift = bucket / octave - 1;
  return ((octave + bucket % octave + 1) << shift) - 1;
}

std::uint64_t LatencyHistogram::quantile(double probability) const {
  const double rank = std::ceil(probability * static_cast<double>(count()));
  std::uint64_t below = 0;
  for (std::size_t i = 0; i + 1 < bucket_count; ++i) {
    below += buckets_[i];
    if (buckets_[i] != 0 && static_cast<double>(below) >= rank) return std::min(upper_end(i), max_);
  }
  return max_;
}

LatencySummary LatencyHistogram::summary() const {
  return {count(), mean(), quantile(0.5), quantile(0.9), quantile(0.99), quantile(0.999), max_};
}

}  // namespace ilss
