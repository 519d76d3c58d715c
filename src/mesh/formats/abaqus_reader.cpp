#include "mesh/formats/abaqus_reader.hpp"

#include "mesh/element_type.hpp"
#include "mesh/formats/abaqus_sets.hpp"

#include <algorithm>
#include <cctype>
#include <optional>

namespace pliant {
namespace {

struct AbaqusElement {
  const char* prefix;  // the rest of a name of the kind are letters
  int type;            // gmsh's
};

constexpr std::array<AbaqusElement, 28> abaqus_elements{{
    {"C3D4", tetrahedron_4},
    {"C3D10", tetrahedron_10},
    {"C3D5", 7},
    {"C3D6", 6},
    {"C3D15", 18},
    {"C3D8", 5},
    {"C3D20", 17},
    {"S3", triangle_3},
    {"DS3", 2},
    {"STRI3", 2},
    {"CPS3", 2},
    {"CPE3", 2},
    {"CPEG3", 2},
    {"CAX3", 2},
    {"M3D3", 2},
    {"SFM3D3", 2},
    {"R3D3", 2},
    {"F3D3", 2},
    {"S6", 9},
    {"STRI65", 9},
    {"CPS6", 9},
    {"CPE6", 9},
    {"CAX6", 9},
    {"M3D6", 9},
    {"SFM3D6", 9},
    {"T3D2", 1},
    {"B31", 1},
    {"B21", 1},
}};

std::optional<int> gmsh_type_of(const std::string& name) {
  for (const auto& [prefix, type] : abaqus_elements) {
    const std::string_view start = prefix;
    if (!name.starts_with(start)) continue;
    const auto is_letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
    if (std::all_of(name.begin() + static_cast<std::ptrdiff_t>(start.size()), name.end(), is_letter)) return type;
  }
  return std::nullopt;
}

/// Keywords that define nodes or elements in other ways.
constexpr std::array<const char*, 9> generating_cards{"NGEN",   "NFILL",  "NCOPY",    "NMAP",        "ELGEN",
                                                      "ELCOPY", "SYSTEM", "SUBMODEL", "SUPERELEMENT"};

/// Where in the file a card stands: in a file without parts, a part (or instance), or the assembly around instances.
enum class Within { nothing, part, assembly };

class AbaqusFile {
 public:
  explicit AbaqusFile(const std::string& file) : in_(file) {}
  SerialMesh read();

 private:
  void read_card(const AbaqusCard& card);
  bool read_structure(const AbaqusCard& card);
  void read_instance(const AbaqusCard& card);
  void read_nodes(const AbaqusCard& card);
  void read_elements(const AbaqusCard& card);
  void define_element(std::size_t label, std::size_t index);
  void skip_elements(const std::string& type, AbaqusSet* set);
  void read_set(const AbaqusCard& card, AbaqusSets& sets, const char* parameter);
  void read_range(const std::vector<std::string>& entries, AbaqusSet& set);
  void read_surface(const AbaqusCard& card);
  std::string name(const AbaqusCard& card, const char* parameter) const;
  const AbaqusSet& known_set(const AbaqusSets& sets, const std::string& name) const;

  AbaqusCards in_;
  AbaqusModel model_;
  Within within_ = Within::nothing;
  std::string part_, scope_;
  bool has_instance_ = false;
  std::map<std::string, std::size_t> left_out_;  // elements by type
};

std::string AbaqusFile::name(const AbaqusCard& card, const char* parameter) const {
  std::string name = card.value(parameter);
  if (name.empty()) in_.fail("*" + card.keyword + " needs a name: " + parameter + "=NAME");
  return name;
}

const AbaqusSet& AbaqusFile::known_set(const AbaqusSets& sets, const std::string& name) const {
  const AbaqusSet* const set = sets.find(scope_, name);
  if (set == nullptr) in_.fail("the set " + in_quotes(name) + " is not defined before this line");
  return *set;
}

void AbaqusFile::read_nodes(const AbaqusCard& card) {
  const std::string system = in_capitals(card.value("SYSTEM"));
  if (card.has("INPUT")) in_.fail("nodes of another file are not supported: use *INCLUDE, INPUT=FILE below *NODE");
  if (!system.empty() && system != "R") in_.fail("nodes in cylindrical or spherical coordinates are not supported");
  AbaqusSet* const set = card.has("NSET") ? &model_.node_sets.add(scope_, name(card, "NSET"), card.line) : nullptr;
  std::vector<std::string> entries;
  while (in_.next_data(entries)) {
    const std::size_t label = in_.label(entries.front(), "the number of a node");
    std::array<double, 3> x{};
    for (std::size_t i = 1; i < entries.size() && i <= 3; ++i) x[i - 1] = in_.real(entries[i], "a coordinate");
    if (entries.size() < 2) in_.fail("the coordinates of node " + entries.front() + " are missing");
    if (!model_.nodes.insert(label).second) {
      in_.fail("node " + std::to_string(label) + " is defined twice: give every node its own number");
    }
    model_.mesh.add_node(label, x);
    if (set != nullptr) set->labels.push_back(label);
  }
}

void AbaqusFile::define_element(std::size_t label, std::size_t index) {
  if (model_.elements.try_emplace(label, index).second) return;
  in_.fail("element " + std::to_string(label) + " is defined twice: give every element its own number");
}

void AbaqusFile::skip_elements(const std::string& type, AbaqusSet* set) {
  std::vector<std::string> entries;
  bool is_first = true;
  while (in_.next_data(entries)) {
    if (is_first) {
      const std::size_t label = in_.label(entries.front(), "the number of an element");
      define_element(label, AbaqusModel::left_out);
      ++left_out_[type];
      if (set != nullptr) set->labels.push_back(label);
    }
    is_first = !in_.continues();
  }
}

void AbaqusFile::read_elements(const AbaqusCard& card) {
  if (card.has("INPUT"))
    in_.fail("elements of another file are not supported: use *INCLUDE, INPUT=FILE below *ELEMENT");
  const std::string type_name = in_capitals(name(card, "TYPE"));
  const std::optional<int> type = gmsh_type_of(type_name);
  AbaqusSet* const set = card.has("ELSET") ? &model_.element_sets.add(scope_, name(card, "ELSET"), card.line) : nullptr;
  if (!type) return skip_elements(type_name, set);
  const auto num_nodes = static_cast<std::size_t>(element_types[static_cast<std::size_t>(*type)].num_nodes);
  std::vector<std::size_t> labels;
  std::size_t line = 0;
  for (std::vector<std::string> entries; in_.next_data(entries);) {
    if (labels.empty()) line = in_.lines().number();
    for (const std::string& entry : entries) labels.push_back(in_.label(entry, "the number of an element or node"));
    if (labels.size() <= num_nodes && in_.continues()) continue;
    if (labels.size() != num_nodes + 1 && !(labels.size() > num_nodes && *type == 1)) {  // beams: a direction
      in_.fail("an element of type " + type_name + " has " + std::to_string(num_nodes) + " nodes, not " +
               std::to_string(labels.size() - 1));
    }
    if (*type == tetrahedron_10) swap_last_two(std::span(labels).subspan(1));
    const std::size_t index = model_.mesh.add_element(*type, labels[0], std::span(labels).subspan(1, num_nodes), line);
    define_element(labels[0], index);
    if (set != nullptr) set->labels.push_back(labels[0]);
    labels.clear();
  }
  if (!labels.empty()) in_.lines().fail(line, "the nodes of element " + std::to_string(labels[0]) + " are incomplete");
}

void AbaqusFile::read_range(const std::vector<std::string>& entries, AbaqusSet& set) {
  if (entries.size() < 2 || entries.size() > 3) in_.fail("with GENERATE, a line has the first, the last and the step");
  const std::size_t first = in_.label(entries[0], "the first number"), last = in_.label(entries[1], "the last number"),
                    step = entries.size() == 3 ? in_.label(entries[2], "the step") : 1;
  const std::size_t known = std::max(model_.nodes.size(), model_.elements.size());
  if (last < first) in_.fail("the last number of the set is less than the first");
  if ((last - first) / step > known) in_.fail("the range has more numbers than the file has nodes or elements");
  std::vector<std::size_t> labels;
  for (std::size_t label = first; label <= last; label += step) labels.push_back(label);
  add_labels(set, labels);
}

void AbaqusFile::read_set(const AbaqusCard& card, AbaqusSets& sets, const char* parameter) {
  // Numbers in the assembly, without an instance, are of its own nodes, such as reference points, which are left out.
  const bool has_own_numbers = within_ == Within::assembly && !card.has("INSTANCE");
  AbaqusSet set{name(card, parameter), "", false, card.line, {}};
  const bool is_nodes = &sets == &model_.node_sets;
  if (is_nodes && card.has("ELSET")) {
    for (const std::size_t label : known_set(model_.element_sets, card.value("ELSET")).labels) {
      const auto e = model_.elements.find(label);
      if (e == model_.elements.end() || e->second == AbaqusModel::left_out) continue;
      const auto nodes = model_.mesh.nodes(e->second);
      set.labels.insert(set.labels.end(), nodes.begin(), nodes.end());
    }
  }
  for (std::vector<std::string> entries; in_.next_data(entries);) {
    if (card.has("GENERATE")) {
      if (!has_own_numbers) read_range(entries, set);
      continue;
    }
    for (const std::string& entry : entries) {
      if (entry.empty()) continue;
      if (!integer_in(entry)) {
        add_labels(set, known_set(sets, entry).labels);
      } else if (!has_own_numbers) {
        set.labels.push_back(in_.label(entry, is_nodes ? "a node" : "an element"));
      }
    }
  }
  AbaqusSet& whole = sets.add(scope_, set.name, card.line);
  whole.is_internal = card.has("INTERNAL");
  add_labels(whole, set.labels);
  make_unique(whole);  // or sets that name one another twice would double at each card
}

void AbaqusFile::read_surface(const AbaqusCard& card) {
  const std::string type = in_capitals(card.value("TYPE"));
  AbaqusSurface surface{name(card, "NAME"), scope_, {}};
  std::vector<std::string> entries;
  if (type == "NODE") {
    AbaqusSet set{surface.name, scope_, card.has("INTERNAL"), card.line, {}};
    while (in_.next_data(entries)) {
      if (integer_in(entries.front())) {
        set.labels.push_back(in_.label(entries.front(), "a node"));
      } else {
        add_labels(set, known_set(model_.node_sets, entries.front()).labels);
      }
    }
    AbaqusSet& whole = model_.node_sets.add(scope_, surface.name, card.line);
    whole.is_internal = set.is_internal;
    add_labels(whole, set.labels);
    return;
  }
  if (!type.empty() && type != "ELEMENT") {
    model_.mesh.add_notice("the analytical surface " + in_quotes(surface.name) +
                           " was left out: describe it as an obstacle of the input");
    return;
  }
  if (card.has("COMBINE")) in_.fail("surfaces combined of others are not supported: list their elements and sides");
  while (in_.next_data(entries)) {
    surface.sides.push_back({entries.front(), entries.size() > 1 ? in_capitals(entries[1]) : "", in_.lines().number()});
  }
  if (!card.has("INTERNAL")) model_.surfaces.push_back(std::move(surface));
}

void AbaqusFile::read_instance(const AbaqusCard& card) {
  if (has_instance_) {
    in_.fail(
        "there is a second instance, but only one can be read: join them (Abaqus/CAE: Assembly, Merge/Cut), or write a "
        "file without parts");
  }
  has_instance_ = true;
  within_ = Within::part;
  if (part_.empty()) part_ = name(card, "NAME");
  scope_ = in_capitals(part_) + ".";
  for (std::vector<std::string> entries; in_.next_data(entries);) {
    for (const std::string& entry : entries) {
      if (in_.real(entry, "a number that places the instance") == 0.0) continue;
      in_.fail("the instance is translated or rotated, which is not supported: write a file without parts");
    }
  }
}

bool AbaqusFile::read_structure(const AbaqusCard& card) {
  if (card.keyword == "PART") {
    if (!part_.empty()) {
      in_.fail(
          "there is a second part, but only one can be read: join them (Abaqus/CAE: Assembly, Merge/Cut), or write a "
          "file without parts");
    }
    part_ = name(card, "NAME");
    within_ = Within::part;
    scope_ = in_capitals(part_) + ".";
  } else if (card.keyword == "INSTANCE") {
    read_instance(card);
  } else if (card.keyword == "ASSEMBLY" || card.keyword == "ENDINSTANCE") {
    within_ = Within::assembly;
    scope_.clear();
  } else if (card.keyword == "ENDASSEMBLY" || card.keyword == "ENDPART") {
    within_ = Within::nothing;
    scope_.clear();
  } else {
    return false;
  }
  return true;
}

void AbaqusFile::read_card(const AbaqusCard& card) {
  if (read_structure(card)) return;
  if (std::ranges::find(generating_cards, card.keyword) != generating_cards.end()) {
    in_.fail("*" + card.keyword +
             " is not supported: write the file with all nodes and elements (Abaqus/CAE does, and gmsh)");
  }
  if (card.keyword == "NODE" && within_ != Within::assembly) read_nodes(card);
  if (card.keyword == "ELEMENT" && within_ != Within::assembly) read_elements(card);
  if (card.keyword == "NSET") read_set(card, model_.node_sets, "NSET");
  if (card.keyword == "ELSET") read_set(card, model_.element_sets, "ELSET");
  if (card.keyword == "SURFACE") read_surface(card);
}

SerialMesh AbaqusFile::read() {
  AbaqusCard card;
  while (in_.next(card) && card.keyword != "STEP") read_card(card);
  if (model_.nodes.empty())
    in_.fail("the file ends without nodes (*NODE): it is not an input file of Abaqus or CalculiX, or truncated");
  std::string types;
  for (const auto& [type, count] : left_out_) {
    types += (types.empty() ? "" : ", ") + std::to_string(count) + " of type " + type;
  }
  if (!types.empty()) model_.mesh.add_notice("elements that are not tetrahedra were left out: " + types);
  const LineReader& lines = in_.lines();
  assign_groups(model_, lines);
  return model_.mesh.finish([&](std::size_t line) { return lines.place(line); });
}

}  // namespace

SerialMesh read_abaqus(const std::string& file) {
  return AbaqusFile(file).read();
}

}  // namespace pliant
