#include "mesh/msh_reader.hpp"

#include "base/text.hpp"
#include "mesh/element_type.hpp"
#include "mesh/mesh_collector.hpp"
#include "mesh/msh_cursor.hpp"
#include "mesh/source_checks.hpp"

#include <cstdlib>
#include <limits>
#include <optional>
#include <set>
#include <tuple>

#include <fmt/format.h>

namespace pliant {
namespace {

// The fewest bytes of an item: in ascii a digit and a blank times its numbers; binary items take more.
constexpr std::size_t bytes_of(std::size_t num_numbers) {
  return 2 * num_numbers;
}

/// Reads the sections of a file in one pass.
class MshFile {
 public:
  explicit MshFile(std::string_view bytes) : in_(bytes) {}
  SerialMesh read();

 private:
  void read_format();
  void read_names();
  void read_entities();
  void read_partitioned_entities();
  void read_nodes_2();
  void read_nodes_4();
  void read_elements_2();
  void read_elements_4();
  void read_element_data();
  void read_entity(int dimension, bool is_partitioned);
  void read_element_2(int type, int tag, std::size_t num_tags);
  int element_type();
  int physical_tag(const char* what);
  void add(int type, std::size_t tag, std::span<const int> physicals);
  MeshCollector& collector();
  void read_section(const std::string& name);
  void end_section(const std::string& name);

  MshCursor in_;
  int version_ = 0;
  Encoding encoding_ = Encoding::ascii;
  std::set<std::string> sections_;  // read so far
  std::vector<std::tuple<int, int, std::string>> names_;
  std::map<std::pair<int, int>, std::vector<int>> physicals_;  // version 4: groups of each entity
  std::set<int> partitions_;                                   // partitions that contain volumes
  std::optional<MeshCollector> collector_;
  std::vector<std::size_t> nodes_;                                    // of the current element
  std::vector<std::pair<CellField, std::vector<std::size_t>>> data_;  // with the tags of their elements
};

void MshFile::read_format() {
  const double version = in_.number<double>("the version of the format");
  const int is_binary = in_.number<int>("the file type, 0 or 1");
  const int data_size = in_.number<int>("the data size");
  if (version == 4.1) {
    version_ = 4;
  } else if (version >= 2.0 && version < 3.0) {
    version_ = 2;
  } else {
    in_.fail(
        fmt::format("version {:g}", version) +
        " of the format is not supported, only 2.2 and 4.1; convert it: gmsh old.msh -save -format msh41 -o new.msh");
  }
  if (is_binary != 0 && is_binary != 1) in_.fail("the file type must be 0 (ascii) or 1 (binary)");
  if (data_size != 8) in_.fail("the data size must be 8 bytes");
  (void)in_.line();
  if (is_binary == 1) {
    in_.use(Encoding::binary);
    const auto one = in_.number<std::int32_t>("the number 1 that marks the byte order");
    if (one != 1 && one != 0x01000000) in_.fail_as_damaged("the number that marks the byte order is wrong");
    encoding_ = one == 1 ? Encoding::binary : Encoding::binary_swapped;
  }
}

void MshFile::read_names() {
  in_.use(Encoding::ascii);  // in binary files too
  const auto count = in_.count<int>("the number of physical names", bytes_of(3));
  for (std::size_t i = 0; i < count; ++i) {
    const int dimension = in_.number<int>("the dimension of a physical group");
    const int tag = in_.number<int>("the tag of a physical group");
    const std::string name = in_.quoted("the name of a physical group");
    if (dimension < 0 || dimension > 3) in_.fail("the dimension of a physical group must be 0, 1, 2 or 3");
    names_.emplace_back(dimension, tag, name);
  }
}

void MshFile::read_entity(int dimension, bool is_partitioned) {
  const int tag = in_.number<int>("the tag of an entity");
  if (is_partitioned) {
    (void)in_.number<int>("the dimension of a parent entity");
    (void)in_.number<int>("the tag of a parent entity");
    const auto num_partitions = in_.count<std::size_t>("the number of partitions", bytes_of(1));
    for (std::size_t i = 0; i < num_partitions; ++i) {
      const int partition = in_.number<int>("a partition");
      if (dimension == 3) partitions_.insert(partition);
    }
  }
  const int num_bounds = dimension == 0 ? 3 : 6;
  for (int i = 0; i < num_bounds; ++i) (void)in_.number<double>("a bound of an entity");
  const auto num_physicals = in_.count<std::size_t>("the number of physical tags of an entity", bytes_of(1));
  auto& physicals = physicals_[{dimension, tag}];
  physicals.clear();
  for (std::size_t i = 0; i < num_physicals; ++i) physicals.push_back(physical_tag("a physical tag"));
  if (dimension == 0) return;
  const auto num_boundary = in_.count<std::size_t>("the number of boundary entities", bytes_of(1));
  for (std::size_t i = 0; i < num_boundary; ++i) (void)in_.number<int>("the tag of a boundary entity");
}

void MshFile::read_entities() {
  std::array<std::size_t, 4> counts{};
  for (auto& count : counts) count = in_.count<std::size_t>("the number of entities", bytes_of(5));
  for (int dimension = 0; dimension < 4; ++dimension) {
    for (std::size_t i = 0; i < counts[static_cast<std::size_t>(dimension)]; ++i) read_entity(dimension, false);
  }
}

void MshFile::read_partitioned_entities() {
  const auto num_partitions = in_.number<std::size_t>("the number of partitions");
  const auto num_ghosts = in_.count<std::size_t>("the number of ghost entities", bytes_of(2));
  for (std::size_t i = 0; i < 2 * num_ghosts; ++i) (void)in_.number<int>("a ghost entity");
  std::array<std::size_t, 4> counts{};
  for (auto& count : counts) count = in_.count<std::size_t>("the number of entities", bytes_of(5));
  for (int dimension = 0; dimension < 4; ++dimension) {
    for (std::size_t i = 0; i < counts[static_cast<std::size_t>(dimension)]; ++i) read_entity(dimension, true);
  }
  if (!partitions_.empty() && partitions_.size() < num_partitions) {
    in_.fail(
        fmt::format("the file holds {} of a mesh's {} partitions; write the whole mesh to one file, in gmsh "
                    "without -part_split (Mesh.PartitionSplitMeshFiles = 0)",
                    partitions_.size(), num_partitions));
  }
}

void MshFile::read_nodes_2() {
  in_.use(Encoding::ascii);
  const auto count = in_.count<std::int64_t>("the number of nodes", bytes_of(4));
  (void)in_.line();
  in_.use(encoding_);
  std::vector<std::size_t> tags(count);
  std::vector<double> coordinates(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const int tag = in_.number<int>("the number of a node");
    if (tag < 0) in_.fail("the number of a node must not be negative");
    tags[i] = static_cast<std::size_t>(tag);
    for (std::size_t k = 0; k < 3; ++k) coordinates[3 * i + k] = in_.number<double>("a coordinate");
  }
  collector_.emplace(std::move(tags), std::move(coordinates));
}

void MshFile::read_nodes_4() {
  const auto num_blocks = in_.count<std::size_t>("the number of node blocks", bytes_of(4));
  const auto num_nodes = in_.count<std::size_t>("the number of nodes", bytes_of(4));
  (void)in_.number<std::size_t>("the smallest node tag");
  (void)in_.number<std::size_t>("the largest node tag");
  std::vector<std::size_t> tags;
  std::vector<double> coordinates;
  tags.reserve(num_nodes);
  coordinates.reserve(3 * num_nodes);
  for (std::size_t block = 0; block < num_blocks; ++block) {
    const int dimension = in_.number<int>("the dimension of an entity");
    (void)in_.number<int>("the tag of an entity");
    const int is_parametric = in_.number<int>("0 or 1 for parametric coordinates");
    const auto count = in_.count<std::size_t>("the number of nodes in a block", bytes_of(4));
    if (dimension < 0 || dimension > 3) in_.fail("the dimension of an entity must be 0, 1, 2 or 3");
    for (std::size_t i = 0; i < count; ++i) tags.push_back(in_.number<std::size_t>("the tag of a node"));
    const int num_parameters = is_parametric != 0 ? dimension : 0;
    for (std::size_t i = 0; i < count; ++i) {
      for (int k = 0; k < 3; ++k) coordinates.push_back(in_.number<double>("a coordinate"));
      for (int k = 0; k < num_parameters; ++k) (void)in_.number<double>("a parametric coordinate");
    }
  }
  if (tags.size() != num_nodes) {
    in_.fail("the blocks of nodes hold " + std::to_string(tags.size()) + " nodes, but the section says " +
             std::to_string(num_nodes));
  }
  collector_.emplace(std::move(tags), std::move(coordinates));
}

// Negative where the group has the element with opposite orientation.
int MshFile::physical_tag(const char* what) {
  const int tag = in_.number<int>(what);
  if (tag == std::numeric_limits<int>::min()) in_.fail_as_damaged(std::string(what) + " is too large");
  return std::abs(tag);
}

int MshFile::element_type() {
  const int type = in_.number<int>("the type of an element");
  if (type <= 0 || type >= static_cast<int>(element_types.size())) {
    in_.fail("elements of gmsh type " + std::to_string(type) + " are not supported: only tetrahedra of order 1 or 2");
  }
  return type;
}

MeshCollector& MshFile::collector() {
  if (!collector_) in_.fail("the elements come before the nodes");
  return *collector_;
}

void MshFile::add(int type, std::size_t tag, std::span<const int> physicals) {
  try {
    collector_->add(type, tag, nodes_, physicals);
  } catch (const MeshDefect& defect) {
    in_.fail("element " + std::to_string(tag) + ": " + defect.what());
  }
}

void MshFile::read_element_2(int type, int tag, std::size_t num_tags) {
  int physical = 0;
  for (std::size_t t = 0; t < num_tags; ++t) {
    const int value = physical_tag("a tag of an element");
    if (t == 0) physical = value;
  }
  nodes_.resize(static_cast<std::size_t>(element_types[static_cast<std::size_t>(type)].num_nodes));
  for (auto& node : nodes_) node = in_.number<std::uint32_t>("a node of an element");
  add(type, static_cast<std::size_t>(tag), {&physical, physical != 0 ? std::size_t{1} : std::size_t{0}});
}

// Ascii: "number type num_tags tags nodes" per element; binary: "type num_elements num_tags" per block, then the rest
// of each element.
void MshFile::read_elements_2() {
  in_.use(Encoding::ascii);
  const auto num_elements = in_.count<std::int64_t>("the number of elements", bytes_of(3));
  (void)in_.line();
  in_.use(encoding_);
  collector();
  for (std::size_t done = 0; done < num_elements;) {
    const bool is_ascii = encoding_ == Encoding::ascii;
    const int first_tag = is_ascii ? in_.number<int>("the number of an element") : 0;
    const int type = element_type();
    const std::size_t block = is_ascii ? 1 : in_.count<int>("the number of elements in a block", sizeof(int));
    const auto num_tags = in_.count<int>("the number of tags of an element", bytes_of(1));
    if (block == 0 || block > num_elements - done)
      in_.fail("the blocks of elements do not add up to the number that the section gives");
    for (std::size_t i = 0; i < block; ++i) {
      const int tag = is_ascii ? first_tag : in_.number<int>("the number of an element");
      read_element_2(type, tag, num_tags);
    }
    done += block;
  }
}

void MshFile::read_elements_4() {
  collector();
  const auto num_blocks = in_.count<std::size_t>("the number of element blocks", bytes_of(4));
  const auto num_elements = in_.count<std::size_t>("the number of elements", bytes_of(2));
  (void)in_.number<std::size_t>("the smallest element tag");
  (void)in_.number<std::size_t>("the largest element tag");
  std::size_t done = 0;
  for (std::size_t block = 0; block < num_blocks; ++block) {
    const int dimension = in_.number<int>("the dimension of an entity");
    const int entity = in_.number<int>("the tag of an entity");
    const int type = element_type();
    const auto count = in_.count<std::size_t>("the number of elements in a block", bytes_of(2));
    const auto& kind = element_types[static_cast<std::size_t>(type)];
    if (kind.dimension != dimension) {
      in_.fail(std::string("elements of type ") + kind.name + " in an entity of dimension " +
               std::to_string(dimension));
    }
    const std::vector<int>& physicals = physicals_[{dimension, entity}];
    nodes_.resize(static_cast<std::size_t>(kind.num_nodes));
    for (std::size_t i = 0; i < count; ++i) {
      const auto tag = in_.number<std::size_t>("the tag of an element");
      for (auto& node : nodes_) node = in_.number<std::size_t>("a node of an element");
      add(type, tag, physicals);
    }
    done += count;
  }
  if (done != num_elements) {
    in_.fail("the blocks of elements hold " + std::to_string(done) + " elements, but the section says " +
             std::to_string(num_elements));
  }
}

// The header is ascii in binary files too: names, real numbers (the time), integers (step, components, entries, ...).
void MshFile::read_element_data() {
  in_.use(Encoding::ascii);
  CellField data;
  const auto num_names = in_.count<int>("the number of names of the data", bytes_of(1));
  for (std::size_t i = 0; i < num_names; ++i) {
    const std::string name = in_.quoted("the name of the data");
    if (i == 0) data.name = name;
  }
  const auto num_reals = in_.count<int>("the number of real tags of the data", bytes_of(1));
  for (std::size_t i = 0; i < num_reals; ++i) (void)in_.number<double>("a real tag of the data");
  const auto num_integers = in_.count<int>("the number of integer tags of the data", bytes_of(1));
  if (num_integers < 3) in_.fail("data need three integer tags: step, components, number of elements");
  (void)in_.number<int>("the step of the data");
  data.components = in_.number<int>("the number of components of the data");
  if (data.components < 1 || data.components > 9) in_.fail("the number of components of the data must be 1 to 9");
  const auto size = static_cast<std::size_t>(data.components);
  const auto count = in_.count<int>("the number of elements of the data", bytes_of(1 + size));
  for (std::size_t i = 3; i < num_integers; ++i) (void)in_.number<int>("an integer tag of the data");
  (void)in_.line();
  in_.use(encoding_);
  std::vector<std::size_t> tags(count);
  data.values.resize(size * count);
  for (std::size_t i = 0; i < count; ++i) {
    const int tag = in_.number<int>("the number of an element");
    if (tag < 0) in_.fail("the number of an element must not be negative");
    tags[i] = static_cast<std::size_t>(tag);
    for (std::size_t k = 0; k < size; ++k) data.values[size * i + k] = in_.number<double>("a value of the data");
  }
  data_.emplace_back(std::move(data), std::move(tags));
}

void MshFile::end_section(const std::string& name) {
  in_.use(Encoding::ascii);
  const std::string_view word = in_.word();
  if (word == "$End" + name) return;
  if (word.empty()) in_.fail_at_end("inside $" + name);
  in_.fail("$End" + name +
           " is expected here: the number of entries in the section's header is wrong, or the file is damaged; write "
           "or copy it again");
}

void MshFile::read_section(const std::string& name) {
  using Reader = void (MshFile::*)();
  const bool is_4 = version_ == 4;
  const std::map<std::string, Reader> readers{
      {"MeshFormat", &MshFile::read_format},
      {"PhysicalNames", &MshFile::read_names},
      {"Entities", is_4 ? &MshFile::read_entities : nullptr},
      {"PartitionedEntities", is_4 ? &MshFile::read_partitioned_entities : nullptr},
      {"Nodes", is_4 ? &MshFile::read_nodes_4 : &MshFile::read_nodes_2},
      {"Elements", is_4 ? &MshFile::read_elements_4 : &MshFile::read_elements_2},
      {"ElementData", &MshFile::read_element_data},
  };
  const auto reader = readers.find(name);
  if (reader == readers.end() || reader->second == nullptr) {
    if (!in_.skip_past("$End" + name)) in_.fail_at_end("inside $" + excerpt(name, 30));
    return;
  }
  if (!sections_.insert(name).second && name != "ElementData") in_.fail("there is a second $" + name + " section");
  (void)in_.line();
  in_.use(encoding_);
  (this->*reader->second)();
  end_section(name);
}

SerialMesh MshFile::read() {
  for (std::string_view word = in_.word(); !word.empty(); word = in_.word()) {
    const std::string name(word.substr(1));
    if (word.front() != '$' || (version_ == 0 && name != "MeshFormat" && name != "Comments")) {
      in_.fail(
          version_ == 0
              ? "the file does not begin with $MeshFormat: it is not a .msh file of version 2.2 or 4.1"
              : "a section ($Nodes, $Elements, ...) is expected here: the file is damaged; write or copy it again");
    }
    read_section(name);
  }
  for (const char* name : {"Nodes", "Elements"}) {
    if (sections_.count(name) == 0) in_.fail(std::string("the file ends without a $") + name + " section");
  }
  for (const auto& [dimension, tag, name] : names_) collector_->name_group(dimension, tag, name);
  for (auto& [data, tags] : data_) collector_->add_data(std::move(data), std::move(tags));
  return collector_->finish();
}

}  // namespace

SerialMesh read_msh(const std::string& file) {
  const std::string bytes = file_contents(file);
  return MshFile(bytes).read();
}

}  // namespace pliant
