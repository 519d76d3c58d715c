#include "mesh/formats/unv_reader.hpp"

#include "base/text.hpp"
#include "mesh/element_type.hpp"
#include "mesh/formats/line_reader.hpp"
#include "mesh/formats/mesh_assembly.hpp"
#include "mesh/source_checks.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <sstream>
#include <unordered_map>
#include <unordered_set>

namespace pliant {
namespace {

/// gmsh's element type by the number of I-DEAS (fe descriptor), and whether a record of beams precedes the nodes.
struct UnvKind {
  int type;
  bool is_beam;
};
const std::map<std::int64_t, UnvKind> unv_kinds{
    {11, {1, true}},   {21, {1, true}},    {22, {8, true}},   {24, {8, true}},   {41, {2, false}},  {51, {2, false}},
    {61, {2, false}},  {74, {2, false}},   {91, {2, false}},  {42, {9, false}},  {52, {9, false}},  {62, {9, false}},
    {72, {9, false}},  {92, {9, false}},   {44, {3, false}},  {54, {3, false}},  {64, {3, false}},  {84, {3, false}},
    {94, {3, false}},  {45, {16, false}},  {55, {16, false}}, {95, {16, false}}, {111, {4, false}}, {118, {11, false}},
    {112, {6, false}}, {113, {18, false}}, {115, {5, false}}, {116, {17, false}}};

/// The nodes of a tetrahedron of second order follow its outline: corners and middles in turn around the base, the
/// three middles of the edges to the apex, the apex. gmsh's order:
constexpr std::array<std::size_t, 10> unv_tetrahedron{0, 2, 4, 9, 1, 3, 5, 6, 8, 7};
constexpr std::array<std::size_t, 6> unv_triangle{0, 2, 4, 1, 3, 5};
constexpr std::array<std::size_t, 3> unv_line{0, 2, 1};

struct UnvMember {
  std::int64_t kind;  // 7: node, 8: element
  std::size_t tag;
  std::size_t line;
};

class UnvFile {
 public:
  explicit UnvFile(const std::string& file) : in_(file) {}
  SerialMesh read();

 private:
  bool next_line();
  bool at_end() const { return trimmed(in_.text()) == "-1"; }
  void needed_line(const char* what);
  std::vector<std::int64_t> integers(std::size_t least, const char* what);
  void skip();
  void read_unit();
  void read_nodes(bool in_one_line);
  void read_elements();
  void read_groups(std::size_t numbers_each);
  int free_number(std::int64_t wanted) const;
  void read_members(int set, std::int64_t count, std::size_t numbers_each);
  std::size_t positive(std::int64_t number, const char* what) const;
  void assign_groups();

  LineReader in_;
  MeshAssembly mesh_;
  std::unordered_set<std::size_t> nodes_;
  std::unordered_map<std::size_t, std::size_t> elements_;  // index by tag
  std::vector<std::pair<std::size_t, int>> properties_;    // of the elements
  std::map<std::string, int> groups_;                      // by name
  std::vector<std::pair<int, UnvMember>> members_;
  std::map<std::int64_t, std::size_t> others_;  // elements that are left out
  static constexpr std::size_t left_out = static_cast<std::size_t>(-1);
};

bool UnvFile::next_line() {
  return in_.next();
}

void UnvFile::needed_line(const char* what) {
  if (!next_line()) {
    in_.fail(std::string("the file ends where ") + what + " is expected: it is truncated; write or copy it again");
  }
}

/// The numbers of the current line.
std::vector<std::int64_t> UnvFile::integers(std::size_t least, const char* what) {
  std::vector<std::int64_t> numbers;
  std::istringstream words{std::string(in_.text())};
  for (std::string word; words >> word;) {
    const auto number = integer_in(word);
    if (!number) in_.fail(std::string(what) + " is expected here, not " + in_quotes(word));
    numbers.push_back(*number);
  }
  if (numbers.size() < least) in_.fail(std::string(what) + " needs " + std::to_string(least) + " numbers in this line");
  return numbers;
}

std::size_t UnvFile::positive(std::int64_t number, const char* what) const {
  if (number < 1) in_.fail(std::string(what) + " must be a positive number, not " + std::to_string(number));
  return static_cast<std::size_t>(number);
}

void UnvFile::skip() {
  do {
    needed_line("the end of a dataset (-1)");
  } while (!at_end());
}

/// Notes units of length other than the metre. They are not converted, as those of other formats are not.
void UnvFile::read_unit() {
  struct Unit {
    std::int64_t code;
    const char* name;
    const char* scale;
  };
  static constexpr std::array<Unit, 6> units{{{2, "feet", "0.3048"},
                                              {4, "feet", "0.3048"},
                                              {5, "millimetres", "0.001"},
                                              {6, "centimetres", "0.01"},
                                              {7, "inches", "0.0254"},
                                              {8, "millimetres", "0.001"}}};
  needed_line("the unit of length");
  const auto code = integer_in(trimmed(in_.text().substr(0, 10)));
  for (const Unit& unit : units) {
    if (code != unit.code) continue;
    mesh_.add_notice(std::string("the file says that its lengths are ") + unit.name +
                     ": metres need 'scale: " + unit.scale + "'");
  }
  if (!at_end()) skip();
}

void UnvFile::read_nodes(bool in_one_line) {
  for (needed_line("a node"); !at_end(); needed_line("a node")) {
    std::istringstream words{std::string(in_.text())};
    std::string word;
    words >> word;
    const auto tag = positive(integer_in(word).value_or(0), "the number of a node");
    for (int i = 0; in_one_line && i < 3; ++i) words >> word;  // coordinate systems, colour
    if (!in_one_line) {
      needed_line("the position of a node");
      words = std::istringstream{std::string(in_.text())};
    }
    std::array<double, 3> position{};
    for (double& x : position) {
      word.clear();
      words >> word;
      const auto value = real_in(word);
      if (!value) in_.fail("a coordinate is expected here, not " + in_quotes(word));
      x = *value;
    }
    if (!nodes_.insert(tag).second) {
      in_.fail("node " + std::to_string(tag) + " is defined twice: give every node its own number");
    }
    mesh_.add_node(tag, position);
  }
}

template <std::size_t n>
std::vector<std::size_t> in_order(const std::vector<std::size_t>& nodes, const std::array<std::size_t, n>& order) {
  std::vector<std::size_t> result;
  for (const std::size_t i : order) result.push_back(nodes[i]);
  return result;
}

void UnvFile::read_elements() {
  for (needed_line("an element"); !at_end(); needed_line("an element")) {
    const std::size_t line = in_.number();
    const auto head = integers(6, "an element");
    const std::size_t tag = positive(head[0], "the number of an element");
    const std::size_t num_nodes = positive(head[5], "the number of nodes of an element");
    const auto kind = unv_kinds.find(head[1]);
    if (kind != unv_kinds.end() ? kind->second.is_beam : head[1] == 23) needed_line("the record of a beam");
    std::vector<std::size_t> nodes;
    while (nodes.size() < num_nodes) {
      needed_line("a node of an element");
      for (const std::int64_t node : integers(1, "a node of an element")) nodes.push_back(positive(node, "a node"));
    }
    const auto add = [&](std::size_t index) {
      if (elements_.try_emplace(tag, index).second) return;
      in_.fail(line, "element " + std::to_string(tag) + " is defined twice: give every element its own number");
    };
    if (kind == unv_kinds.end()) {
      ++others_[head[1]];
      add(left_out);
      continue;
    }
    const int type = kind->second.type;
    const auto& known = element_types[static_cast<std::size_t>(type)];
    if (nodes.size() != static_cast<std::size_t>(known.num_nodes)) {
      in_.fail(line, std::string("a ") + known.name + " has " + std::to_string(known.num_nodes) + " nodes, not " +
                         std::to_string(nodes.size()));
    }
    if (type == tetrahedron_10) nodes = in_order(nodes, unv_tetrahedron);
    if (type == 9) nodes = in_order(nodes, unv_triangle);
    if (type == 8) nodes = in_order(nodes, unv_line);
    const std::size_t index = mesh_.add_element(type, tag, nodes, line);
    add(index);
    if (head[2] > 0 && head[2] < INT32_MAX) properties_.emplace_back(index, static_cast<int>(head[2]));
  }
}

void UnvFile::read_members(int set, std::int64_t count, std::size_t numbers_each) {
  for (std::int64_t done = 0; done < count;) {
    needed_line("a member of a group");
    if (at_end()) in_.fail("the dataset ends within a group: the file is damaged; write or copy it again");
    const auto numbers = integers(numbers_each, "a member of a group");
    for (std::size_t i = 0; i + numbers_each <= numbers.size() && done < count; i += numbers_each, ++done) {
      members_.push_back({set, {numbers[i], positive(numbers[i + 1], "a member of a group"), in_.number()}});
    }
  }
}

/// The group's number in the file, or another one if a group has that already, or if it is not above 0.
int UnvFile::free_number(std::int64_t wanted) const {
  const auto is_used = [&](int number) {
    return std::ranges::any_of(groups_, [&](const auto& group) { return group.second == number; });
  };
  int number = wanted > 0 && wanted < INT32_MAX ? static_cast<int>(wanted) : 1;
  for (std::size_t tries = 0; is_used(number) && tries <= groups_.size(); ++tries) number = 1 + static_cast<int>(tries);
  return number;
}

void UnvFile::read_groups(std::size_t numbers_each) {
  for (needed_line("a group"); !at_end(); needed_line("a group")) {
    const auto head = integers(2, "a group");
    needed_line("the name of a group");
    const std::string name(trimmed(in_.text()));
    require_plain_name(name);
    const auto [place, is_new] = groups_.try_emplace(name, free_number(head[0]));
    if (is_new) mesh_.name_set(place->second, name);
    read_members(place->second, head.back(), numbers_each);
  }
}

// gmsh lists points in groups, but does not write them as elements.
void UnvFile::assign_groups() {
  std::size_t unknown = 0;
  if (groups_.empty()) {
    for (const auto& [index, property] : properties_) mesh_.put_element(index, property);
  }
  for (const auto& [set, member] : members_) {
    if (member.kind == 7) {
      if (!nodes_.contains(member.tag)) {
        in_.fail(member.line, "a group has node " + std::to_string(member.tag) + ", which the file does not define");
      }
      mesh_.put_node(member.tag, set);
    } else if (member.kind == 8) {
      const auto found = elements_.find(member.tag);
      if (found == elements_.end()) {
        ++unknown;
        continue;
      }
      if (found->second != left_out) mesh_.put_element(found->second, set);
    }
  }
  if (unknown == 0) return;
  mesh_.add_notice("its groups have " + std::to_string(unknown) + " elements that the file does not define");
}

SerialMesh UnvFile::read() {
  while (next_line()) {
    if (trimmed(in_.text()).empty()) continue;
    if (!at_end())
      in_.fail("a dataset, which begins with -1, is expected here: it is not a universal file, or damaged");
    needed_line("the number of a dataset");
    const std::string_view number = trimmed(in_.text());
    if (number == "2411" || number == "781") {
      read_nodes(false);
    } else if (number == "15") {
      read_nodes(true);
    } else if (number == "2412") {
      read_elements();
    } else if (number == "164") {
      read_unit();
    } else if (number == "780" || number == "71") {
      in_.fail("elements of the old dataset " + std::string(number) + " are not supported: write them as dataset 2412");
    } else if (number == "2429" || number == "2430" || number == "2432") {
      read_groups(2);
    } else if (number == "2435" || number == "2452" || number == "2467" || number == "2477") {
      read_groups(4);
    } else {
      skip();
    }
  }
  std::string types;
  for (const auto& [kind, count] : others_) {
    types += (types.empty() ? "" : ", ") + std::to_string(count) + " of type " + std::to_string(kind);
  }
  if (!types.empty()) mesh_.add_notice("elements that are not tetrahedra were left out: " + types);
  assign_groups();
  return mesh_.finish([this](std::size_t line) { return in_.place(line); });
}

}  // namespace

SerialMesh read_unv(const std::string& file) {
  return UnvFile(file).read();
}

}  // namespace pliant
