// YAML documents: positions, and all that can be wrong with a file.
#include "framework/module/document.h"

#include <gtest/gtest.h>

#include <fstream>

namespace ilss {
namespace {

using namespace std::string_literals;

struct Read {
  Node root;
  std::vector<std::string> messages;
};

Read read(std::string_view text) {
  Diagnostics diagnostics;
  Read result{parse_document(text, "f.yaml", diagnostics), {}};
  for (const Diagnostic& d : diagnostics.sorted()) result.messages.push_back(format_diagnostic(d));
  return result;
}

std::string place(const Node& node) {
  return std::to_string(node.position.line) + ":" + std::to_string(node.position.column);
}

using Messages = std::vector<std::string>;

TEST(Document, KnowsWhereEveryValueStands) {
  const Read r = read("a: 1\nb:\n  c: [x, {d: y}]\n");
  EXPECT_EQ(r.messages, Messages{});
  EXPECT_EQ(place(r.root.keys[1]), "2:1");
  const Node* c = r.root.find("b")->find("c");
  ASSERT_NE(c, nullptr);
  EXPECT_EQ(place(*c), "3:6");
  EXPECT_EQ(place(c->values[0]), "3:7");
  EXPECT_EQ(place(*c->values[1].find("d")), "3:14");
  EXPECT_EQ(*c->position.file, "f.yaml");
  EXPECT_EQ(r.root.find("nothing"), nullptr);
}

TEST(Document, AliasStandsWhereItIsWritten) {
  const Read r = read("a: &here [1, 2]\nb: *here\n");
  EXPECT_EQ(r.messages, Messages{});
  EXPECT_EQ(place(*r.root.find("b")), "2:4");
  EXPECT_EQ(r.root.find("b")->size(), 2u);
}

TEST(Document, TellsScalarsThatAreQuoted) {
  const Read r = read("a: '1'\nb: 1\nc: ~\nd: '~'\ne:\nf: null\ng: ''\n");
  EXPECT_TRUE(r.root.find("a")->quoted);
  EXPECT_FALSE(r.root.find("b")->quoted);
  EXPECT_TRUE(r.root.find("c")->is_null());
  EXPECT_EQ(r.root.find("d")->text, "~");
  EXPECT_TRUE(r.root.find("e")->is_null());
  EXPECT_TRUE(r.root.find("f")->is_null());
  EXPECT_TRUE(r.root.find("g")->is_scalar());
}

TEST(Document, ReportsEveryDuplicateKeyAndKeepsTheFirst) {
  const Read r = read("a: 1\nb: 2\na: 3\nb: {x: 1, x: 2}\n");
  EXPECT_EQ(r.messages, (Messages{"f.yaml:3:1: duplicate key 'a'; first given in line 1",
                                  "f.yaml:4:1: duplicate key 'b'; first given in line 2",
                                  "f.yaml:4:11: duplicate key 'x'; first given in line 4"}));
  EXPECT_EQ(r.root.find("a")->text, "1");
  EXPECT_EQ(r.root.find("b")->text, "2");
}

TEST(Document, FindsDuplicatesAmongManyKeys) {
  std::string text;
  for (int i = 0; i < 100; ++i) text += "k" + std::to_string(i) + ": 0\n";
  EXPECT_EQ(read(text + "k3: 1\nk99: 1\n").messages,
            (Messages{"f.yaml:101:1: duplicate key 'k3'; first given in line 4",
                      "f.yaml:102:1: duplicate key 'k99'; first given in line 100"}));
}

TEST(Document, RefusesKeysThatAreNotWords) {
  EXPECT_EQ(read("? [a, b]\n: 1\n? {c: d}\n: 2\n~: 3\n").messages,
            (Messages{"f.yaml:1:3: a key must be a word, not a list",
                      "f.yaml:3:3: a key must be a word, not a map",
                      "f.yaml:5:1: a key must be a word, not nothing"}));
}

TEST(Document, RefusesAnchorsThatReferToThemselves) {
  EXPECT_EQ(read("a: &x [1, *x]\n").messages,
            (Messages{"f.yaml:1:11: an alias cannot stand inside the value its anchor names"}));
  EXPECT_EQ(read("a: &x {b: {c: *x}}\nd: &y [&z [*y]]\n").messages.size(), 2u);
}

TEST(Document, ReportsUnknownAnchors) {
  const Read r = read("a: *nowhere\n");
  ASSERT_EQ(r.messages.size(), 1u);
  EXPECT_EQ(r.messages[0].substr(0, 25), "f.yaml:1:4: YAML syntax: ");
}

TEST(Document, StopsWhatUnfoldsWithoutEnd) {
  std::string text = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string alias = "*a" + std::to_string(i - 1);
    text += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [";
    for (int k = 0; k < 9; ++k) text += alias + ", ";
    text += alias + "]\n";
  }
  const Read r = read(text);
  ASSERT_EQ(r.messages.size(), 1u);
  EXPECT_NE(r.messages[0].find("the document unfolds to more than 1000000 values"),
            std::string::npos);
}

TEST(Document, StopsAtNestingThatIsTooDeep) {
  EXPECT_EQ(read(std::string(200, '[') + std::string(200, ']')).messages, Messages{});
  EXPECT_EQ(read(std::string(201, '[') + std::string(201, ']')).messages,
            (Messages{"f.yaml:1:201: nested deeper than 200 levels"}));
  EXPECT_EQ(read(std::string(100'000, '[')).messages.size(), 1u);
  EXPECT_EQ(read(std::string(100'000, '{')).messages.size(), 1u);
}

TEST(Document, CountsTheDepthThatAliasesHide) {
  std::string text;
  std::string inner = "x";
  for (int i = 0; i < 50; ++i) {
    const std::string name = "a" + std::to_string(i);
    text +=
        name + ": &" + name + " " + std::string(150, '[') + inner + std::string(150, ']') + "\n";
    inner = "*" + name;
  }
  EXPECT_EQ(read(text).messages, (Messages{"f.yaml:2:159: nested deeper than 200 levels"}));
}

TEST(Document, GivesSyntaxErrorsTheirPlace) {
  const Read r = read("a: 1\nb: [1, 2\nc: 3\n");
  ASSERT_EQ(r.messages.size(), 1u);
  EXPECT_EQ(r.messages[0].substr(0, 9), "f.yaml:3:");
  EXPECT_NE(r.messages[0].find("YAML syntax: "), std::string::npos);
  EXPECT_TRUE(r.root.is_null());
}

TEST(Document, TakesTabsForIndentationAsSyntaxErrors) {
  const Read r = read("a:\n\tb: 1\n");
  ASSERT_EQ(r.messages.size(), 1u);
  EXPECT_EQ(r.messages[0].substr(0, 9), "f.yaml:2:");
}

TEST(Document, ReadsWindowsLineEndsAndByteOrderMarks) {
  const Read r = read(
      "\xef\xbb\xbf"
      "a: 1\r\nb: x y\r\n");
  EXPECT_EQ(r.messages, Messages{});
  EXPECT_EQ(r.root.find("a")->text, "1");
  EXPECT_EQ(r.root.find("b")->text, "x y");
  EXPECT_EQ(place(*r.root.find("b")), "2:4");
}

TEST(Document, WithoutContentIsNothing) {
  for (const std::string_view text : {"", "# only a comment\n", "---\n", "\n\n"}) {
    const Read r = read(text);
    EXPECT_EQ(r.messages, Messages{}) << text;
    EXPECT_TRUE(r.root.is_null()) << text;
    ASSERT_NE(r.root.position.file, nullptr);
    EXPECT_GE(r.root.position.line, 1);
  }
}

TEST(Document, HoldsOneDocumentOnly) {
  const Read r = read("a: 1\n---\nb: 2\n");
  EXPECT_EQ(r.messages, (Messages{"f.yaml:2:1: a second document begins here; a file holds one"}));
  EXPECT_NE(r.root.find("a"), nullptr);
  EXPECT_EQ(read("---\na: 1\n...\n").messages, Messages{});
}

TEST(Document, RefusesWhatIsNotText) {
  const Messages refusal{"f.yaml:2:3: a control character; a YAML file holds text in UTF-8"};
  EXPECT_EQ(read("a: 1\nb: \x04 c: 2\n"s).messages,
            (Messages{"f.yaml:2:4: a control character; a YAML file holds text in UTF-8"}));
  EXPECT_EQ(read("a: 1\nb:\0: 2\n"s).messages, refusal);
  EXPECT_FALSE(read("\xff\xfe"
                    "a\0:\0"s)
                   .messages.empty());
  EXPECT_FALSE(read("\x7f"
                    "ELF\x02\x01\x01\x00"s)
                   .messages.empty());
}

TEST(ReadDocument, ReadsAFileThatIsEmpty) {
  const std::string path = testing::TempDir() + "/ilss_empty.yaml";
  std::ofstream(path).close();
  Diagnostics diagnostics;
  EXPECT_TRUE(read_document(path, diagnostics).is_null());
  EXPECT_TRUE(diagnostics.empty());
}

TEST(ReadDocument, ReportsFilesThatCannotBeRead) {
  Diagnostics diagnostics;
  (void)read_document("/nowhere/graph.yaml", diagnostics);
  (void)read_document("/tmp", diagnostics);
  Messages messages;
  for (const Diagnostic& d : diagnostics.sorted()) messages.push_back(format_diagnostic(d));
  EXPECT_EQ(messages, (Messages{"/nowhere/graph.yaml: the file cannot be read",
                                "/tmp: the file cannot be read"}));
}

TEST(Diagnostics, AreSortedByPlaceAndSaidOnce) {
  const std::string file = "f";
  Diagnostics d;
  d.add({&file, 2, 1}, "later");
  d.add({&file, 1, 9}, "b");
  d.add({&file, 1, 9}, "a");
  d.add({&file, 2, 1}, "later");
  Messages messages;
  for (const Diagnostic& x : d.sorted()) messages.push_back(format_diagnostic(x));
  EXPECT_EQ(messages, (Messages{"f:1:9: a", "f:1:9: b", "f:2:1: later"}));
}

TEST(Suggestion, NamesWhatIsNearlyRight) {
  const std::vector<std::string> names = {"range", "range_std", "heading", "z"};
  EXPECT_EQ(suggestion("rang", names), "; did you mean 'range'?");
  EXPECT_EQ(suggestion("rnage", names), "; did you mean 'range'?");
  EXPECT_EQ(suggestion("range_sdt", names), "; did you mean 'range_std'?");
  EXPECT_EQ(suggestion("haeding", names), "; did you mean 'heading'?");
  EXPECT_EQ(suggestion("colour", names), "");
  EXPECT_EQ(suggestion("x", names), "");
  EXPECT_EQ(suggestion("", names), "");
  EXPECT_EQ(suggestion("range", {}), "");
  EXPECT_EQ(suggestion(std::string(1'000'000, 'a'), names), "");
}

TEST(NodeDescription, IsShort) {
  Node node{Node::Kind::scalar};
  node.text = std::string(1000, 'a');
  EXPECT_EQ(node.description(), "'" + std::string(40, 'a') + "...'");
}

}  // namespace
}  // namespace ilss
