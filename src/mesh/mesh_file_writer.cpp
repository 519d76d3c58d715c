#include "mesh/mesh_file_writer.hpp"

#include "base/file.hpp"
#include "mesh/mesh_file.hpp"
#include "mesh/part_search.hpp"
#include "mesh/space_curve.hpp"
#include "petsc/hdf5.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

namespace pliant {
namespace {

using Member = std::array<std::int64_t, 2>;  // a cell, and the index of its facet, edge or corner

std::vector<Member> members_of(const PartSearch& search, const SerialGroup& group, std::vector<std::string>& notices) {
  const auto size = static_cast<std::size_t>(group.group.dimension) + 1;
  std::vector<Member> members;
  for (std::size_t i = 0; i + size <= group.members.size(); i += size) {
    std::optional<Member> first;
    search({&group.members[i], size}, [&](std::size_t cell, std::size_t part) {
      if (!first) first = {static_cast<std::int64_t>(cell), static_cast<std::int64_t>(part)};
    });
    if (first) members.push_back(*first);
  }
  notice_left_out(group, members.size(), notices);
  std::ranges::sort(members);
  members.erase(std::unique(members.begin(), members.end()), members.end());
  return members;
}

void write_group(hid_t groups, const std::string& number, const PartSearch& search, const SerialGroup& group,
                 std::vector<std::string>& notices) {
  if (group.group.dimension == 3) {
    std::vector<std::int64_t> cells(group.members.begin(), group.members.end());
    std::ranges::sort(cells);
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    write_dataset(groups, number, {cells.size()}, H5T_NATIVE_INT64, cells.data());
  } else {
    const std::vector<Member> members = members_of(search, group, notices);
    write_dataset(groups, number, {members.size(), 2}, H5T_NATIVE_INT64, members.data());
  }
  const Hdf5Handle dataset(H5Dopen2(groups, number.c_str(), H5P_DEFAULT), H5Dclose, "open a group");
  write_attribute(dataset.get(), "dimension", std::int64_t{group.group.dimension});
  write_attribute(dataset.get(), "tag", std::int64_t{group.group.tag});
  write_attribute(dataset.get(), "name", group.group.name);
}

Hdf5Handle make_group(hid_t parent, const char* name) {
  return {H5Gcreate2(parent, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, "make a group"};
}

void write_numbers(hid_t file, SerialMesh& mesh) {
  write_attribute(file, "format", std::string(mesh_file_format));
  write_attribute(file, "version", mesh_file_version);
  write_dataset(file, "nodes", {mesh.num_nodes(), 3}, H5T_NATIVE_DOUBLE, mesh.coordinates.data());
  const hid_t integer = sizeof(PetscInt) == 8 ? H5T_NATIVE_INT64 : H5T_NATIVE_INT32;
  write_dataset(file, "cells", {mesh.num_cells(), 4}, integer, mesh.cells.data());
  const PartSearch search(mesh.cells);
  const Hdf5Handle groups = make_group(file, "groups");
  for (std::size_t g = 0; g < mesh.groups.size(); ++g) {
    write_group(groups.get(), std::to_string(g), search, mesh.groups[g], mesh.notices);
  }
  const Hdf5Handle all_data = make_group(file, "cell_data");
  for (std::size_t d = 0; d < mesh.cell_data.size(); ++d) {
    const CellField& data = mesh.cell_data[d];
    write_dataset(all_data.get(), std::to_string(d), {mesh.num_cells(), static_cast<hsize_t>(data.components)},
                  H5T_NATIVE_DOUBLE, data.values.data());
    const Hdf5Handle dataset(H5Dopen2(all_data.get(), std::to_string(d).c_str(), H5P_DEFAULT), H5Dclose, "open data");
    write_attribute(dataset.get(), "name", data.name);
  }
}

/// An upper bound of the file's size: HDF5 does not survive a full disk.
std::int64_t largest_size(const SerialMesh& mesh) {
  std::size_t numbers = mesh.coordinates.size() + mesh.cells.size() + 64 * 1024;
  for (const auto& group : mesh.groups) numbers += 2 * group.members.size();
  for (const auto& data : mesh.cell_data) numbers += data.values.size();
  return static_cast<std::int64_t>(8 * numbers);
}

}  // namespace

void write_mesh_file(const std::string& file, SerialMesh& mesh) {
  if (mesh.geometry_order() != 1) {
    throw MeshDefect(
        "its second-order tetrahedra are curved, but the HDF5 format supports only straight ones: mesh it with "
        "first-order elements (Mesh.ElementOrder = 1), or use the file itself");
  }
  sort_along_curve(mesh);
  // The file gets this name only when it is complete.
  const std::string part = file + ".part";
  const QuietHdf5 quiet;
  try {
    File(part, FileMode::anew).reserve(0, largest_size(mesh));
    Hdf5Handle out = open_hdf5(part, Hdf5Mode::create);
    write_numbers(out.get(), mesh);
    out.close("write '" + file + "'");
    replace_file(part, file, Durability::process);
  } catch (const std::exception& e) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    const std::string reason = e.what();
    throw FileError(reason.find(file) != std::string::npos ? reason : "cannot write '" + file + "': " + reason);
  }
}

}  // namespace pliant
