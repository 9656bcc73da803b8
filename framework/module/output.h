// A module's output: the data half of its characteristic output vector.
#pragma once

#include <cstddef>
#include <vector>

#include "framework/module/elements.h"
#include "framework/module/time.h"

namespace ilss {

/// A large array whose elements have independent noise: `bytes` holds them as the payload's
/// SamplesDescriptor says, row-major over `shape`, and only rows_of and make_rows look into these.
/// `standard_deviations` has one entry per sample, one for all, or none where the noise is not
/// modelled.
struct Samples {
  std::vector<std::size_t> shape;
  std::vector<std::byte> bytes;
  std::vector<double> standard_deviations;
};

/// What a module emits: an estimate of its numeric components, and, as its payload's descriptor
/// says, samples or the elements of a set. Buffers are reused from tick to tick.
struct Output {
  Estimate estimate;
  Samples samples = {};
  Elements elements = {};
  Acquisition acquired = {};  ///< when the data in it were acquired
};

}  // namespace ilss
