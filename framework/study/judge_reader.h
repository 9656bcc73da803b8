// The keys of a study's file that say how sets are judged.
#pragma once

#include "framework/module/document.h"
#include "framework/study/study.h"

namespace ilss {

/// Reads what only studies of sets have into `study`, whose payload and alternatives are known:
/// `judge: {ELEMENT: [COMPONENT, ...]}` or `{ELEMENT: {components, overlap, gate, only}}`, where
/// ELEMENT is one of the set's, `validation_gate` and `reference`. What is wrong goes to
/// `diagnostics`; so do these keys in a study of single estimates, and the keys of such in one of
/// sets.
void read_set_keys(const Node& file, Study& study, Diagnostics& diagnostics);

}  // namespace ilss
