#include "framework/study/systematic_errors.h"

#include "framework/semantics/error_draws.h"
#include "framework/semantics/perturbation.h"

namespace ilss {

Outcome<> draw_systematic_errors(const System& system, std::uint64_t seed, Estimate& output) {
  constexpr bool with_lineages = true;
  Perturbation perturbation(system, {}, Redo::functions, with_lineages);
  const std::vector<Source>& sources = perturbation.sources();
  std::vector<double> errors;
  ErrorDraws(sources, system.plan().owners, seed).fill(0, errors);
  for (std::size_t k = 0; k < sources.size(); ++k)
    if (!sources[k].persistent()) errors[k] = 0;  // drawn by the tick
  perturbation.apply(std::span(errors).first(sources.size()));
  const std::size_t node = system.plan().outputs.front();
  if (perturbation.failed(node)) return perturbation.fault(node);
  output = perturbation.value(node);
  normalize(*output.type, output.value);
  return {};
}

}  // namespace ilss
