// A sensor of hand-made sets, for studies of sets in tests of the framework.
#pragma once

#include "framework/estimate/random.h"
#include "framework/module/registry.h"

namespace ilss::test {

/// What was made of some readings, matched by these.
template <typename T>
struct Piece {
  T position, slope, first_reading, last_reading;
  static constexpr std::string_view name = "piece";
  static constexpr auto fields = Fields{{"position", "m"},
                                        {"slope", "rad", "", required, Geometry::circular},
                                        {"first_reading", "1"},
                                        {"last_reading", "1"}};
};

inline constexpr std::string_view spot_colours[] = {"red", "blue"};
inline constexpr LabelField spot_labels[] = {{"colour", spot_colours}};

/// A place, matched by that.
template <typename T>
struct Spot {
  T x, z;
  std::array<int, 1> label{};
  static constexpr std::string_view name = "spot";
  static constexpr auto fields = Fields{{"x", "m"}, {"z", "m"}};
  static constexpr std::span<const LabelField> labels = spot_labels;
};

/// What cannot be matched.
template <typename T>
struct Mood {
  T level;
  static constexpr std::string_view name = "mood";
  static constexpr auto fields = Fields{{"level", "1"}};
};

template <typename T>
struct Findings {
  T count;
  static constexpr std::string_view name = "findings";
  static constexpr auto fields = Fields{{"count", "1"}};
  static constexpr std::string_view element = "piece, spot or mood";
  static std::vector<const PayloadDescriptor*> elements() {
    return {&descriptor<Piece>(), &descriptor<Spot>(), &descriptor<Mood>()};
  }
};

struct PieceOption {
  double position = 0, slope = 0;
  std::int64_t first = 0, last = 0;
  void declare(OptionVisitor& visit) {
    visit("position", position, "where", {.unit = "m"});
    visit("slope", slope, "how steep", {.unit = "rad"});
    visit("first", first, "reading");
    visit("last", last, "reading");
  }
};

enum class SpotColour { red, blue };
inline constexpr std::array<std::string_view, 2> choices(SpotColour) { return {"red", "blue"}; }

struct SpotOption {
  double x = 0, z = 0;
  SpotColour colour = SpotColour::red;
  void declare(OptionVisitor& visit) {
    visit("x", x, "where", {.unit = "m"});
    visit("z", z, "where", {.unit = "m"});
    visit("colour", colour, "what it looks like");
  }
};

/// Gives the same elements at every tick, off by normal errors of sd `scatter`, and says that these
/// have an sd of `std`; with `shared_shift`, all off by one more error, which follows from the
/// seed, too, and is not said. A fault at ticks of `lost`.
class SetReading final : public Module {
 public:
  static constexpr std::string_view name = "set_reading";
  static constexpr std::string_view description = "hand-made elements";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static constexpr std::array faults = {FaultKind::no_detection};
  template <typename T>
  struct Parameters {
    T scatter, std;
    static constexpr std::string_view name = "set_reading_parameters";
    static constexpr auto fields =
        Fields{{"scatter", "m", "of the errors", 0}, {"std", "m", "that is stated", 0}};
  };
  struct Options {
    std::vector<PieceOption> pieces;
    std::vector<SpotOption> spots;
    double shared_shift = 0;
    std::vector<std::int64_t> lost;
    std::string frame = "here";
    void declare(OptionVisitor& visit) {
      visit("pieces", pieces, "elements");
      visit("spots", spots, "elements");
      visit("shared_shift", shared_shift, "sd of an error of all", {.unit = "m"});
      visit("lost", lost, "ticks without an output");
      visit("frame", frame, "the frame");
    }
  };
  static Interface interface(const Options& options) {
    return {.inputs = {},
            .output = &descriptor<Findings>(),
            .frame = options.frame,
            .draws_readings = true};
  }
  explicit SetReading(Options options) : options_(std::move(options)) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    for (const std::int64_t lost : options_.lost)
      if (lost == evaluation.tick) return Fault{FaultKind::no_detection, "lost"};
    RandomBits random = evaluation.random();
    const double shift = options_.shared_shift * draw_normal(random);
    const auto p = payload_of<Parameters>(evaluation.parameters);
    output.elements.clear();
    std::uint32_t column = 0;
    const auto finish = [&](std::size_t noisy) {
      Estimate& element = output.elements.back();
      for (std::size_t c = 0; c < noisy; ++c) {
        element.value[c] += shift + p.scatter * draw_normal(random);
        if (p.std > 0) element.lineage.add(evaluation.fresh(column++), c, p.std);
      }
    };
    for (const PieceOption& piece : options_.pieces) {
      output.elements.push_back(Estimate(descriptor<Piece>(), output.estimate.frame));
      assign<Piece>(output.elements.back(),
                    {piece.position, piece.slope, static_cast<double>(piece.first),
                     static_cast<double>(piece.last)});
      finish(2);
    }
    for (const SpotOption& spot : options_.spots) {
      output.elements.push_back(Estimate(descriptor<Spot>(), output.estimate.frame));
      assign<Spot>(output.elements.back(), {spot.x, spot.z, {static_cast<int>(spot.colour)}});
      finish(2);
    }
    assign<Findings>(output.estimate, {static_cast<double>(output.elements.size())});
    return {};
  }

 private:
  Options options_;
};

inline const Registry& set_registry() {
  static const Registry* const all = [] {
    auto* made = new Registry;
    made->add<SetReading>();
    return made;
  }();
  return *all;
}

}  // namespace ilss::test
