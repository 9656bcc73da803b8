// Outputs of any payload, made up of random numbers, and what it means that two are the same.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <random>

#include "framework/module/output.h"

namespace ilss::test {

/// Random outputs of payloads; sources are of the given number of owners.
class RandomOutputs {
 public:
  RandomOutputs(std::uint64_t seed, std::uint32_t owners) : bits_(seed), owners_(owners) {}

  std::size_t below(std::size_t limit) { return static_cast<std::size_t>(bits_() % limit); }

  /// Any finite number, of any size; -0 now and then.
  double number() {
    for (;;) {
      const auto value = below(20) == 0 ? -0.0 : std::bit_cast<double>(bits_());
      if (std::isfinite(value)) return value;
    }
  }

  Output of(const PayloadDescriptor& payload) {
    Output output;
    std::vector<Source> sources;
    for (std::size_t n = below(12); n > 0; --n)
      sources.push_back({static_cast<std::uint32_t>(below(owners_)),
                         static_cast<std::uint32_t>(below(1000)),
                         below(3) == 0 ? persistent_tick : static_cast<std::int64_t>(below(9))});
    output.estimate = estimate(payload, sources, "frame");
    output.acquired = {Time(Duration(static_cast<std::int64_t>(bits_()))),
                       Time(Duration(static_cast<std::int64_t>(bits_())))};
    if (payload.samples) fill(*payload.samples, output.samples);
    if (!payload.element.empty() && !payload.elements.empty())
      for (std::size_t n = below(6); n > 0; --n)
        output.elements.push_back(estimate(*payload.elements[below(payload.elements.size())],
                                           sources, below(5) == 0 ? "other" : "frame"));
    return output;
  }

 private:
  Estimate estimate(const PayloadDescriptor& payload, const std::vector<Source>& sources,
                    const std::string& frame) {
    Estimate estimate(payload, frame);
    for (double& value : estimate.value) value = number();
    for (std::size_t i = 0; i < estimate.labels.size(); ++i)
      estimate.labels[i] = static_cast<int>(below(payload.labels[i].values.size()));
    estimate.correlation_unknown = below(2) == 0;
    std::vector<double> column(payload.dimension());
    const bool takes_all = below(3) == 0;
    for (const Source& source : sources) {
      if (payload.dimension() == 0 || !(takes_all || below(2) == 0)) continue;
      for (double& sensitivity : column) sensitivity = number();
      const auto known = estimate.lineage.sources();
      if (std::find(known.begin(), known.end(), source) == known.end())
        estimate.lineage.add(source, column);
    }
    return estimate;
  }

  void fill(const SamplesDescriptor& declared, Samples& samples) {
    std::size_t count = 1;
    for (std::size_t i = 0; i < declared.axes.size(); ++i) {
      samples.shape.push_back(below(7));
      count *= samples.shape.back();
    }
    if (below(2) == 0) samples.standard_deviations.assign(below(2) == 0 ? 1 : count, 0.25);
    for (std::size_t i = 0; i < count; ++i)
      for (const SampleColumn& column : declared.columns)
        for (std::size_t k = 0; k < column.count; ++k) append(column, samples.bytes);
  }

  void append(const SampleColumn& column, std::vector<std::byte>& bytes) {
    const double any = column.may_be_missing && below(4) == 0
                           ? std::numeric_limits<double>::quiet_NaN()
                           : number();
    const auto append_as = [&](auto value) {
      const std::size_t place = bytes.size();
      bytes.resize(place + sizeof value);
      std::memcpy(bytes.data() + place, &value, sizeof value);
    };
    switch (column.type) {
      case SampleType::uint8:
        return append_as(static_cast<std::uint8_t>(bits_()));
      case SampleType::uint16:
        return append_as(static_cast<std::uint16_t>(bits_()));
      case SampleType::float32:
        return append_as(std::isnan(any) ? static_cast<float>(any)
                                         : static_cast<float>(std::remainder(any, 1e6)));
      case SampleType::float64:
        return append_as(any);
    }
  }

  std::mt19937_64 bits_;
  std::uint32_t owners_;
};

inline bool same_bits(std::span<const double> a, std::span<const double> b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

inline void expect_same(const Estimate& a, const Estimate& b) {
  ASSERT_TRUE(b.type != nullptr && same_payload(*a.type, *b.type));
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_TRUE(same_bits(a.value, b.value));
  EXPECT_EQ(a.labels, b.labels);
  EXPECT_EQ(a.correlation_unknown, b.correlation_unknown);
  ASSERT_EQ(a.lineage.dimension(), b.lineage.dimension());
  ASSERT_EQ(a.lineage.size(), b.lineage.size());
  for (std::size_t k = 0; k < a.lineage.size(); ++k) {
    EXPECT_EQ(a.lineage.sources()[k], b.lineage.sources()[k]);
    EXPECT_TRUE(same_bits(a.lineage.column(k), b.lineage.column(k)));
  }
}

/// Every bit of two outputs, NaN and -0 included.
inline void expect_same(const Output& a, const Output& b) {
  EXPECT_EQ(a.acquired, b.acquired);
  expect_same(a.estimate, b.estimate);
  EXPECT_EQ(a.samples.shape, b.samples.shape);
  EXPECT_EQ(a.samples.bytes, b.samples.bytes);
  EXPECT_TRUE(same_bits(a.samples.standard_deviations, b.samples.standard_deviations));
  ASSERT_EQ(a.elements.size(), b.elements.size());
  for (std::size_t i = 0; i < a.elements.size(); ++i) expect_same(a.elements[i], b.elements[i]);
}

}  // namespace ilss::test
