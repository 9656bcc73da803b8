#include "framework/semantics/error_draws.h"

#include <map>
#include <string_view>

namespace ilss {

ErrorDraws::ErrorDraws(std::span<const Source> sources, const SourceOwners& owners,
                       std::uint64_t seed) {
  // Owners may share a name: an element of a vector constant, and a parameter of a module.
  std::vector<std::uint64_t> namesakes_before;
  std::map<std::string_view, std::uint64_t> namesakes;
  for (const SourceOwner& owner : owners) namesakes_before.push_back(namesakes[owner.name]++);
  for (const Source& source : sources) {
    const bool listed = source.owner < owners.size();
    const SourceOwner owner = listed ? owners[source.owner] : SourceOwner{"a given source"};
    std::uint64_t stream = derive_seed(seed, owner.name);
    stream = derive_seed(stream, std::uint64_t{source.column});
    stream = derive_seed(stream, static_cast<std::uint64_t>(source.tick));
    if (listed) stream = derive_seed(stream, namesakes_before[source.owner]);
    if (!listed) stream = derive_seed(stream, std::uint64_t{source.owner});
    streams_.push_back({stream, owner.distribution});
  }
}

void ErrorDraws::fill(std::size_t block_index, std::vector<double>& errors) const {
  const std::size_t count = streams_.size();
  errors.resize(block * count);
  for (std::size_t k = 0; k < count; ++k) {
    RandomBits random(derive_seed(streams_[k].seed, static_cast<std::uint64_t>(block_index)));
    if (streams_[k].distribution.shape == Shape::normal)
      for (std::size_t row = 0; row < block; ++row) errors[row * count + k] = draw_normal(random);
    else
      for (std::size_t row = 0; row < block; ++row)
        errors[row * count + k] = draw(streams_[k].distribution, random);
  }
}

}  // namespace ilss
