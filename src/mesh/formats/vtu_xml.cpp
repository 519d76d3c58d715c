#include "mesh/formats/vtu_xml.hpp"

#include "mesh/formats/line_reader.hpp"
#include "mesh/serial_mesh.hpp"

#include <algorithm>
#include <array>
#include <cctype>

namespace pliant {
namespace {

std::string without_entities(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, char>, 5> entities{
      {{"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}}};
  std::string plain;
  while (!text.empty()) {
    const auto entity = std::ranges::find_if(entities, [&](const auto& e) { return text.starts_with(e.first); });
    const bool is_entity = entity != entities.end();
    plain += is_entity ? entity->second : text.front();
    text.remove_prefix(is_entity ? entity->first.size() : 1);
  }
  return plain;
}

class XmlParser {
 public:
  explicit XmlParser(std::string_view bytes) : bytes_(bytes) {}

  XmlDocument parse() {
    while (!is_done_ && next_tag()) {
    }
    if (document_.elements.empty()) fail("this is not XML");
    if (!is_done_ && !open_.empty()) {
      fail("the file ends within <" + document_.elements[open_.back()].name +
           ">: it is truncated; write or copy it again");
    }
    return std::move(document_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) {
    throw MeshDefect("line " + std::to_string(line_at(std::min(at_, bytes_.size()))) + ": " + message);
  }

  std::size_t line_at(std::size_t at) {
    line_ += static_cast<std::size_t>(std::count(bytes_.begin() + static_cast<std::ptrdiff_t>(counted_),
                                                 bytes_.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
    counted_ = at;
    return line_;
  }

  void skip_past(std::string_view end) {
    const std::size_t found = bytes_.find(end, at_);
    if (found == std::string_view::npos)
      fail("the file ends before " + in_quotes(end) + ": it is truncated or damaged");
    at_ = found + end.size();
  }

  /// Reads to the end of the next tag; false behind the last one.
  bool next_tag() {
    const std::size_t begin = std::min(bytes_.find('<', at_), bytes_.size());
    if (!open_.empty() && document_.elements[open_.back()].children.empty()) {
      document_.elements[open_.back()].text = bytes_.substr(at_, begin - at_);
    }
    at_ = begin;
    if (at_ == bytes_.size()) return false;
    const std::string_view rest = bytes_.substr(at_);
    if (rest.starts_with("<!--")) {
      skip_past("-->");
    } else if (rest.starts_with("<?")) {
      skip_past("?>");
    } else if (rest.starts_with("<!")) {
      skip_past(">");
    } else if (rest.starts_with("</")) {
      close();
    } else {
      open();
    }
    return true;
  }

  void close() {
    at_ += 2;
    const std::string name = word();
    if (open_.empty() || document_.elements[open_.back()].name != name) {
      fail("</" + name + "> closes nothing: the file is damaged; write or copy it again");
    }
    skip_past(">");
    open_.pop_back();
  }

  std::string word() {
    const std::size_t begin = at_;
    const auto is_part = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == ':' || c == '-' || c == '.';
    };
    while (at_ < bytes_.size() && is_part(bytes_[at_])) ++at_;
    if (at_ == bytes_.size()) fail("the file ends within a tag: it is truncated; write or copy it again");
    if (at_ == begin) fail("a name is expected after '<' or between the attributes: the file is damaged");
    constexpr std::size_t longest = 100;
    return std::string(bytes_.substr(begin, std::min(at_ - begin, longest)));
  }

  void skip_blanks() {
    while (at_ < bytes_.size() && std::isspace(static_cast<unsigned char>(bytes_[at_])) != 0) ++at_;
  }

  bool take(std::string_view text) {
    if (!bytes_.substr(std::min(at_, bytes_.size())).starts_with(text)) return false;
    at_ += text.size();
    return true;
  }

  void open() {
    XmlElement element;
    element.line = line_at(at_);
    ++at_;
    element.name = word();
    bool is_empty = false;
    for (skip_blanks(); !take(">"); skip_blanks()) {
      is_empty = take("/>");
      if (is_empty) break;
      read_attribute(element);
    }
    const std::size_t index = document_.elements.size();
    if (open_.empty() && index > 0) fail("there is a second root <" + element.name + ">: the file is damaged");
    if (!open_.empty()) document_.elements[open_.back()].children.push_back(index);
    const bool is_appended = element.name == "AppendedData" && !is_empty;
    document_.elements.push_back(std::move(element));
    constexpr std::size_t deepest = 100;
    if (open_.size() > deepest) fail("elements of XML are nested endlessly");
    if (!is_empty) open_.push_back(index);
    if (!is_appended) return;
    skip_past("_");
    document_.appended = bytes_.substr(at_);
    is_done_ = true;
  }

  void read_attribute(XmlElement& element) {
    const std::string key = word();
    skip_blanks();
    if (!take("=")) fail("'=' is expected after the attribute " + key);
    skip_blanks();
    const bool is_double = take("\"");
    if (!is_double && !take("'")) fail("the value of the attribute " + key + " is expected in quotes");
    const std::size_t begin = at_;
    skip_past(is_double ? "\"" : "'");
    element.attributes[key] = without_entities(bytes_.substr(begin, at_ - begin - 1));
  }

  std::string_view bytes_;
  std::size_t at_ = 0, counted_ = 0, line_ = 1;
  std::vector<std::size_t> open_;
  bool is_done_ = false;
  XmlDocument document_;
};

}  // namespace

std::string XmlElement::attribute(const std::string& key) const {
  const auto found = attributes.find(key);
  return found == attributes.end() ? "" : found->second;
}

std::vector<const XmlElement*> XmlDocument::children(const XmlElement& parent, std::string_view name) const {
  std::vector<const XmlElement*> result;
  for (const std::size_t child : parent.children) {
    if (elements[child].name == name) result.push_back(&elements[child]);
  }
  return result;
}

XmlDocument parse_xml(std::string_view bytes) {
  return XmlParser(bytes).parse();
}

}  // namespace pliant
