#include "framework/semantics/error_draws.h"

#include <string_view>
#include <unordered_map>

namespace ilss {

ErrorDraws::ErrorDraws(const SourceOwners& owners, std::uint64_t seed)
    : owners_(owners), given_seed_(derive_seed(seed, "a given source")) {
  // Owners may share a name: an element of a vector constant, and a parameter of a module.
  std::unordered_map<std::string_view, std::uint64_t> namesakes;
  streams_.reserve(owners.size());
  for (const SourceOwner& owner : owners)
    streams_.push_back({derive_seed(seed, owner.name), namesakes[owner.name]++});
}

std::uint64_t ErrorDraws::seed_of(const Source& source) const {
  const bool listed = source.owner < streams_.size();
  std::uint64_t stream = listed ? streams_[source.owner].seed : given_seed_;
  stream = derive_seed(stream, std::uint64_t{source.column});
  stream = derive_seed(stream, static_cast<std::uint64_t>(source.tick));
  return derive_seed(
      stream, listed ? streams_[source.owner].namesakes_before : std::uint64_t{source.owner});
}

void ErrorDraws::fill(std::span<const Source> sources, std::size_t block_index,
                      std::vector<double>& errors) const {
  static const Distribution normal;
  const std::size_t count = sources.size();
  errors.resize(block * count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t owner = sources[k].owner;
    const Distribution& law = owner < owners_.size() ? owners_[owner].distribution : normal;
    RandomBits random(derive_seed(seed_of(sources[k]), static_cast<std::uint64_t>(block_index)));
    if (law.shape == Shape::normal)
      for (std::size_t row = 0; row < block; ++row) errors[row * count + k] = draw_normal(random);
    else
      for (std::size_t row = 0; row < block; ++row) errors[row * count + k] = draw(law, random);
  }
}

}  // namespace ilss
