// A comparison as tables for people and as JSON.
#pragma once

#include <string>

#include "framework/study/comparison.h"
#include "src/estimate_json.h"

namespace ilss {

/// Tables of values, errors and judgements, then a sentence an alternative.
std::string comparison_text(const Study& study, const Comparison& comparison);

/// Every figure, SI units.
Json comparison_json(const Study& study, const Comparison& comparison);

}  // namespace ilss
