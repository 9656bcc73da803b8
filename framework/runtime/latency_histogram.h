// How long something took, over many ticks: a histogram of fixed size and fixed relative precision.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace ilss {

/// The figures of a latency histogram, all in nanoseconds.
struct LatencySummary {
  std::uint64_t count = 0;
  double mean = 0;
  std::uint64_t p50 = 0;
  std::uint64_t p90 = 0;
  std::uint64_t p99 = 0;
  std::uint64_t p999 = 0;
  std::uint64_t max = 0;
};

/// Counts durations in log-linear buckets, as HdrHistogram does: 64 equal buckets an octave, so
/// that a bucket is at most 1/64 (1.6 %) of its values wide; below 128 ns each nanosecond has its
/// own. Recording takes a few nanoseconds and no memory. Durations of 2^42 ns (73 minutes) and more
/// share the last bucket; `max` and `mean` are exact for them too. One thread at a time; threads
/// that measure side by side keep a histogram each and `merge` them.
class LatencyHistogram {
 public:
  void record(std::uint64_t nanoseconds) noexcept {
    ++buckets_[bucket_of(nanoseconds)];
    sum_ += nanoseconds;
    max_ = std::max(max_, nanoseconds);
  }

  /// Adds all that `other` has recorded.
  void merge(const LatencyHistogram& other) noexcept;
  /// Forgets everything.
  void reset() noexcept { *this = LatencyHistogram(); }

  /// How many were recorded: the sum of all buckets, so that recording need not count.
  std::uint64_t count() const;
  std::uint64_t max() const { return max_; }
  /// Mean (ns); 0 where nothing was recorded.
  double mean() const;
  /// What the share `probability` (0 to 1) of all recorded durations did not exceed: the upper end
  /// of the bucket it lies in, so never too good, and at most 1.6 % too bad; 0 where nothing was
  /// recorded.
  std::uint64_t quantile(double probability) const;
  LatencySummary summary() const;

 private:
  static constexpr unsigned precision_bits = 6;  // 64 buckets an octave
  static constexpr unsigned range_bits = 42;
  static constexpr std::uint64_t largest = (std::uint64_t{1} << range_bits) - 1;

  /// Values below 2^(precision_bits + 1) lie in the bucket of their own number; above, an octave
  /// takes 2^precision_bits buckets of equal width.
  static constexpr std::size_t bucket_of(std::uint64_t value) noexcept {
    const std::uint64_t clamped = std::min(value, largest);
    const auto width = static_cast<unsigned>(std::bit_width(clamped | (1U << precision_bits)));
    const unsigned shift = width - precision_bits - 1;
    return (std::size_t{shift} << precision_bits) + static_cast<std::size_t>(clamped >> shift);
  }
  static std::uint64_t upper_end(std::size_t bucket);

  static constexpr std::size_t bucket_count = std::size_t{range_bits - precision_bits + 1}
                                              << precision_bits;

  std::array<std::uint64_t, bucket_count> buckets_{};
  std::uint64_t sum_ = 0;
  std::uint64_t max_ = 0;
};

}  // namespace ilss
