#include "framework/report/feature_file.h"

#include <fmt/format.h>

#include "framework/report/estimate_json.h"

namespace ilss {

FeatureFile::FeatureFile(std::ostream& stream, Format format, const PayloadDescriptor& set)
    : stream_(stream) {
  if (format == Format::csv) columns_.emplace(set);
  stream_ << (columns_ ? columns_->header() : "[");
}

void FeatureFile::observe(const TickView& tick) {
  const Output* set = tick.output(0).output;
  if (set == nullptr) return;
  const double time = seconds(tick.time());
  const double acquired = seconds(set->acquired.oldest);
  if (columns_) {
    const std::string leading = fmt::format("{},{},{}", tick.tick(), time, acquired);
    for (const Estimate& element : set->elements) stream_ << columns_->line(leading, element);
    return;
  }
  const Json json = {{"tick", tick.tick()},
                     {"time", time},
                     {"acquired", acquired},
                     {"output", outputs_json(tick)}};
  stream_ << (any_ ? ",\n" : "\n") << json_text(json, true);
  any_ = true;
}

void FeatureFile::finish() {
  if (!columns_) stream_ << "\n]\n";
}

}  // namespace ilss
