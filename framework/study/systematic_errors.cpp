#include "framework/study/systematic_errors.h"

#include "framework/semantics/error_draws.h"
#include "framework/semantics/perturbation.h"

namespace ilss {

Outcome<> draw_systematic_errors(const System& system, std::uint64_t seed, Estimate& output) {
  constexpr bool with_lineages = true;
  const auto first_output = std::span(system.plan().outputs).first(1);
  Perturbation perturbation(system, first_output, {}, Redo::functions, with_lineages);
  const std::span<const Source> sources = perturbation.sources();
  std::vector<double> errors;
  ErrorDraws(system.plan().owners, seed).fill(sources, 0, errors);
  for (std::size_t k = 0; k < sources.size(); ++k)
    if (!sources[k].persistent()) errors[k] = 0;  // drawn by the tick
  perturbation.apply(std::span(errors).first(sources.size()));
  if (perturbation.failed(0)) return perturbation.fault(0);
  output = perturbation.value(0);
  normalize(*output.type, output.value);
  return {};
}

}  // namespace ilss
