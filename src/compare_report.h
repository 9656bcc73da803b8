// A comparison as tables for people and as JSON.
#pragma once

#include <string>

#include "framework/report/estimate_json.h"
#include "framework/study/comparison.h"
#include "framework/study/set_comparison.h"

namespace ilss {

/// Tables of values, errors and judgements, then a sentence an alternative.
std::string comparison_text(const Study& study, const Comparison& comparison);

/// Every figure, SI units.
Json comparison_json(const Study& study, const Comparison& comparison);

/// The same of a study of sets: a table for each case and payload of elements, a row an
/// alternative.
std::string set_comparison_text(const Study& study, const std::vector<SetCase>& cases);
Json set_comparison_json(const Study& study, const std::vector<SetCase>& cases);

}  // namespace ilss
