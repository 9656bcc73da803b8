// Outputs as bytes and back, driven by their payloads' descriptors: what recordings and other hosts
// exchange.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "framework/estimate/source.h"
#include "framework/module/outcome.h"
#include "framework/module/output.h"

namespace ilss {

using Bytes = std::vector<std::byte>;

/// Writes and reads the outcomes of a plan's modules. What all of them have in common, the owners
/// of sources and the payloads with their components, labels, columns and elements, stands once in
/// a header; an outcome refers to it. Numbers are little-endian and come back bit for bit.
///
/// Header: "ILSS" and the version (u32), owners, payloads (elements before the sets that hold
/// them). Outcome: its kind, then a fault's kind and message, or an output: when it was acquired
/// (ns), the sources that its estimate and its elements have in common (each once, sorted), the
/// estimate, the samples as their descriptor says, and the elements. An estimate is its payload's
/// place in the header, its frame, values, labels, and, for each of its sources, the place among
/// the common ones and a column of the factor.
class Codec {
 public:
  static constexpr std::uint32_t version = 1;

  /// For outputs of these payloads, whose elements' payloads are added by themselves.
  /// @throws std::invalid_argument where two of one name differ.
  Codec(SourceOwners owners, std::span<const PayloadDescriptor* const> payloads);

  /// The program's own payload of a name; null where it has none.
  using FindPayload = std::function<const PayloadDescriptor*(std::string_view name)>;

  /// Reads a header. Its payloads are the program's own where `find` knows them, else the codec's,
  /// which must then outlive the outputs that it reads. Faults: bad_data where the bytes are no
  /// header, or a payload is declared otherwise than the program's.
  static Outcome<Codec> read_header(std::span<const std::byte> header,
                                    const FindPayload& find = {});
  Bytes header() const;

  const SourceOwners& owners() const { return owners_; }
  /// Elements before the sets that hold them.
  std::span<const PayloadDescriptor* const> payloads() const { return payloads_; }

  /// Appends an outcome, with the output where it has one.
  /// @throws std::invalid_argument where the header has not the output's payloads or owners, or the
  /// output breaks its contract.
  void encode(const Outcome<>& outcome, const Output& output, Bytes& bytes) const;

  /// Reads an outcome, and `output` where it has one; on a fault both are to be forgotten. What is
  /// read keeps to its payload's contract, whatever the bytes are. Faults: bad_data.
  Outcome<> decode(std::span<const std::byte> bytes, Outcome<>& outcome, Output& output) const;

 private:
  class Writer;
  class Reader;
  Codec() = default;

  void add(const PayloadDescriptor& payload);
  std::uint32_t place_of(const PayloadDescriptor& payload) const;
  void write(const Outcome<>& outcome, const Output& output, Bytes& bytes) const;
  void write_output(const Output& output, Writer& writer) const;
  void write_estimate(const Estimate& estimate, std::string_view frame,
                      std::span<const Source> sources, Writer& writer) const;
  void read_output(Reader& reader, Output& output) const;
  void read_estimate(Reader& reader, std::string_view frame, std::span<const Source> sources,
                     Estimate& estimate) const;
  void read_sources(Reader& reader, std::vector<Source>& sources) const;

  SourceOwners owners_;
  std::vector<const PayloadDescriptor*> payloads_;
  std::vector<std::shared_ptr<const PayloadDescriptor>> own_;  ///< those that nobody else has
};

}  // namespace ilss
