// The errors of many trials: what each source of error draws, whoever asks and in whatever order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "framework/estimate/source.h"

namespace ilss {

/// Draws of zero mean and unit variance for a list of sources, in blocks of trials. A source's
/// draws follow from the seed, its owner's name (and how many owners of that name come before), its
/// column, tick and the trial's block.
class ErrorDraws {
 public:
  static constexpr std::size_t block = 256;  ///< trials

  /// Sources of owners that `owners` does not list are normal.
  ErrorDraws(std::span<const Source> sources, const SourceOwners& owners, std::uint64_t seed);

  /// Sets `errors` to the draws of a block: `block` rows, one entry a source.
  void fill(std::size_t block_index, std::vector<double>& errors) const;

 private:
  struct Stream {
    std::uint64_t seed;
    Distribution distribution;
  };
  std::vector<Stream> streams_;
};

}  // namespace ilss
