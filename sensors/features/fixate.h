// Active sensing: where the head must look to keep an edge in view.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "framework/module/module_type.h"
#include "sensors/features/range_features.h"

namespace ilss {

/// The angle to which a sensor's head must turn to look at something, from straight ahead (the z
/// axis) to the left, as LepSensor's `rotate_to` takes it.
template <typename T>
struct HeadAngle {
  T angle;
  static constexpr std::string_view name = "head_angle";
  static constexpr std::string_view documentation = "where a sensor's head is to look";
  static constexpr auto fields = Fields{
      {"angle", "rad", "from straight ahead, positive to the left", required, Geometry::circular}};
};

/// Which edges count.
enum class FixatedEdge { any, corner, jump };
constexpr std::array<std::string_view, 3> choices(FixatedEdge) { return {"any", "corner", "jump"}; }

/// Estimator: follows one edge from scan to scan and says where the head must look to have it in
/// the middle of the next scan. The edge that it starts with is the one nearest in bearing to
/// `bearing`. After that it expects it where its last two places lead, as a vehicle's steady motion
/// moves it, and takes the edge within `gate` of there. A graph closes the loop with a driven
/// command: `commands: {look: {to: lep.rotate_to, from: fixate.angle}}`.
/// The angle's error is the edge's places' and the mount's; the head's own is none.
/// Input frame: the head's axis, x to the right and z forward. Faults: no_detection where there is
/// no such edge (a lost edge is expected to go on for `patience` scans, then the nearest to its
/// bearing counts); out_of_range where it lies behind the head's stops.
class Fixate final : public Module {
 public:
  static constexpr std::string_view name = "fixate";
  static constexpr std::string_view description =
      "the head angle that keeps an edge in view, to drive the head's command";
  static constexpr std::string_view reference = "Pears 1997, sec. 1: active sensing";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr bool remembers = true;
  static constexpr std::array faults = {FaultKind::no_detection, FaultKind::out_of_range};

  template <typename T>
  struct Parameters {
    T mount_heading;
    static constexpr std::string_view name = "fixate_parameters";
    static constexpr auto fields =
        Fields{{"mount.heading", "rad", "the scan's axis in the head, to the left", 0,
                Geometry::circular}};
  };

  struct Options {
    FixatedEdge edge = FixatedEdge::any;
    double bearing = 0;
    double gate = 0.2;
    std::int64_t patience = 5;
    double stop = 1.5707963267948966;
    void declare(OptionVisitor& visit);
  };

  static Interface interface();

  explicit Fixate(const Options& options) : options_(options) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  void reset() override;

 private:
  /// An edge at a time.
  struct Sighting {
    double time;
    Estimate place;
  };
  bool is_wanted(const Estimate& feature) const;
  const Estimate* choose(std::span<const Estimate> features, double time) const;
  double expected_bearing() const;

  Options options_;
  std::optional<Sighting> last_;
  std::optional<Sighting> before_;
  std::int64_t missed_ = 0;
};

}  // namespace ilss
