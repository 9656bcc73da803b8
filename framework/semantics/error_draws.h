// The errors of many trials: what each source of error draws, whoever asks and in whatever order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "framework/estimate/source.h"

namespace ilss {

/// Draws of zero mean and unit variance for sources, in blocks of trials. A source's draws follow
/// from the seed, its owner's name (and how many owners of that name come before), its column, tick
/// and the trial's block; so it draws the same whichever sources are drawn beside it.
class ErrorDraws {
 public:
  static constexpr std::size_t block = 256;  ///< trials

  /// `owners` must outlive it. Sources of owners that it does not list are normal.
  ErrorDraws(const SourceOwners& owners, std::uint64_t seed);

  /// Sets `errors` to the draws of a block: `block` rows, one entry a source.
  void fill(std::span<const Source> sources, std::size_t block_index,
            std::vector<double>& errors) const;

  /// The seed of all that a source draws.
  std::uint64_t seed_of(const Source& source) const;

 private:
  struct Owner {
    std::uint64_t seed;
    std::uint64_t namesakes_before;
  };
  const SourceOwners& owners_;
  std::uint64_t given_seed_;  ///< of sources that are not listed
  std::vector<Owner> streams_;
};

}  // namespace ilss
