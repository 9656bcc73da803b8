// The three outcomes of a tick: an output, `pending` (nothing due yet), or a typed fault.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace ilss {

/// Why a module gave no output. The names are what users see in YAML and JSON.
enum class FaultKind {
  no_detection,    ///< what is looked for is not there: no echo, no target in the image
  out_of_range,    ///< a value lies outside what the sensor or formula holds for
  stale,           ///< an input is older than is allowed
  degenerate,      ///< the geometry does not determine the answer
  ambiguous,       ///< more than one answer fits
  not_finite,      ///< an input or a result is NaN or infinite
  end_of_data,     ///< the recording or folder has no more
  bad_data,        ///< a file or device gave something unreadable
  device_lost,     ///< a device or file cannot be opened or read any more
  no_error_known,  ///< the error at this operating point is not declared
  refused,         ///< a command cannot be followed
  internal,        ///< the module threw: a defect
};

/// The fault's name: "no_detection".
std::string_view fault_name(FaultKind kind);

/// A typed fault with a message for the person who reads it.
struct Fault {
  FaultKind kind;
  std::string message;
};

/// Nothing is due yet.
struct Pending {};

/// A value, `pending` or a fault.
template <typename T = void>
class [[nodiscard]] Outcome {
 public:
  Outcome(T value) : state_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Outcome(Fault fault) : state_(std::move(fault)) {}  // NOLINT(google-explicit-constructor)
  Outcome(Pending pending) : state_(pending) {}       // NOLINT(google-explicit-constructor)

  bool has_output() const { return state_.index() == 0; }
  bool is_fault() const { return state_.index() == 1; }
  bool is_pending() const { return state_.index() == 2; }
  explicit operator bool() const { return has_output(); }

  const T& operator*() const { return *std::get_if<0>(&state_); }
  T& operator*() { return *std::get_if<0>(&state_); }
  const T* operator->() const { return std::get_if<0>(&state_); }
  const Fault& fault() const { return std::get<1>(state_); }

 private:
  std::variant<T, Fault, Pending> state_;
};

/// The outcome of a tick whose output went elsewhere. Success costs no allocation.
template <>
class [[nodiscard]] Outcome<void> {
 public:
  Outcome() = default;
  Outcome(Fault fault)  // NOLINT(google-explicit-constructor)
      : fault_(std::make_unique<Fault>(std::move(fault))) {}
  Outcome(Pending) : pending_(true) {}  // NOLINT(google-explicit-constructor)

  bool has_output() const { return !pending_ && fault_ == nullptr; }
  bool is_fault() const { return fault_ != nullptr; }
  bool is_pending() const { return pending_; }
  explicit operator bool() const { return has_output(); }
  const Fault& fault() const { return *fault_; }

 private:
  std::unique_ptr<Fault> fault_;
  bool pending_ = false;
};

}  // namespace ilss
