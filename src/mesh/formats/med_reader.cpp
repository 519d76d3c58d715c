#include "mesh/formats/med_reader.hpp"

#include "base/text.hpp"
#include "mesh/element_type.hpp"
#include "mesh/formats/line_reader.hpp"
#include "mesh/formats/mesh_assembly.hpp"
#include "mesh/source_checks.hpp"
#include "petsc/hdf5.hpp"

#include <algorithm>
#include <map>

namespace pliant {
namespace {

const std::map<std::string, int> med_types{{"PO1", 15}, {"SE2", 1},  {"SE3", 8},  {"TR3", 2},  {"TR6", 9}, {"QU4", 3},
                                           {"QU8", 16}, {"QU9", 10}, {"TE4", 4},  {"T10", 11}, {"HE8", 5}, {"H20", 17},
                                           {"H27", 12}, {"PE6", 6},  {"P15", 18}, {"P18", 13}, {"PY5", 7}, {"P13", 19}};

bool has_link(hid_t parent, const std::string& name) {
  return H5Lexists(parent, name.c_str(), H5P_DEFAULT) > 0;
}

Hdf5Handle med_group(hid_t parent, const std::string& name) {
  if (!has_link(parent, name)) throw MeshDefect("it has no " + name + ": it is not a MED file, or damaged");
  return Hdf5Handle(H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose, "open " + name);
}

template <class T>
std::vector<T> med_values(hid_t parent, const std::string& name, hid_t type) {
  if (!has_link(parent, name)) throw MeshDefect("it has no " + name + ": it is not a MED file, or damaged");
  const Hdf5Handle dataset(H5Dopen2(parent, name.c_str(), H5P_DEFAULT), H5Dclose, "open " + name);
  const auto sizes = sizes_of(dataset.get());
  if (sizes.size() != 1) throw MeshDefect(name + " must have one dimension: the file is damaged");
  require_stored(dataset.get(), "read " + name);
  std::vector<T> values(sizes[0]);
  read_rows(dataset.get(), {0, static_cast<std::int64_t>(sizes[0])}, type, values.data());
  return values;
}

class MedFile {
 public:
  explicit MedFile(hid_t file) : file_(file) {}
  SerialMesh read();

 private:
  using Families = std::map<std::int64_t, std::vector<int>>;  // sets by number of the family
  void read_nodes(hid_t step);
  void read_elements(hid_t cells, const std::string& name);
  Families families(hid_t of_mesh, const std::string& kind);
  std::vector<int> sets_of_family(hid_t family);
  bool is_mirrored(std::span<const std::size_t> nodes) const;

  hid_t file_;
  MeshAssembly mesh_;
  std::vector<double> x_;  // xyz, by axis
  std::map<std::string, int> sets_;
  Families of_elements_, of_nodes_;
  std::size_t num_elements_ = 0;
  std::string left_out_;
};

std::vector<int> MedFile::sets_of_family(hid_t family) {
  std::vector<int> sets;
  if (!has_link(family, "GRO")) return sets;
  const Hdf5Handle groups = med_group(family, "GRO");
  if (!has_link(groups.get(), "NOM")) return sets;
  const Hdf5Handle names(H5Dopen2(groups.get(), "NOM", H5P_DEFAULT), H5Dclose, "open NOM");
  const Hdf5Handle type(H5Dget_type(names.get()), H5Tclose, "open NOM");
  constexpr std::size_t width = 80, most_names = 10000;
  const auto sizes = sizes_of(names.get());
  if (H5Tget_size(type.get()) != width || H5Tget_class(type.get()) == H5T_VLEN || sizes.size() != 1 ||
      sizes[0] > most_names) {
    throw MeshDefect("the names of groups are not texts of 80 characters: the file is damaged");
  }
  std::string text(width * sizes[0], '\0');
  check_hdf5(H5Dread(names.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()), "read NOM");
  for (std::size_t i = 0; i < sizes[0]; ++i) {
    const std::string padded = text.substr(width * i, width);
    const std::string name(trimmed(std::string_view(padded).substr(0, padded.find('\0'))));
    require_plain_name(name);
    const auto [place, is_new] = sets_.try_emplace(name, static_cast<int>(sets_.size()) + 1);
    if (is_new) mesh_.name_set(place->second, name);
    sets.push_back(place->second);
  }
  return sets;
}

MedFile::Families MedFile::families(hid_t of_mesh, const std::string& kind) {
  Families result;
  if (!has_link(of_mesh, kind)) return result;
  const Hdf5Handle all = med_group(of_mesh, kind);
  for (const std::string& name : names_in(all.get())) {
    const Hdf5Handle family = med_group(all.get(), name);
    result[integer_attribute(family.get(), "NUM")] = sets_of_family(family.get());
  }
  return result;
}

void MedFile::read_nodes(hid_t step) {
  const Hdf5Handle nodes = med_group(step, "NOE");
  x_ = med_values<double>(nodes.get(), "COO", H5T_NATIVE_DOUBLE);
  if (x_.size() % 3 != 0) throw MeshDefect("its nodes do not have three coordinates each: the file is damaged");
  const std::size_t n = x_.size() / 3;
  for (std::size_t i = 0; i < n; ++i) mesh_.add_node(i + 1, {x_[i], x_[n + i], x_[2 * n + i]});
  if (!has_link(nodes.get(), "FAM")) return;
  const auto family = med_values<std::int64_t>(nodes.get(), "FAM", H5T_NATIVE_INT64);
  if (family.size() != n) throw MeshDefect("it has families of other nodes than it has: the file is damaged");
  for (std::size_t i = 0; i < n; ++i) {
    const auto found = of_nodes_.find(family[i]);
    if (found == of_nodes_.end()) continue;
    for (const int set : found->second) mesh_.put_node(i + 1, set);
  }
}

/// Whether the corners, which are nodes of the file, span a negative volume.
bool MedFile::is_mirrored(std::span<const std::size_t> nodes) const {
  if (x_.size() % 3 != 0) throw MeshDefect("its nodes do not have three coordinates each: the file is damaged");
  const std::size_t n = x_.size() / 3;
  std::array<std::array<double, 3>, 3> e{};
  for (std::size_t i = 0; i < 4; ++i) {
    if (nodes[i] > n) return false;  // refused later, with its number
    for (std::size_t k = 0; i > 0 && k < 3; ++k) e[i - 1][k] = x_[k * n + nodes[i] - 1] - x_[k * n + nodes[0] - 1];
  }
  const auto& [a, b, c] = e;
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]) <
         0.0;
}

void MedFile::read_elements(hid_t cells, const std::string& name) {
  const Hdf5Handle of_type = med_group(cells, name);
  const auto known = med_types.find(name);
  if (known == med_types.end()) {
    left_out_ += (left_out_.empty() ? "" : ", ") + name;
    return;
  }
  const auto num_nodes = static_cast<std::size_t>(element_types[static_cast<std::size_t>(known->second)].num_nodes);
  const auto list = med_values<std::int64_t>(of_type.get(), "NOD", H5T_NATIVE_INT64);
  const std::size_t n = list.size() / num_nodes;
  std::vector<std::int64_t> family(n, 0);
  if (has_link(of_type.get(), "FAM")) family = med_values<std::int64_t>(of_type.get(), "FAM", H5T_NATIVE_INT64);
  if (list.size() % num_nodes != 0 || family.size() != n) {
    throw MeshDefect("the numbers of its elements " + name + " do not fit: the file is damaged");
  }
  std::vector<std::size_t> nodes(num_nodes);
  for (std::size_t e = 0; e < n; ++e) {
    ++num_elements_;
    for (std::size_t i = 0; i < num_nodes; ++i) {
      const std::int64_t node = list[i * n + e];
      if (node < 1) throw MeshDefect("element " + std::to_string(num_elements_) + " has node " + std::to_string(node));
      nodes[i] = static_cast<std::size_t>(node);
    }
    if (known->second == tetrahedron_10) swap_last_two(nodes);
    const bool is_tetrahedron = known->second == tetrahedron_4 || known->second == tetrahedron_10;
    if (is_tetrahedron && is_mirrored(nodes)) mirror_tetrahedron(nodes);
    const std::size_t index = mesh_.add_element(known->second, num_elements_, nodes, 0);
    const auto found = of_elements_.find(family[e]);
    if (found == of_elements_.end()) continue;
    for (const int set : found->second) mesh_.put_element(index, set);
  }
}

SerialMesh MedFile::read() {
  const Hdf5Handle meshes = med_group(file_, "ENS_MAA");
  const auto names = names_in(meshes.get());
  if (names.size() != 1) {
    throw MeshDefect("it has " + std::to_string(names.size()) +
                     " meshes, but must have one: export the one that is meant");
  }
  const Hdf5Handle mesh = med_group(meshes.get(), names[0]);
  if (integer_attribute(mesh.get(), "ESP") != 3) throw MeshDefect("its mesh must have three dimensions");
  Hdf5Handle step;  // in MED 2 the mesh itself
  if (!has_link(mesh.get(), "NOE")) {
    const auto steps = names_in(mesh.get());
    if (steps.size() != 1) throw MeshDefect("its mesh must have one time step, not " + std::to_string(steps.size()));
    step = med_group(mesh.get(), steps[0]);
  }
  const hid_t in = has_link(mesh.get(), "NOE") ? mesh.get() : step.get();
  if (has_link(file_, "FAS")) {
    const Hdf5Handle all = med_group(file_, "FAS");
    if (has_link(all.get(), names[0])) {
      const Hdf5Handle of_mesh = med_group(all.get(), names[0]);
      of_elements_ = families(of_mesh.get(), "ELEME");
      of_nodes_ = families(of_mesh.get(), "NOEUD");
    }
  }
  read_nodes(in);
  const Hdf5Handle cells = med_group(in, "MAI");
  for (const std::string& name : names_in(cells.get())) read_elements(cells.get(), name);
  if (!left_out_.empty()) mesh_.add_notice("elements that are not tetrahedra were left out: " + left_out_);
  return mesh_.finish([](std::size_t) { return std::string("its elements"); });
}

}  // namespace

SerialMesh read_med(const std::string& file) {
  const QuietHdf5 quiet;
  if (H5Fis_hdf5(file.c_str()) <= 0)
    throw MeshDefect("it is not an HDF5 file, as MED files are, or its beginning is damaged");
  try {
    const Hdf5Handle in = open_hdf5(file, Hdf5Mode::read);
    return MedFile(in.get()).read();
  } catch (const FileError& e) {
    throw MeshDefect(std::string("it is truncated or damaged (") + e.what() + "); write or copy it again");
  }
}

}  // namespace pliant
