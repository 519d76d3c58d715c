#include "mesh/mesh_file.hpp"

#include "base/text.hpp"
#include "mesh/isolated.hpp"
#include "mesh/source_checks.hpp"
#include "petsc/collective.hpp"
#include "petsc/exchange.hpp"
#include "petsc/hdf5.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <utility>

namespace pliant {
namespace {

constexpr const char* cure = "; write it again with `pliant mesh convert`";

/// The contents of the file, without its numbers.
struct Head {
  std::int64_t num_nodes = 0;
  std::int64_t num_cells = 0;
  std::vector<PhysicalGroup> groups;
  std::vector<std::int64_t> num_members;  // per group
  std::vector<CellField> cell_data;       // names and components only
};

hid_t integer_type() {
  return sizeof(PetscInt) == 8 ? H5T_NATIVE_INT64 : H5T_NATIVE_INT32;
}

bool exists(hid_t parent, const std::string& name) {
  return H5Lexists(parent, name.c_str(), H5P_DEFAULT) > 0;
}

/// A dataset of the given kind (H5T_INTEGER, H5T_FLOAT), read by rows. `columns` is 0 for a plain list.
class Table {
 public:
  Table(hid_t file, const std::string& name, H5T_class_t kind) : name_(name) {
    if (!exists(file, name)) throw MeshDefect("it contains no " + name);
    dataset_ = Hdf5Handle(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, "open " + name);
    const Hdf5Handle type(H5Dget_type(dataset_.get()), H5Tclose, "open " + name);
    sizes_ = sizes_of(dataset_.get());
    if (H5Tget_class(type.get()) != kind) {
      throw MeshDefect(name + " must hold " + (kind == H5T_FLOAT ? "floating-point numbers" : "integers"));
    }
  }
  hid_t get() const { return dataset_.get(); }
  std::int64_t num_rows() const {
    return sizes_.empty() ? 0 : static_cast<std::int64_t>(std::min<hsize_t>(sizes_[0], INT64_MAX));
  }
  int num_columns() const { return sizes_.size() == 2 ? static_cast<int>(std::min<hsize_t>(sizes_[1], 1000)) : 0; }
  void require_columns(int columns) const {
    if (num_columns() == columns && sizes_.size() == (columns == 0 ? 1 : 2)) return;
    throw MeshDefect(name_ + " must have " +
                     (columns == 0 ? "one dimension" : "rows of " + std::to_string(columns) + " numbers"));
  }

  /// Rejects sizes that the file's bytes cannot hold, however well compressed, before memory is requested for them.
  void require_stored() const {
    constexpr double best_packing = 1100;  // of zeros, with deflate
    const Hdf5Handle type(H5Dget_type(dataset_.get()), H5Tclose, "open " + name_);
    double claimed = static_cast<double>(H5Tget_size(type.get()));
    for (const hsize_t size : sizes_) claimed *= static_cast<double>(size);
    hsize_t file_size = 0;
    const Hdf5Handle file(H5Iget_file_id(dataset_.get()), H5Fclose, "open " + name_);
    check_hdf5(H5Fget_filesize(file.get(), &file_size), "open " + name_);
    const auto stored = static_cast<double>(H5Dget_storage_size(dataset_.get()));
    if (claimed <= best_packing * stored && stored <= static_cast<double>(file_size)) return;
    throw MeshDefect(name_ + " should have " + format_number(claimed) + " bytes, but the file holds " +
                     format_number(std::min(stored, static_cast<double>(file_size))) +
                     " of them: the file is truncated or damaged" + cure);
  }

 private:
  std::string name_;
  Hdf5Handle dataset_;
  std::vector<hsize_t> sizes_;
};

std::string group_path(std::size_t number) {
  return "groups/" + std::to_string(number);
}

std::string data_path(std::size_t number) {
  return "cell_data/" + std::to_string(number);
}

void require_format(hid_t file) {
  const bool is_mesh = H5Aexists(file, "format") > 0 && text_attribute(file, "format") == mesh_file_format;
  if (!is_mesh) throw MeshDefect("it is an HDF5 file, but not a mesh of Pliant: make one with `pliant mesh convert`");
  const std::int64_t version = integer_attribute(file, "version");
  if (version != mesh_file_version) {
    throw MeshDefect("it has version " + std::to_string(version) + " of the format, but this program reads version " +
                     std::to_string(mesh_file_version) + cure);
  }
}

/// Unknowns (degrees of freedom) and matrix entries are counted in PETSc's integers; a node has three unknowns.
void require_countable(const Head& head) {
  if (head.num_nodes <= PETSC_MAX_INT / 3 && head.num_cells <= PETSC_MAX_INT / 4) return;
  throw MeshDefect("it has " + std::to_string(head.num_nodes) + " nodes and " + std::to_string(head.num_cells) +
                   " tetrahedra, too many for 32-bit indices: build Pliant with a PETSc configured for 64-bit indices");
}

PhysicalGroup read_group_name(const Table& table) {
  PhysicalGroup group;
  const std::int64_t dimension = integer_attribute(table.get(), "dimension"),
                     tag = integer_attribute(table.get(), "tag");
  if (dimension < 0 || dimension > 3) throw MeshDefect("the dimension of a group must be 0, 1, 2 or 3");
  if (!std::in_range<int>(tag)) throw MeshDefect("the tag of a group is too large");
  group.dimension = static_cast<int>(dimension);
  group.tag = static_cast<int>(tag);
  group.name = text_attribute(table.get(), "name");
  require_plain_name(group.name);
  return group;
}

Head read_head(hid_t file) {
  require_format(file);
  Head head;
  const Table nodes(file, "nodes", H5T_FLOAT), cells(file, "cells", H5T_INTEGER);
  nodes.require_columns(3);
  cells.require_columns(4);
  head.num_nodes = nodes.num_rows();
  head.num_cells = cells.num_rows();
  require_countable(head);
  nodes.require_stored();
  cells.require_stored();
  for (std::size_t g = 0; exists(file, "groups") && exists(file, group_path(g)); ++g) {
    const Table members(file, group_path(g), H5T_INTEGER);
    head.groups.push_back(read_group_name(members));
    members.require_columns(head.groups.back().dimension == 3 ? 0 : 2);
    members.require_stored();
    head.num_members.push_back(members.num_rows());
  }
  for (std::size_t d = 0; exists(file, "cell_data") && exists(file, data_path(d)); ++d) {
    const Table data(file, data_path(d), H5T_FLOAT);
    if (data.num_columns() < 1 || data.num_columns() > 9 || data.num_rows() != head.num_cells) {
      throw MeshDefect(data_path(d) + " must have a row of 1 to 9 numbers for each cell");
    }
    data.require_stored();
    head.cell_data.push_back({text_attribute(data.get(), "name"), data.num_columns(), {}});
    require_plain_name(head.cell_data.back().name);
  }
  return head;
}

/// Reports a file that HDF5 cannot read as a defect of the mesh.
template <class Work>
auto reading(const std::string& file, Work work) {
  const QuietHdf5 quiet;
  try {
    const Hdf5Handle in = open_hdf5(file, Hdf5Mode::read);
    return work(in.get());
  } catch (const FileError& e) {
    throw MeshDefect(std::string("it is truncated or damaged (") + e.what() + ")" + cure);
  }
}

/// Checks the header in a child process, because HDF5 crashes on some damaged files, mostly over the descriptions of
/// datasets.
void judge(const std::string& file, int num_ranks) {
  require_readable(file);
  (void)isolated({Suspect::hdf5}, [&] {
    if (H5Fis_hdf5(file.c_str()) <= 0) throw MeshDefect("it is not an HDF5 file, or its beginning is damaged");
    require_enough_cells(reading(file, read_head).num_cells, num_ranks);
    return SerialMesh{};
  });
}

/// The rows of rank `r` of `size`.
Hdf5Rows block(std::int64_t num_rows, int r, int size) {
  const std::int64_t first = num_rows * r / size;
  return {first, num_rows * (r + 1) / size - first};
}

/// The rank whose block a row is in.
int rank_of_row(std::int64_t row, std::int64_t num_rows, int size) {
  return static_cast<int>(((row + 1) * size - 1) / num_rows);
}

/// Whether rank 0 reads all cells. Its way to a distributed mesh is several times as fast as that of all ranks
/// together, and takes 3 GB for so many cells; with two ranks hardly more than a step takes.
bool are_read_by_root(std::int64_t num_cells, int num_ranks) {
  PetscInt most = 4'000'000;
  check(PetscOptionsGetInt(nullptr, nullptr, "-mesh_cells_on_root", &most, nullptr));
  return num_cells <= most || (num_ranks <= 2 && most > 0);
}

void require_finite(std::span<const double> coordinates, std::int64_t first_node) {
  for (std::size_t i = 0; i < coordinates.size() / 3; ++i) {
    const double r2 = std::inner_product(&coordinates[3 * i], &coordinates[3 * i] + 3, &coordinates[3 * i], 0.0);
    if (std::isfinite(r2 * std::sqrt(r2))) continue;
    throw MeshDefect("the coordinates are not finite numbers (or beyond 1e100) in row " +
                     std::to_string(first_node + static_cast<std::int64_t>(i)) + " of nodes" + cure);
  }
}

void require_cells(std::span<const PetscInt> cells, std::int64_t first_cell, std::int64_t num_nodes) {
  for (std::size_t c = 0; c < cells.size() / 4; ++c) {
    auto corners = std::to_array({cells[4 * c], cells[4 * c + 1], cells[4 * c + 2], cells[4 * c + 3]});
    std::ranges::sort(corners);
    if (corners.front() >= 0 && corners.back() < num_nodes && std::ranges::adjacent_find(corners) == corners.end()) {
      continue;
    }
    throw MeshDefect("row " + std::to_string(first_cell + static_cast<std::int64_t>(c)) +
                     " of cells does not name four different nodes of the " + std::to_string(num_nodes) + cure);
  }
}

/// Members of a group: one cell each for volumes, else a cell and the number of its facet, edge or corner.
using Members = std::vector<std::int64_t>;

Members read_members(hid_t file, std::size_t number, const Head& head, const Hdf5Rows& rows) {
  const Table table(file, group_path(number), H5T_INTEGER);
  const int dimension = head.groups[number].dimension;
  const std::size_t columns = dimension == 3 ? 1 : 2;
  Members members(columns * static_cast<std::size_t>(rows.count));
  read_rows(table.get(), rows, H5T_NATIVE_INT64, members.data());
  for (std::size_t i = 0; i < members.size(); i += columns) {
    const bool has_cell = members[i] >= 0 && members[i] < head.num_cells;
    const bool has_part = dimension == 3 || (members[i + 1] >= 0 &&
                                             members[i + 1] < static_cast<std::int64_t>(num_local_parts(dimension)));
    if (has_cell && has_part) continue;
    throw MeshDefect(describe(head.groups[number]) + " has a member that is not part of any cell, in row " +
                     std::to_string(rows.first + static_cast<std::int64_t>(i / columns)) + cure);
  }
  return members;
}

/// Sends the members of groups to the ranks that have their cells. Collective.
Members sent_to_cells(MPI_Comm comm, const Members& members, std::size_t columns, std::int64_t num_cells,
                      int num_blocks) {
  std::vector<Members> out(static_cast<std::size_t>(num_ranks(comm)));
  for (std::size_t i = 0; i < members.size(); i += columns) {
    Members& list = out[static_cast<std::size_t>(rank_of_row(members[i], num_cells, num_blocks))];
    for (std::size_t k = 0; k < columns; ++k) list.push_back(members[i + k]);
  }
  return exchanged(comm, out);
}

/// Volumes list cells by their index in this rank's block, groups of other dimensions their nodes.
std::vector<PetscInt> in_block(const Members& members, int dimension, const MeshParts& parts, std::int64_t first_cell) {
  std::vector<PetscInt> result;
  if (dimension == 3) {
    for (const std::int64_t cell : members) result.push_back(static_cast<PetscInt>(cell - first_cell));
    return result;
  }
  for (std::size_t i = 0; i < members.size(); i += 2) {
    const auto cell = static_cast<std::size_t>(members[i] - first_cell);
    for (const int corner : local_part(dimension, static_cast<std::size_t>(members[i + 1]))) {
      result.push_back(parts.mesh.cells[4 * cell + static_cast<std::size_t>(corner)]);
    }
  }
  return result;
}

/// Cells, nodes and data.
void read_numbers(hid_t file, const Head& head, const Hdf5Rows& cells, const Hdf5Rows& nodes, SerialMesh& mesh) {
  mesh.coordinates.resize(3 * static_cast<std::size_t>(nodes.count));
  read_rows(Table(file, "nodes", H5T_FLOAT).get(), nodes, H5T_NATIVE_DOUBLE, mesh.coordinates.data());
  require_finite(mesh.coordinates, nodes.first);
  mesh.cells.resize(4 * static_cast<std::size_t>(cells.count));
  read_rows(Table(file, "cells", H5T_INTEGER).get(), cells, integer_type(), mesh.cells.data());
  require_cells(mesh.cells, cells.first, head.num_nodes);
  mesh.cell_data = head.cell_data;
  for (std::size_t d = 0; d < mesh.cell_data.size(); ++d) {
    auto& [name, components, values] = mesh.cell_data[d];
    values.resize(static_cast<std::size_t>(components * cells.count));
    read_rows(Table(file, data_path(d), H5T_FLOAT).get(), cells, H5T_NATIVE_DOUBLE, values.data());
  }
}

}  // namespace

bool is_mesh_file(const std::string& file) {
  const std::string extension = std::filesystem::path(file).extension().string();
  return extension == ".h5" || extension == ".hdf5";
}

// Every rank opens the file itself and reads contiguous rows: a collective read would gain nothing, and here the
// failure of one rank leaves no other waiting.
MeshParts read_mesh_file(MPI_Comm comm, const MeshSource& source) {
  const int r = rank(comm), size = num_ranks(comm);
  on_root(comm, [&] { telling_the_user(source, [&] { judge(source.file, size); }); });
  MeshParts parts;
  Head head;
  int num_blocks = size;  // of ranks that read
  std::vector<Members> members;
  Hdf5Rows cells;
  on_every_rank(comm, [&] {
    telling_the_user(source, [&] {
      reading(source.file, [&](hid_t file) {
        head = read_head(file);
        if (are_read_by_root(head.num_cells, size)) num_blocks = 1;
        const auto block_of = [&](std::int64_t num_rows) {
          return r < num_blocks ? block(num_rows, r, num_blocks) : Hdf5Rows{num_rows, 0};
        };
        cells = block_of(head.num_cells);
        const Hdf5Rows nodes = block_of(head.num_nodes);
        parts.num_vertices = static_cast<PetscInt>(nodes.count);
        parts.first_cell = static_cast<PetscInt>(cells.first);
        read_numbers(file, head, cells, nodes, parts.mesh);
        for (std::size_t g = 0; g < head.groups.size(); ++g) {
          members.push_back(read_members(file, g, head, block_of(head.num_members[g])));
        }
      });
    });
  });
  parts.held = num_blocks == 1 ? MeshParts::Held::on_root : MeshParts::Held::in_blocks;
  for (double& x : parts.mesh.coordinates) x *= source.scale;
  for (std::size_t g = 0; g < head.groups.size(); ++g) {
    const int dimension = head.groups[g].dimension;
    const Members mine = sent_to_cells(comm, members[g], dimension == 3 ? 1 : 2, head.num_cells, num_blocks);
    parts.mesh.groups.push_back({head.groups[g], in_block(mine, dimension, parts, cells.first)});
  }
  return parts;
}

}  // namespace pliant
