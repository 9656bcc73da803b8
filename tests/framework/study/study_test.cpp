// Study files: what is read, and that everything wrong is said in one go, where it stands.
#include "framework/study/study.h"

#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using test::Folder;
using test::messages;

struct ReadStudy {
  std::optional<Study> study;
  std::string errors;
};

/// Reads "study.yaml" out of a folder; its path is left out of the messages.
ReadStudy read(const Folder& folder, const std::string& text) {
  folder.write("study.yaml", text);
  Diagnostics diagnostics;
  ReadStudy result;
  result.study = read_study(folder.path() / "study.yaml", test::registry(), diagnostics);
  result.errors = messages(diagnostics);
  const std::string prefix = folder.path().string() + "/";
  for (std::size_t at = 0; (at = result.errors.find(prefix)) != std::string::npos;)
    result.errors.erase(at, prefix.size());
  return result;
}

const std::string recorded_study = R"(study: turns
payload: turn
requirement: {angle: 5 deg}
truth: {recorded: turns.csv, columns: {angle: {column: truth, unit: deg}, ratio: {column: ratio}}}
cases: {recorded: turns.csv, name: turn}
alternatives:
  compass: {recorded: turns.csv, columns: {angle: {column: compass, unit: deg}, ratio: {column: ratio}}}
)";
const std::string turns =
    "# an origin\nturn,truth,compass,ratio\nfirst,179,-179,0.5\n\n\"a, b\",0,,1\n";

const std::string system_study = R"(study: lengths
payload: scalar
truth: {graph: {constants: {length: 1 m}, modules: {exact: {type: reading, bias: $length, value: 0 m}}, network: exact}}
alternatives:
  tape: {graph: {constants: {length: 1 m}, modules: {tape: {type: reading, bias: $length, value: 0 m, value_std: 1 mm, noise: normal}}, network: tape}}
)";

TEST(Study, ReadsRecordedValuesInSiUnitsWithNamedCases) {
  const Folder folder;
  folder.write("turns.csv", turns);
  const ReadStudy read_back = read(folder, recorded_study);
  ASSERT_EQ(read_back.errors, "");
  const Study& study = *read_back.study;
  EXPECT_TRUE(study.recorded);
  EXPECT_EQ(study.case_noun, "turn");
  ASSERT_EQ(study.cases.size(), 2u);
  EXPECT_EQ(study.cases[1].name, "a, b");
  const auto& truth = std::get<Outcome<Estimate>>(study.cases[0].truth);
  EXPECT_NEAR(truth->value[0], 179 * std::numbers::pi / 180, 1e-12);
  EXPECT_EQ(truth->value[1], 0.5);
}

TEST(Study, EmptyCellOfARecordingIsAFaultOfThatCase) {
  const Folder folder;
  folder.write("turns.csv", turns);
  const ReadStudy read_back = read(folder, recorded_study);
  ASSERT_EQ(read_back.errors, "");
  const auto& value = std::get<Outcome<Estimate>>(read_back.study->cases[1].alternatives[0]);
  ASSERT_TRUE(value.is_fault());
  EXPECT_EQ(value.fault().kind, FaultKind::no_detection);
}

TEST(Study, CasesSetConstantsOfTruthAndAlternatives) {
  const Folder folder;
  const ReadStudy read_back = read(
      folder, system_study + "cases: [{name: near, length: 20 cm}, {name: far, length: 9 m}]\n");
  ASSERT_EQ(read_back.errors, "");
  ASSERT_EQ(read_back.study->cases.size(), 2u);
  const StudyCase& near = read_back.study->cases[0];
  EXPECT_EQ(near.name, "near");
  EXPECT_EQ(std::get<Plan>(near.truth).nodes[0].parameters.value[0], 0.2);
  EXPECT_EQ(std::get<Plan>(near.alternatives[0]).nodes[0].parameters.value[0], 0.2);
}

TEST(Study, SweepOfTwoConstantsIsTheirGridInTheUnitOfFrom) {
  const Folder folder;
  std::string text = system_study;
  for (std::size_t at = 0; (at = text.find("{length: 1 m}", at)) != std::string::npos; ++at)
    text.replace(at, 13, "{length: 1 m, other: 0 m}");
  const ReadStudy read_back = read(folder, text +
                                               "sweep: {length: {from: 0, to: 200 cm, steps: 3}, "
                                               "other: {from: -1 mm, to: 1 m, steps: 2}}\n");
  ASSERT_EQ(read_back.errors, "");
  std::vector<std::string> names;
  for (const StudyCase& one : read_back.study->cases) names.push_back(one.name);
  EXPECT_EQ(names, (std::vector<std::string>{
                       "length 0 cm, other -1 mm", "length 0 cm, other 1000 mm",
                       "length 100 cm, other -1 mm", "length 100 cm, other 1000 mm",
                       "length 200 cm, other -1 mm", "length 200 cm, other 1000 mm"}));
  EXPECT_EQ(std::get<Plan>(read_back.study->cases[2].truth).nodes[0].parameters.value[0], 1.0);
}

TEST(Study, ReportsEveryMistakeOfARecordedStudyInOneGo) {
  const Folder folder;
  folder.write("turns.csv", "turn,truth,compass,ratio\n1,x,2,3\n1,2,3\n");
  EXPECT_EQ(read(folder, R"(study: turns
payload: turn
runs: 3
requirment: {angle: 5 deg}
requirement: {angel: 5 deg, angle: 5 mm}
truth: {recorded: turns.csv, columns: {angle: {column: truth}, ratio: {column: rtio}}}
cases: {recorded: turns.csv, name: trun}
alternatives:
  compass: {recorded: turns.csv, columns: {angle: {column: compass, unit: mm}}}
  gyro: {recorded: nowhere.csv, columns: {}}
  map: {graph: {}}
  none: {}
)")
                .errors,
            "nowhere.csv: the table cannot be read\n"
            "study.yaml:3:7: 'runs' is for studies of graphs; this one compares recordings\n"
            "study.yaml:4:1: a study has no key 'requirment'; did you mean 'requirement'?\n"
            "study.yaml:5:15: turn has no key 'angel'; did you mean 'angle'?\n"
            "study.yaml:5:36: 'mm' is not an angle (rad)\n"
            "study.yaml:6:80: the recording has no column 'rtio'; did you mean 'ratio'?\n"
            "study.yaml:7:36: the recording has no column 'trun'; did you mean 'turn'?\n"
            "study.yaml:9:43: compass needs a column for turn's 'ratio'\n"
            "study.yaml:9:75: 'mm' is not an angle (rad)\n"
            "study.yaml:11:3: 'map' is a graph, but the truth is a recording; a study compares "
            "either recordings or graphs\n"
            "study.yaml:12:9: none needs either recorded: FILE or graph: {...}\n"
            "turns.csv:2:3: expected a number, got 'x'\n"
            "turns.csv:3:1: a row of 3 cells in a table of 4 columns\n");
}

TEST(Study, ReportsEveryMistakeOfASystemStudyInOneGo) {
  const Folder folder;
  EXPECT_EQ(
      read(
          folder,
          system_study +
              R"(  pair: {graph: {constants: {length: 1 m}, modules: {p: {type: pair_reading}}, network: p}}
  carried: {graph: {modules: {r: {type: reading, frame: here}, c: {type: cary}}, network: {serial: [r, c]}}}
cases:
  - {name: near, lenght: 1 m}
  - {name: near, length: 1 m}
  - {length: 1 m}
)")
          .errors,
      "study.yaml:6:3: 'pair' gives pair, but the study compares scalar\n"
      "study.yaml:7:74: unknown module type 'cary'; did you mean 'carry'?\n"
      "study.yaml:9:18: there is no constant 'lenght' in the graph of truth, tape, pair, "
      "carried; did you mean 'length'?\n"
      "study.yaml:10:12: a second case is named 'near'\n"
      "study.yaml:10:18: there is no constant 'length' in the graph of carried\n"
      "study.yaml:11:5: a case needs a name\n");
}

TEST(Study, RefusesAnAlternativeInAnotherFrameThanTheTruth) {
  const Folder folder;
  EXPECT_EQ(read(folder, R"(study: frames
payload: scalar
truth: {graph: {modules: {r: {type: reading, frame: here}}, network: r}}
alternatives:
  carried: {graph: {modules: {r: {type: reading, frame: here}, c: {type: carry}}, network: {serial: [r, c]}}}
cases: [{name: only}]
)")
                .errors,
            "study.yaml:5:3: 'carried' gives scalar in frame 'there', but the truth is in frame "
            "'here'; put a transform at its end\n");
}

TEST(Study, RefusesTheKeysOfSetsWhereNoneAreCompared) {
  const Folder folder;
  EXPECT_EQ(
      read(folder, system_study + "cases: [{name: only}]\njudge: {x: [y]}\nvalidation_gate: 3\n")
          .errors,
      "study.yaml:7:8: 'judge' is for studies of sets; scalar is no set\n"
      "study.yaml:8:18: 'validation_gate' is for studies of sets; scalar is no set\n");
}

TEST(Study, NamesTheUnknownPayload) {
  const Folder folder;
  EXPECT_EQ(read(folder, "study: s\npayload: scaler\n").errors,
            "study.yaml:2:10: no module gives a payload 'scaler'; did you mean 'scalar'?\n");
}

}  // namespace
}  // namespace ilss
