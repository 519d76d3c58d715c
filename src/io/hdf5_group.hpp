/// Groups of datasets in an HDF5 file that all ranks write to without HDF5's MPI-IO driver.
#pragma once

#include "base/file.hpp"
#include "io/xdmf.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <hdf5.h>
#include <petscsys.h>

namespace pliant {

/// A block of rows of a global array: which of them this rank owns.
struct RowBlock {
  std::int64_t first = 0;
  std::int64_t num_owned = 0;
  std::int64_t num_global = 0;
};

/// Rows owned by the ranks before this one, and by all. Collective.
RowBlock row_block(MPI_Comm comm, std::int64_t num_owned);

/// A rows x columns dataset spread over the ranks, and this rank's rows.
struct Dataset {
  std::string name;
  XdmfArray::Number number = XdmfArray::Number::float64;
  RowBlock rows;
  int columns = 1;
  std::span<const std::byte> owned;
  std::vector<std::pair<std::string, std::string>> attributes;
};

/// A group to be added to the file with all its datasets.
struct Group {
  std::string parent;
  std::string name;
  std::function<void(hid_t)> write_attributes;
  std::vector<Dataset> datasets;
};

/// Creates an empty group of frames to which a frame is added by one write of one block, which a kill cannot cut in
/// two: its links lie in its header, with room for 2000 of them; later ones take two writes each. (An ordinary group
/// spreads a new link over a B-tree, a heap and a symbol table, and is unreadable if the process dies between.) Not
/// collective.
void make_frames_group(hid_t file, const std::string& path);

/// Adds a group with its datasets to the file. Only metadata go through HDF5, on rank 0; every rank then writes its
/// rows directly to their place in the file. The group is linked after its numbers are written, so it is complete or
/// absent. With Durability::process, for files that are read while they grow, the file then ends with a hole for the
/// next group, so that readers that know an older size can read what is added. Collective; a failure throws FileError
/// on every rank.
void add_group(MPI_Comm comm, const std::filesystem::path& path, const Group& plan, Durability durability);

/// Removes the hole that add_group leaves. Not collective.
void cut_to_content(const std::filesystem::path& path);

}  // namespace pliant
