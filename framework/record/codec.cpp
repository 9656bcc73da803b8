#include "framework/record/codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <stdexcept>

#include "framework/module/contract.h"

namespace ilss {

static_assert(std::endian::native == std::endian::little,
              "numbers are written as they stand, which must be little-endian");

namespace {

constexpr std::string_view magic = "ILSS";

enum class OutcomeKind : std::uint8_t { output, pending, fault };

/// What an estimate's first byte says.
constexpr std::uint8_t correlation_is_unknown = 1;
constexpr std::uint8_t frame_is_written = 2;  ///< else it is the output's
constexpr std::uint8_t has_all_sources = 4;   ///< that are common, in their order

/// Of a frame's name, so that few bytes cannot ask for much.
constexpr std::size_t longest_frame = 1024;

/// Why bytes are not what they should be; does not leave this file.
struct Malformed {
  std::string reason;
};

/// The sources of an output's estimate and elements, each once.
std::vector<Source> common_sources(const Output& output) {
  std::vector<Source> sources;
  const auto add = [&sources](const Estimate& estimate) {
    const std::span<const Source> more = estimate.lineage.sources();
    sources.insert(sources.end(), more.begin(), more.end());
  };
  add(output.estimate);
  for (const Estimate& element : output.elements) add(element);
  if (output.elements.empty()) return sources;
  std::sort(sources.begin(), sources.end());
  sources.erase(std::unique(sources.begin(), sources.end()), sources.end());
  return sources;
}

}  // namespace

/// Appends numbers and texts to bytes.
class Codec::Writer {
 public:
  explicit Writer(Bytes& bytes) : bytes_(bytes) {}

  void raw(const void* data, std::size_t size) {
    const auto* first = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), first, first + size);
  }
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void number(Number number) { raw(&number, sizeof number); }
  template <typename Enum>
  void choice(Enum value) {
    number(static_cast<std::uint8_t>(value));
  }
  void flag(bool value) { number(static_cast<std::uint8_t>(value)); }
  void count(std::size_t count) {
    if (count > UINT32_MAX) throw std::invalid_argument("more than 2^32 of a thing to write");
    number(static_cast<std::uint32_t>(count));
  }
  void text(std::string_view text) {
    count(text.size());
    raw(text.data(), text.size());
  }
  void numbers(std::span<const double> numbers) { raw(numbers.data(), numbers.size_bytes()); }
  template <typename List, typename Write>
  void list(const List& list, Write write) {
    count(list.size());
    for (const auto& entry : list) write(entry);
  }

 private:
  Bytes& bytes_;
};

/// Takes numbers and texts from bytes. @throws Malformed
class Codec::Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  /// So many bytes, which are there.
  std::span<const std::byte> raw(std::size_t size) {
    if (size > bytes_.size()) throw Malformed{"they end too soon"};
    const auto taken = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return taken;
  }
  template <typename Number>
  Number number() {
    Number number;
    std::memcpy(&number, raw(sizeof number).data(), sizeof number);
    return number;
  }
  /// One of the values from 0 to `last`.
  template <typename Enum>
  Enum choice(Enum last) {
    const auto value = number<std::uint8_t>();
    if (value > static_cast<std::uint8_t>(last))
      throw Malformed{fmt::format("{} is none of {} choices", value, static_cast<int>(last) + 1)};
    return static_cast<Enum>(value);
  }
  bool flag() {
    const auto value = number<std::uint8_t>();
    if (value > 1) throw Malformed{"a flag is neither 0 nor 1"};
    return value != 0;
  }
  /// Of things that are of at least so many bytes each, and so may be there.
  std::size_t count(std::size_t least_bytes) {
    const std::size_t count = number<std::uint32_t>();
    if (count > bytes_.size() / least_bytes)
      throw Malformed{fmt::format("{} of a thing, more than there is room for", count)};
    return count;
  }
  std::string text(std::size_t longest = UINT32_MAX) {
    const auto characters = raw(count(1));
    if (characters.size() > longest) throw Malformed{"a name without end"};
    std::string text(characters.size(), '\0');
    std::transform(characters.begin(), characters.end(), text.begin(),
                   [](std::byte byte) { return static_cast<char>(byte); });
    return text;
  }
  /// Into `numbers`, as many as it has.
  void numbers(std::span<double> numbers) {
    const auto taken = raw(numbers.size_bytes());
    if (!taken.empty()) std::memcpy(numbers.data(), taken.data(), taken.size());
  }
  /// As many of `read()` as the count says.
  template <typename T, typename Read>
  void list(std::vector<T>& list, std::size_t least_bytes, Read read) {
    list.clear();
    for (std::size_t n = count(least_bytes); n > 0; --n) list.push_back(read());
  }
  void expect_end() const {
    if (!bytes_.empty()) throw Malformed{fmt::format("{} are left over", bytes_.size())};
  }

 private:
  std::span<const std::byte> bytes_;
};

namespace {

constexpr std::size_t text_bytes = 4;  // of an empty one

template <typename Writer>
void write_owner(const SourceOwner& owner, Writer& writer) {
  writer.text(owner.name);
  writer.flag(owner.persistent);
  writer.number(owner.degrees_of_freedom);
  writer.choice(owner.distribution.shape);
  writer.number(owner.distribution.degrees_of_freedom);
  static const std::vector<double> none;
  const auto& samples = owner.distribution.samples ? *owner.distribution.samples : none;
  writer.count(samples.size());
  writer.numbers(samples);
}

template <typename Reader>
SourceOwner read_owner(Reader& reader) {
  SourceOwner owner;
  owner.name = reader.text();
  owner.persistent = reader.flag();
  owner.degrees_of_freedom = reader.template number<double>();
  owner.distribution.shape = reader.choice(Shape::empirical);
  owner.distribution.degrees_of_freedom = reader.template number<double>();
  std::vector<double> samples(reader.count(sizeof(double)));
  reader.numbers(samples);
  const bool is_empirical = owner.distribution.shape == Shape::empirical;
  if (!(owner.degrees_of_freedom > 0) || std::isnan(owner.distribution.degrees_of_freedom) ||
      is_empirical == samples.empty())
    throw Malformed{"an owner's distribution is none"};
  if (is_empirical)
    owner.distribution.samples = std::make_shared<const std::vector<double>>(std::move(samples));
  return owner;
}

template <typename Writer>
void write_component(const Component& component, Writer& writer) {
  writer.text(component.name);
  writer.text(component.unit);
  writer.text(component.documentation);
  writer.flag(component.default_value.has_value());
  if (component.default_value) writer.number(*component.default_value);
  writer.choice(component.geometry);
}

template <typename Reader>
Component read_component(Reader& reader) {
  Component component;
  component.name = reader.text();
  component.unit = reader.text();
  component.documentation = reader.text();
  if (reader.flag()) component.default_value = reader.template number<double>();
  component.geometry = reader.choice(Geometry::rotation);
  return component;
}

template <typename Writer>
void write_column(const SampleColumn& column, Writer& writer) {
  writer.text(column.name);
  writer.text(column.unit);
  writer.text(column.documentation);
  writer.choice(column.type);
  writer.count(column.count);
  writer.flag(column.may_be_missing);
}

template <typename Reader>
SampleColumn read_column(Reader& reader) {
  SampleColumn column;
  column.name = reader.text();
  column.unit = reader.text();
  column.documentation = reader.text();
  column.type = reader.choice(SampleType::float64);
  column.count = reader.template number<std::uint32_t>();
  column.may_be_missing = reader.flag();
  if (column.count == 0) throw Malformed{"a column of no numbers"};
  return column;
}

/// A payload but for its elements.
template <typename Writer>
void write_payload(const PayloadDescriptor& payload, Writer& writer) {
  const auto text = [&writer](const std::string& name) { writer.text(name); };
  writer.text(payload.name);
  writer.text(payload.documentation);
  writer.list(payload.components, [&](const Component& c) { write_component(c, writer); });
  writer.list(payload.labels, [&](const Label& label) {
    writer.text(label.name);
    writer.list(label.values, text);
  });
  writer.flag(payload.samples.has_value());
  if (payload.samples) {
    writer.list(payload.samples->axes, text);
    writer.list(payload.samples->columns, [&](const SampleColumn& c) { write_column(c, writer); });
  }
  writer.text(payload.element);
}

/// What takes differences of values relies on it.
void check_rotations(const std::vector<Component>& components) {
  std::size_t of_rotation = 0;
  for (const Component& component : components) {
    if (component.geometry == Geometry::rotation)
      ++of_rotation;
    else if (of_rotation % 3 != 0)
      break;
  }
  if (of_rotation % 3 != 0) throw Malformed{"a rotation has other than three components"};
}

/// Whether rotations have three consecutive components, in radians, as whoever takes them for
/// granted needs.
bool has_whole_rotations(const std::vector<Component>& components) {
  std::size_t in_a_row = 0;
  for (const Component& component : components) {
    const bool is_rotation = component.geometry == Geometry::rotation;
    if (is_rotation ? component.unit != "rad" : in_a_row % 3 != 0) return false;
    if (is_rotation) ++in_a_row;
  }
  return in_a_row % 3 == 0;
}

template <typename Reader>
PayloadDescriptor read_payload(Reader& reader) {
  const auto text = [&reader] { return reader.text(); };
  constexpr std::size_t component_bytes = 3 * text_bytes + 2;
  constexpr std::size_t column_bytes = 3 * text_bytes + 6;
  PayloadDescriptor payload;
  payload.name = reader.text();
  payload.documentation = reader.text();
  reader.list(payload.components, component_bytes, [&] { return read_component(reader); });
  if (!has_whole_rotations(payload.components)) throw Malformed{"a rotation is not whole"};
  reader.list(payload.labels, 2 * text_bytes, [&] {
    Label label{reader.text(), {}};
    reader.list(label.values, text_bytes, text);
    return label;
  });
  if (reader.flag()) {
    payload.samples.emplace();
    reader.list(payload.samples->axes, text_bytes, text);
    reader.list(payload.samples->columns, column_bytes, [&] { return read_column(reader); });
  }
  payload.element = reader.text();
  check_rotations(payload.components);
  return payload;
}

template <typename Writer>
void write_samples(const Samples& samples, Writer& writer) {
  writer.list(samples.shape, [&](std::size_t size) { writer.number(std::uint64_t{size}); });
  writer.list(samples.standard_deviations, [&](double deviation) { writer.number(deviation); });
  writer.raw(samples.bytes.data(), samples.bytes.size());
}

template <typename Reader>
void read_samples(Reader& reader, const SamplesDescriptor& declared, Samples& samples) {
  reader.list(samples.shape, sizeof(std::uint64_t),
              [&] { return std::size_t{reader.template number<std::uint64_t>()}; });
  reader.list(samples.standard_deviations, sizeof(double),
              [&] { return reader.template number<double>(); });
  std::size_t size = samples.shape.empty() ? 0 : declared.bytes();
  for (const std::size_t count : samples.shape)
    if (__builtin_mul_overflow(size, count, &size)) throw Malformed{"samples without end"};
  const auto bytes = reader.raw(size);
  samples.bytes.assign(bytes.begin(), bytes.end());
}

Fault malformed(const char* what, const Malformed& malformed) {
  return {FaultKind::bad_data, fmt::format("the bytes are no {}: {}", what, malformed.reason)};
}

}  // namespace

Codec::Codec(SourceOwners owners, std::span<const PayloadDescriptor* const> payloads)
    : owners_(std::move(owners)) {
  for (const PayloadDescriptor* payload : payloads) add(*payload);
}

void Codec::add(const PayloadDescriptor& payload) {
  for (const PayloadDescriptor* known : payloads_) {
    if (known->name != payload.name) continue;
    if (same_payload(*known, payload)) return;
    throw std::invalid_argument(
        fmt::format("payload '{}' is to be recorded in two forms", payload.name));
  }
  for (const PayloadDescriptor* element : payload.elements) add(*element);
  payloads_.push_back(&payload);
}

/// Most outputs have the very descriptor that the header was made of.
std::uint32_t Codec::place_of(const PayloadDescriptor& payload) const {
  auto found = std::find(payloads_.begin(), payloads_.end(), &payload);
  if (found == payloads_.end())
    found = std::find_if(payloads_.begin(), payloads_.end(), [&](const PayloadDescriptor* known) {
      return same_payload(*known, payload);
    });
  if (found == payloads_.end())
    throw std::invalid_argument(
        fmt::format("the recording's header has no payload '{}'", payload.name));
  return static_cast<std::uint32_t>(found - payloads_.begin());
}

Bytes Codec::header() const {
  Bytes bytes;
  Writer writer(bytes);
  writer.raw(magic.data(), magic.size());
  writer.number(version);
  writer.list(owners_, [&](const SourceOwner& owner) { write_owner(owner, writer); });
  writer.list(payloads_, [&](const PayloadDescriptor* payload) {
    write_payload(*payload, writer);
    writer.list(payload->elements,
                [&](const PayloadDescriptor* element) { writer.number(place_of(*element)); });
  });
  return bytes;
}

Outcome<Codec> Codec::read_header(std::span<const std::byte> header, const FindPayload& find) {
  Codec codec;
  try {
    Reader reader(header);
    const auto start = reader.raw(magic.size());
    if (std::memcmp(start.data(), magic.data(), magic.size()) != 0)
      throw Malformed{"they do not begin with ILSS"};
    if (const auto found = reader.number<std::uint32_t>(); found != version)
      throw Malformed{fmt::format("version {}; expected {}", found, version)};
    constexpr std::size_t owner_bytes = text_bytes + 22;
    constexpr std::size_t payload_bytes = 3 * text_bytes + 13;
    reader.list(codec.owners_, owner_bytes, [&] { return read_owner(reader); });
    for (std::size_t n = reader.count(payload_bytes); n > 0; --n) {
      auto payload = std::make_shared<PayloadDescriptor>(read_payload(reader));
      reader.list(payload->elements, sizeof(std::uint32_t), [&] {
        const auto place = reader.number<std::uint32_t>();
        if (place >= codec.payloads_.size()) throw Malformed{"an element's payload is not there"};
        return codec.payloads_[place];
      });
      for (const PayloadDescriptor* known : codec.payloads_)
        if (known->name == payload->name)
          throw Malformed{fmt::format("payload '{}' stands twice", payload->name)};
      const PayloadDescriptor* own = find ? find(payload->name) : nullptr;
      if (own != nullptr && !same_payload(*own, *payload))
        return Fault{FaultKind::bad_data,
                     fmt::format("payload '{}' was recorded with other components, labels, samples "
                                 "or elements than it has here",
                                 payload->name)};
      codec.payloads_.push_back(own != nullptr ? own : payload.get());
      if (own == nullptr) codec.own_.push_back(std::move(payload));
    }
    reader.expect_end();
  } catch (const Malformed& trouble) {
    return malformed("header of a recording", trouble);
  }
  return codec;
}

void Codec::encode(const Outcome<>& outcome, const Output& output, Bytes& bytes) const {
  const std::size_t begin = bytes.size();
  try {
    write(outcome, output, bytes);
  } catch (...) {
    bytes.resize(begin);  // nothing half-written
    throw;
  }
}

void Codec::write(const Outcome<>& outcome, const Output& output, Bytes& bytes) const {
  Writer writer(bytes);
  if (outcome.is_fault()) {
    writer.choice(OutcomeKind::fault);
    writer.choice(outcome.fault().kind);
    writer.text(outcome.fault().message);
  } else if (outcome.is_pending()) {
    writer.choice(OutcomeKind::pending);
  } else {
    writer.choice(OutcomeKind::output);
    write_output(output, writer);
  }
}

void Codec::write_output(const Output& output, Writer& writer) const {
  if (output.estimate.type == nullptr) throw std::invalid_argument("an output has no payload");
  const PayloadDescriptor& payload = *output.estimate.type;
  if (find_breach(output, payload) != Breach::none)
    throw std::invalid_argument(describe_breach(output, payload).message);
  writer.number(std::int64_t{output.acquired.oldest.time_since_epoch().count()});
  writer.number(std::int64_t{output.acquired.newest.time_since_epoch().count()});
  const std::vector<Source> sources = common_sources(output);
  writer.list(sources, [&](const Source& source) {
    if (source.owner >= owners_.size())
      throw std::invalid_argument(
          fmt::format("the recording's header has no owner {}", source.owner));
    writer.number(source.owner);
    writer.number(source.column);
    writer.number(source.tick);
  });
  write_estimate(output.estimate, {}, sources, writer);
  if (payload.samples) write_samples(output.samples, writer);
  if (payload.element.empty()) return;
  writer.list(output.elements, [&](const Estimate& element) {
    write_estimate(element, output.estimate.frame, sources, writer);
  });
}

void Codec::write_estimate(const Estimate& estimate, std::string_view frame,
                           std::span<const Source> sources, Writer& writer) const {
  const Lineage& lineage = estimate.lineage;
  const bool has_all = lineage.size() == sources.size();
  const bool has_frame = estimate.frame != frame;
  writer.number(static_cast<std::uint8_t>(
      (estimate.correlation_unknown ? correlation_is_unknown : 0) |
      (has_frame ? frame_is_written : 0) | (has_all ? has_all_sources : 0)));
  writer.number(place_of(*estimate.type));
  if (has_frame) {
    if (estimate.frame.size() > longest_frame)
      throw std::invalid_argument(
          fmt::format("a frame's name is longer than {} bytes", longest_frame));
    writer.text(estimate.frame);
  }
  writer.numbers(estimate.value);
  for (const int label : estimate.labels) writer.number(static_cast<std::uint32_t>(label));
  if (!has_all) {
    auto place = sources.begin();
    writer.list(lineage.sources(), [&](const Source& source) {
      place = std::lower_bound(place, sources.end(), source);
      writer.number(static_cast<std::uint32_t>(place - sources.begin()));
    });
  }
  writer.numbers({lineage.factor().data(), lineage.dimension() * lineage.size()});
}

Outcome<> Codec::decode(std::span<const std::byte> bytes, Outcome<>& outcome,
                        Output& output) const {
  try {
    Reader reader(bytes);
    switch (reader.choice(OutcomeKind::fault)) {
      case OutcomeKind::fault: {
        const auto kind = reader.choice(FaultKind::internal);
        outcome = Fault{kind, reader.text()};
        break;
      }
      case OutcomeKind::pending:
        outcome = Pending{};
        break;
      case OutcomeKind::output:
        outcome = {};
        read_output(reader, output);
        break;
    }
    reader.expect_end();
  } catch (const Malformed& trouble) {
    return malformed("outcome", trouble);
  }
  if (!outcome.has_output() || find_breach(output, *output.estimate.type) == Breach::none)
    return {};
  return Fault{FaultKind::bad_data, describe_breach(output, *output.estimate.type).message};
}

void Codec::read_sources(Reader& reader, std::vector<Source>& sources) const {
  constexpr std::size_t source_bytes = 16;
  reader.list(sources, source_bytes, [&] {
    Source source;
    source.owner = reader.number<std::uint32_t>();
    source.column = reader.number<std::uint32_t>();
    source.tick = reader.number<std::int64_t>();
    if (source.owner >= owners_.size()) throw Malformed{"a source's owner is not there"};
    if (!sources.empty() && !(sources.back() < source))
      throw Malformed{"the sources are not in their order"};
    return source;
  });
}

void Codec::read_output(Reader& reader, Output& output) const {
  output.acquired.oldest = Time(Duration(reader.number<std::int64_t>()));
  output.acquired.newest = Time(Duration(reader.number<std::int64_t>()));
  std::vector<Source> sources;
  read_sources(reader, sources);
  read_estimate(reader, {}, sources, output.estimate);
  const PayloadDescriptor& payload = *output.estimate.type;
  output.samples.shape.clear();
  output.samples.bytes.clear();
  output.samples.standard_deviations.clear();
  if (payload.samples) read_samples(reader, *payload.samples, output.samples);
  output.elements.clear();
  if (payload.element.empty()) return;
  constexpr std::size_t element_bytes = 5;
  for (std::size_t n = reader.count(element_bytes); n > 0; --n)
    read_estimate(reader, output.estimate.frame, sources, output.elements.emplace_back());
}

void Codec::read_estimate(Reader& reader, std::string_view frame, std::span<const Source> sources,
                          Estimate& estimate) const {
  const auto flags = reader.number<std::uint8_t>();
  if (flags > (correlation_is_unknown | frame_is_written | has_all_sources))
    throw Malformed{"an estimate's flags are none"};
  const auto place = reader.number<std::uint32_t>();
  if (place >= payloads_.size()) throw Malformed{"an estimate's payload is not there"};
  const PayloadDescriptor& payload = *payloads_[place];
  const std::size_t dimension = payload.dimension();
  estimate.type = &payload;
  estimate.correlation_unknown = (flags & correlation_is_unknown) != 0;
  if ((flags & frame_is_written) != 0)
    estimate.frame = reader.text(longest_frame);
  else
    estimate.frame = frame;
  estimate.value.resize(dimension);
  reader.numbers(estimate.value);
  estimate.labels.clear();
  for (const Label& label : payload.labels) {
    const auto value = reader.number<std::uint32_t>();
    if (value >= label.values.size()) throw Malformed{"a label has no such value"};
    estimate.labels.push_back(static_cast<int>(value));
  }
  std::vector<std::uint32_t> places;
  if ((flags & has_all_sources) == 0)
    reader.list(places, sizeof(std::uint32_t), [&] {
      const auto source = reader.number<std::uint32_t>();
      if (source >= sources.size() || (!places.empty() && source <= places.back()))
        throw Malformed{"an estimate's sources are not there, or not in their order"};
      return source;
    });
  const std::size_t count = (flags & has_all_sources) != 0 ? sources.size() : places.size();
  if (dimension == 0 && count > 0) throw Malformed{"errors of an estimate of nothing"};
  estimate.lineage.reset(dimension);
  std::vector<double> column(dimension);
  for (std::size_t k = 0; k < count; ++k) {
    reader.numbers(column);
    estimate.lineage.add(sources[places.empty() ? k : places[k]], column);
  }
}

}  // namespace ilss
