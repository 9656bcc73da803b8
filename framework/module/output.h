// A module's output: the data half of its characteristic output vector.
#pragma once

#include <cstdint>
#include <vector>

#include "framework/estimate/estimate.h"
#include "framework/module/time.h"

namespace ilss {

/// A large array whose elements have independent noise. `levels` holds 8-bit data (images),
/// `values` everything else; row-major over `shape`. `standard_deviations` has one entry per
/// element, one for all, or none where the noise is not modelled.
struct Samples {
  std::vector<std::size_t> shape;
  std::vector<std::uint8_t> levels;
  std::vector<double> values;
  std::vector<double> standard_deviations;
};

/// What a module emits: an estimate of its numeric components, and, as its payload's descriptor
/// says, samples or the elements of a set. Buffers are reused from tick to tick.
struct Output {
  Estimate estimate;
  Samples samples = {};
  std::vector<Estimate> elements = {};
  Acquisition acquired = {};  ///< when the data in it were acquired
};

}  // namespace ilss
