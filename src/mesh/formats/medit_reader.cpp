#include "mesh/formats/medit_reader.hpp"

#include "base/text.hpp"
#include "mesh/element_type.hpp"
#include "mesh/formats/line_reader.hpp"
#include "mesh/formats/mesh_assembly.hpp"

#include <algorithm>
#include <cctype>
#include <map>

namespace pliant {
namespace {

/// The element of a section, and that of second order which gmsh writes into it (0: none).
struct MeditKind {
  int type;
  int second_order;
};

const std::map<std::string, MeditKind> medit_kinds{
    {"EDGES", {1, 8}},      {"TRIANGLES", {2, 9}}, {"QUADRILATERALS", {3, 16}}, {"TETRAHEDRA", {4, 11}},
    {"HEXAHEDRA", {5, 17}}, {"HEXAEDRA", {5, 17}}, {"PRISMS", {6, 18}},         {"PENTAHEDRA", {6, 18}},
    {"PYRAMIDS", {7, 19}},  {"EDGESP2", {8, 0}},   {"TRIANGLESP2", {9, 0}},     {"TETRAHEDRAP2", {11, 0}}};

class MeditFile {
 public:
  explicit MeditFile(const std::string& file) : in_(file) {}
  SerialMesh read();

 private:
  bool next_word(std::string& word);
  std::string needed_word(const char* what);
  std::size_t count(const char* what);
  void read_vertices();
  void read_elements(const MeditKind& kind);
  int type_of_line(const MeditKind& kind);

  LineReader in_;
  std::string_view rest_;  // of the current line
  MeshAssembly mesh_;
  std::size_t num_vertices_ = 0, num_elements_ = 0;
};

bool MeditFile::next_word(std::string& word) {
  for (rest_ = trimmed(rest_); rest_.empty() || rest_.front() == '#'; rest_ = trimmed(in_.text())) {
    rest_ = {};  // the line ends here
    if (!in_.next()) return false;
  }
  const auto is_blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  const auto size = static_cast<std::size_t>(std::find_if(rest_.begin(), rest_.end(), is_blank) - rest_.begin());
  word = std::string(rest_.substr(0, size));
  rest_.remove_prefix(size);
  return true;
}

std::string MeditFile::needed_word(const char* what) {
  std::string word;
  if (!next_word(word)) {
    in_.fail(std::string("the file ends where ") + what + " is expected: it is truncated; write or copy it again");
  }
  return word;
}

std::size_t MeditFile::count(const char* what) {
  const std::string word = needed_word(what);
  const auto number = integer_in(word);
  if (!number || *number < 0) in_.fail(std::string(what) + " is expected here, not " + in_quotes(word));
  return static_cast<std::size_t>(*number);
}

void MeditFile::read_vertices() {
  if (num_vertices_ > 0) in_.fail("there is a second section of vertices");
  num_vertices_ = count("the number of vertices");
  for (std::size_t v = 1; v <= num_vertices_; ++v) {
    std::array<double, 3> position{};
    for (double& x : position) {
      const std::string word = needed_word("a coordinate");
      const auto value = real_in(word);
      if (!value) in_.fail("a coordinate is expected here, not " + in_quotes(word));
      x = *value;
    }
    (void)needed_word("the reference of a vertex");
    mesh_.add_node(v, position);
  }
}

/// The type of the elements of a section by the words of its first line.
int MeditFile::type_of_line(const MeditKind& kind) {
  std::string first;
  if (kind.second_order == 0 || !next_word(first)) return kind.type;
  // `first` is put back: it ends where the rest begins.
  rest_ = std::string_view(rest_.data() - first.size(), first.size() + rest_.size());
  std::size_t num_words = 0;
  bool is_in_word = false;
  for (const char c : rest_) {
    const bool is_blank = std::isspace(static_cast<unsigned char>(c)) != 0;
    num_words += !is_blank && !is_in_word ? 1 : 0;
    is_in_word = !is_blank;
  }
  const auto nodes = static_cast<std::size_t>(element_types[static_cast<std::size_t>(kind.second_order)].num_nodes);
  return num_words == nodes + 1 ? kind.second_order : kind.type;
}

void MeditFile::read_elements(const MeditKind& kind) {
  const std::size_t number = count("the number of elements");
  if (number == 0) return;
  const int type = type_of_line(kind);
  std::vector<std::size_t> nodes(static_cast<std::size_t>(element_types[static_cast<std::size_t>(type)].num_nodes));
  for (std::size_t e = 0; e < number; ++e) {
    for (std::size_t& node : nodes) {
      node = count("a vertex of an element");
      if (node < 1 || (num_vertices_ > 0 && node > num_vertices_)) {
        in_.fail("an element has vertex " + std::to_string(node) + ", but there are only " +
                 std::to_string(num_vertices_) + " of them");
      }
    }
    const std::size_t line = in_.number();
    const std::string word = needed_word("the reference of an element");
    const auto reference = integer_in(word);
    if (!reference) in_.fail("the reference of an element is expected here, not " + in_quotes(word));
    if (type == tetrahedron_10) swap_last_two(nodes);
    const std::size_t index = mesh_.add_element(type, ++num_elements_, nodes, line);
    if (*reference > 0 && *reference < INT32_MAX) mesh_.put_element(index, static_cast<int>(*reference));
  }
}

SerialMesh MeditFile::read() {
  std::string word = needed_word("MeshVersionFormatted");
  if (in_capitals(word) != "MESHVERSIONFORMATTED") {
    in_.fail("the file does not begin with MeshVersionFormatted: it is not a mesh of Medit as text, or damaged");
  }
  (void)count("the version of the format");
  bool has_end = false;
  while (!has_end && next_word(word)) {
    const std::string section = in_capitals(word);
    const auto kind = medit_kinds.find(section);
    if (section == "DIMENSION") {
      if (count("the dimension") != 3) in_.fail("the mesh must have three dimensions");
    } else if (section == "VERTICES") {
      read_vertices();
    } else if (kind != medit_kinds.end()) {
      read_elements(kind->second);
    } else if (section == "END") {
      has_end = true;
    }  // other sections (corners, ridges, normals, ...) are words that are passed over
  }
  if (!has_end) in_.fail("the file ends without 'End': it is truncated; write or copy it again");
  return mesh_.finish([this](std::size_t line) { return in_.place(line); });
}

}  // namespace

SerialMesh read_medit(const std::string& file) {
  return MeditFile(file).read();
}

}  // namespace pliant
