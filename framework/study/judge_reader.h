// The part of a study's file that says how the elements of sets are judged.
#pragma once

#include <vector>

#include "framework/module/document.h"
#include "framework/study/set_matching.h"

namespace ilss {

/// Reads `judge: {ELEMENT: [COMPONENT, ...]}` or `{ELEMENT: {components, overlap, gate, only}}`,
/// where ELEMENT is one of `set`'s elements. What is wrong goes to `diagnostics`.
std::vector<ElementRule> read_judge(const Node& judge, const PayloadDescriptor& set,
                                    Diagnostics& diagnostics);

}  // namespace ilss
