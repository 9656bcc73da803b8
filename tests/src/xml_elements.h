// The elements of an XML text, read strictly: enough of XML for the pictures that ilss writes.
#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace ilss {

/// An element with its attributes and its own text, in the order in which elements begin.
struct XmlElement {
  std::string name;
  std::map<std::string, std::string> attributes;
  std::string text;
};

/// Reads the elements. @throws std::runtime_error where the text is not well-formed: tags that do
/// not match, attributes given twice or not quoted, a bare & or <, anything behind the root.
class XmlReader {
 public:
  explicit XmlReader(const std::string& text) : text_(text) {}

  std::vector<XmlElement> read() {
    skip_blanks();
    read_element();
    skip_blanks();
    if (at_ != text_.size()) fail("something stands behind the root");
    return std::move(elements_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(what + " at offset " + std::to_string(at_));
  }
  bool starts_with(const std::string& what) const {
    return text_.compare(at_, what.size(), what) == 0;
  }
  void skip_blanks() {
    while (at_ < text_.size() && std::string(" \n").find(text_[at_]) != std::string::npos) ++at_;
  }
  void expect(const std::string& what) {
    if (!starts_with(what)) fail("expected " + what);
    at_ += what.size();
  }
  std::string read_name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() &&
           (std::isalnum(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == '-'))
      ++at_;
    if (at_ == begin) fail("expected a name");
    return text_.substr(begin, at_ - begin);
  }
  /// Characters up to `end`, entities resolved.
  std::string read_characters(char end) {
    std::string result;
    while (at_ < text_.size() && text_[at_] != end) {
      if (text_[at_] == '<') fail("a bare <");
      if (text_[at_] != '&') {
        result += text_[at_++];
        continue;
      }
      const std::map<std::string, char> entities = {
          {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}};
      const std::string entity = text_.substr(at_, text_.find(';', at_) + 1 - at_);
      const auto found = entities.find(entity);
      if (found == entities.end()) fail("a bare &");
      result += found->second;
      at_ += entity.size();
    }
    return result;
  }
  void read_element() {
    expect("<");
    const std::size_t index = elements_.size();
    elements_.emplace_back();
    const std::string name = read_name();
    elements_[index].name = name;
    skip_blanks();
    while (!starts_with(">") && !starts_with("/>")) {
      const std::string key = read_name();
      expect("=\"");
      if (!elements_[index].attributes.emplace(key, read_characters('"')).second)
        fail("attribute " + key + " stands twice");
      expect("\"");
      skip_blanks();
    }
    if (starts_with("/>")) {
      at_ += 2;
      return;
    }
    expect(">");
    elements_[index].text += read_characters('<');
    while (!starts_with("</")) {
      read_element();
      elements_[index].text += read_characters('<');
    }
    expect("</" + name + ">");
  }

  const std::string& text_;
  std::size_t at_ = 0;
  std::vector<XmlElement> elements_;
};

}  // namespace ilss
