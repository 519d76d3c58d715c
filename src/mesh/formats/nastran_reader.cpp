#include "mesh/formats/nastran_reader.hpp"

#include "base/text.hpp"
#include "mesh/element_type.hpp"
#include "mesh/formats/line_reader.hpp"
#include "mesh/formats/mesh_assembly.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <unordered_set>

namespace pliant {
namespace {

/// Element types by the names of their cards: with corner nodes only, and with all nodes of second order (0: none).
struct NastranKind {
  int type;
  int second_order;
};
const std::map<std::string, NastranKind> nastran_kinds{
    {"CTETRA", {4, 11}}, {"CHEXA", {5, 17}}, {"CPENTA", {6, 18}}, {"CPYRAM", {7, 19}}, {"CTRIA3", {2, 0}},
    {"CTRIAR", {2, 0}},  {"CTRIA6", {9, 0}}, {"CBAR", {1, 0}},    {"CBEAM", {1, 0}},   {"CROD", {1, 0}}};

/// Fields that only shells and bars have, behind the nodes, do not count.
bool is_solid(const NastranKind& kind) {
  return element_types[static_cast<std::size_t>(kind.type)].dimension == 3;
}

/// The fields of a card: its name, then values, without blanks around them.
struct NastranCard {
  std::vector<std::string> fields;
  std::size_t line = 0;
};

class NastranFile {
 public:
  explicit NastranFile(const std::string& file) : in_(file) {}
  SerialMesh read();

 private:
  bool next_line();
  bool next_card(NastranCard& card);
  bool is_continuation() const;
  void append_fields(NastranCard& card);
  void read_card(const NastranCard& card);
  void read_node(const NastranCard& card);
  void read_element(const NastranCard& card, const NastranKind& kind);
  std::int64_t integer(const NastranCard& card, std::size_t field, const char* what) const;
  double coordinate(const NastranCard& card, std::size_t field) const;

  LineReader in_;
  MeshAssembly mesh_;
  std::unordered_set<std::size_t> nodes_, elements_;
  std::map<std::string, std::size_t> others_;  // elements that are left out
  std::string line_;                           // without comment
  bool is_waiting_ = false;
};

bool NastranFile::next_line() {
  if (is_waiting_) {
    is_waiting_ = false;
    return true;
  }
  while (in_.next()) {
    line_ = in_.text().substr(0, in_.text().find('$'));
    if (!trimmed(line_).empty()) return true;
  }
  return false;
}

bool NastranFile::is_continuation() const {
  return line_[0] == '+' || line_[0] == '*' || line_[0] == ' ' || line_[0] == ',' || line_[0] == '\t';
}

/// The fields of the current line: 8 columns each, or 16 where the first ends with '*', or between commas. The first,
/// and the tenth of a continued line, are not values.
void NastranFile::append_fields(NastranCard& card) {
  const bool is_free = line_.find(',') != std::string::npos;
  std::vector<std::string> all;
  if (is_free) {
    for (std::size_t at = 0; at <= line_.size();) {
      const std::size_t end = std::min(line_.find(',', at), line_.size());
      all.emplace_back(trimmed(std::string_view(line_).substr(at, end - at)));
      at = end + 1;
    }
  } else {
    const std::string_view line = line_;
    const std::size_t width = line.substr(0, 8).find('*') != std::string_view::npos ? 16 : 8;
    all.emplace_back(trimmed(line.substr(0, 8)));
    for (std::size_t at = 8; at < std::min<std::size_t>(line.size(), 72); at += width) {
      all.emplace_back(trimmed(line.substr(at, std::min(width, 72 - at))));
    }
  }
  const std::size_t num_values = !all.empty() && all[0].find('*') != std::string::npos ? 4 : 8;
  all.resize(num_values + 1);  // blank fields count
  card.fields.insert(card.fields.end(), all.begin() + (card.fields.empty() ? 0 : 1), all.end());
}

bool NastranFile::next_card(NastranCard& card) {
  if (!next_line()) return false;
  card = {{}, in_.number()};
  append_fields(card);
  std::string& name = card.fields.front();
  name = in_capitals(name.substr(0, name.find('*')));
  constexpr std::size_t most_fields = 200;  // of no card of interest
  while (next_line()) {
    if (!is_continuation()) {
      is_waiting_ = true;
      break;
    }
    if (card.fields.size() < most_fields) append_fields(card);
  }
  return true;
}

std::int64_t NastranFile::integer(const NastranCard& card, std::size_t field, const char* what) const {
  const std::string text = field < card.fields.size() ? card.fields[field] : "";
  const auto value = integer_in(text);
  if (!value || *value < 1)
    in_.fail(card.line, std::string(what) + " is expected in field " + std::to_string(field + 1) + " of " +
                            card.fields[0] + ", not " + in_quotes(text));
  return *value;
}

/// Nastran's real numbers may lack the letter of the exponent: 1.5-3. A blank is 0.
double NastranFile::coordinate(const NastranCard& card, std::size_t field) const {
  std::string text = field < card.fields.size() ? card.fields[field] : "";
  if (text.empty()) return 0.0;
  const std::string shown = text;
  const std::size_t sign = text.find_last_of("+-");
  if (sign != std::string::npos && sign > 0 && text.find_first_of("eEdD") == std::string::npos) text.insert(sign, "e");
  const auto value = real_in(text);
  if (!value)
    in_.fail(card.line,
             "a coordinate is expected in field " + std::to_string(field + 1) + " of GRID, not " + in_quotes(shown));
  return *value;
}

void NastranFile::read_node(const NastranCard& card) {
  const auto tag = static_cast<std::size_t>(integer(card, 1, "the number of a node"));
  if (const std::string& system = card.fields[2]; !system.empty() && system != "0") {
    in_.fail(card.line, "node " + std::to_string(tag) + " is in the coordinate system " + in_quotes(system) +
                            ", which is not supported: write all nodes in the basic system");
  }
  if (!nodes_.insert(tag).second) {
    in_.fail(card.line, "node " + std::to_string(tag) + " is defined twice: give every node its own number");
  }
  mesh_.add_node(tag, {coordinate(card, 3), coordinate(card, 4), coordinate(card, 5)});
}

void NastranFile::read_element(const NastranCard& card, const NastranKind& kind) {
  const auto tag = static_cast<std::size_t>(integer(card, 1, "the number of an element"));
  const std::int64_t property = card.fields[2].empty() ? static_cast<std::int64_t>(tag)  // Nastran's default
                                                       : integer(card, 2, "the number of a property");
  const auto size_of = [](int type) {
    return static_cast<std::size_t>(element_types[static_cast<std::size_t>(type)].num_nodes);
  };
  std::size_t last = std::min(card.fields.size(), 3 + size_of(kind.second_order != 0 ? kind.second_order : kind.type));
  while (last > 3 && card.fields[last - 1].empty()) --last;
  const bool is_second = kind.second_order != 0 && last > 3 + size_of(kind.type);
  const int type = is_second ? kind.second_order : kind.type;
  if (last != 3 + size_of(type) && (is_solid(kind) || last < 3 + size_of(type))) {
    in_.fail(card.line, card.fields[0] + " " + std::to_string(tag) + " has " + std::to_string(last - 3) + " nodes: a " +
                            element_types[static_cast<std::size_t>(type)].name + " needs " +
                            std::to_string(size_of(type)));
  }
  std::vector<std::size_t> nodes;
  for (std::size_t f = 3; f < 3 + size_of(type); ++f) {
    nodes.push_back(static_cast<std::size_t>(integer(card, f, "a node of an element (none of them may be left out)")));
  }
  if (type == tetrahedron_10) swap_last_two(nodes);
  if (!elements_.insert(tag).second) {
    in_.fail(card.line, "element " + std::to_string(tag) + " is defined twice: give every element its own number");
  }
  const std::size_t index = mesh_.add_element(type, tag, nodes, card.line);
  if (property < INT32_MAX) mesh_.put_element(index, static_cast<int>(property));
}

void NastranFile::read_card(const NastranCard& card) {
  const std::string& name = card.fields[0];
  const auto kind = nastran_kinds.find(name);
  if (name == "GRID") {
    read_node(card);
  } else if (kind != nastran_kinds.end()) {
    read_element(card, kind->second);
  } else if (name.starts_with("INCLUDE")) {
    in_.fail(card.line, "INCLUDE is not supported: write the mesh into one file");
  } else if (name.starts_with("CQUAD") || name.starts_with("CTRI") || name.starts_with("CSHEAR") || name == "CTUBE" ||
             name == "CBUSH" || name.starts_with("CELAS")) {
    ++others_[name];
  }
}

SerialMesh NastranFile::read() {
  NastranCard card;
  while (next_card(card)) {
    if (card.fields[0] == "ENDDATA") break;
    read_card(card);
  }
  if (nodes_.empty()) in_.fail("the file ends without nodes (GRID): it is not bulk data of Nastran, or truncated");
  if (card.fields[0] != "ENDDATA") in_.fail("the file ends without ENDDATA: it is truncated; write or copy it again");
  std::string types;
  for (const auto& [name, count] : others_) types += (types.empty() ? "" : ", ") + std::to_string(count) + " " + name;
  if (!types.empty()) mesh_.add_notice("elements that are not tetrahedra were left out: " + types);
  return mesh_.finish([this](std::size_t line) { return in_.place(line); });
}

}  // namespace

SerialMesh read_nastran(const std::string& file) {
  return NastranFile(file).read();
}

}  // namespace pliant
