#include "io/hdf5_group.hpp"

#include "base/error.hpp"
#include "base/file.hpp"
#include "petsc/check.hpp"
#include "petsc/collective.hpp"
#include "petsc/hdf5.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

namespace pliant {
namespace {

hid_t hdf5_type(XdmfArray::Number number) {
  switch (number) {
    case XdmfArray::Number::float64:
      return H5T_NATIVE_DOUBLE;
    case XdmfArray::Number::int64:
      return H5T_NATIVE_INT64;
    case XdmfArray::Number::int32:
      break;
  }
  return H5T_NATIVE_INT32;
}

std::int64_t size_of_number(XdmfArray::Number number) {
  return number == XdmfArray::Number::int32 ? 4 : 8;
}

std::int64_t bytes_per_row(const Dataset& dataset) {
  return dataset.columns * size_of_number(dataset.number);
}

/// Creates a dataset with its space in the file, unwritten. Returns the offset of its first row [bytes], -1 if it has
/// none.
std::int64_t make_dataset(hid_t group, const Dataset& dataset) {
  const std::string doing = "make the dataset '" + dataset.name + "'";
  const hsize_t sizes[2] = {static_cast<hsize_t>(dataset.rows.num_global), static_cast<hsize_t>(dataset.columns)};
  const Hdf5Handle space(H5Screate_simple(dataset.columns == 1 ? 1 : 2, sizes, nullptr), H5Sclose, doing);
  const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, doing);
  check_hdf5(H5Pset_layout(creation.get(), H5D_CONTIGUOUS), doing);
  check_hdf5(H5Pset_alloc_time(creation.get(), H5D_ALLOC_TIME_EARLY), doing);
  check_hdf5(H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER), doing);
  const Hdf5Handle made(H5Dcreate2(group, dataset.name.c_str(), hdf5_type(dataset.number), space.get(), H5P_DEFAULT,
                                   creation.get(), H5P_DEFAULT),
                        H5Dclose, doing);
  for (const auto& [name, value] : dataset.attributes) write_attribute(made.get(), name, value);
  if (dataset.rows.num_global == 0) return -1;
  const haddr_t offset = H5Dget_offset(made.get());
  if (offset == HADDR_UNDEF) throw FileError("cannot " + doing + ": HDF5 allocated no space for it in the file");
  return static_cast<std::int64_t>(offset);
}

/// The end of the file for HDF5, which may be beyond its size [bytes].
std::int64_t end_of_content(const std::filesystem::path& path) {
  const std::string doing = "read '" + path.string() + "'";
  const Hdf5Handle file = open_hdf5(path, Hdf5Mode::read);
  haddr_t end = 0;
  check_hdf5(H5Fget_eoa(file.get(), &end), doing);
  return static_cast<std::int64_t>(end);
}

/// An upper bound of the group's size in the file [bytes].
std::int64_t space_of(const Group& plan) {
  constexpr std::int64_t metadata = 64 * 1024;  // several times of what a group of a few datasets takes
  std::int64_t space = metadata;
  for (const auto& dataset : plan.datasets) space += metadata / 8 + dataset.rows.num_global * bytes_per_row(dataset);
  return space;
}

/// A group under construction, on rank 0: everything in it is in the file, but no path leads to it before `publish`.
/// Dropped unpublished, it leaves no trace. Its header says from the start that one link leads to it: a program that is
/// killed while HDF5 writes that link, then the number of links, or the other way round, leaves them in agreement.
class UnpublishedGroup {
 public:
  UnpublishedGroup(const std::filesystem::path& path, const Group& plan, Durability durability)
      : path_(path.string()), durability_(durability) {
    reserve_space(plan);
    file_ = open_hdf5(path_, Hdf5Mode::modify);
    const std::string doing = "write '" + path_ + "'";
    group_ = Hdf5Handle(H5Gcreate_anon(file_.get(), H5P_DEFAULT, H5P_DEFAULT), H5Gclose, doing);
    plan.write_attributes(group_.get());
    for (const auto& dataset : plan.datasets) offsets_.push_back(make_dataset(group_.get(), dataset));
    check_hdf5(H5Oincr_refcount(group_.get()), doing);
    check_hdf5(H5Fflush(file_.get(), H5F_SCOPE_LOCAL), doing);
    leave_hole(plan);  // HDF5 has just cut off the excess
  }
  ~UnpublishedGroup() {
    if (group_.get() >= 0) H5Odecr_refcount(group_.get());
  }
  UnpublishedGroup(const UnpublishedGroup&) = delete;
  UnpublishedGroup& operator=(const UnpublishedGroup&) = delete;

  const std::vector<std::int64_t>& offsets() const { return offsets_; }

  void publish(const Group& plan) {
    const std::string doing = "write '" + path_ + "'";
    const Hdf5Handle parent(H5Gopen2(file_.get(), plan.parent.c_str(), H5P_DEFAULT), H5Gclose, doing);
    check_hdf5(H5Olink(group_.get(), parent.get(), plan.name.c_str(), H5P_DEFAULT, H5P_DEFAULT), doing);
    check_hdf5(H5Odecr_refcount(group_.get()), doing);
    group_.close(doing);
    file_.close(doing);
    leave_hole(plan);
    if (durability_ == Durability::process) return;
    File file(path_, FileMode::modify);
    file.sync();
    file.close();
  }

 private:
  /// HDF5 does not survive a full disk (it crashes when the process ends), so the space is reserved before it starts.
  /// HDF5 cuts off the excess when it closes the file. The hole that the last group left is kept: a reader that queries
  /// the size just then could not read this group.
  void reserve_space(const Group& plan) const {
    File file(path_, FileMode::modify);
    file.reserve(end_of_content(path_), space_of(plan));
    file.close();
  }

  /// A reader queries the size of the file, then reads up to HDF5's end of it; if that is beyond the size because a
  /// group was added in between, it gives up, and ParaView with it. A sparse hole, without blocks on disk, has room for
  /// the next group.
  void leave_hole(const Group& plan) const {
    if (durability_ != Durability::process) return;
    File file(path_, FileMode::modify);
    file.resize(std::max(file.size(), end_of_content(path_) + space_of(plan)));
    file.close();
  }

  QuietHdf5 quiet_;
  std::string path_;
  Durability durability_;
  Hdf5Handle file_;
  Hdf5Handle group_;
  std::vector<std::int64_t> offsets_;
};

}  // namespace

RowBlock row_block(MPI_Comm comm, std::int64_t num_owned) {
  RowBlock rows{0, num_owned, 0};
  check_mpi(MPI_Exscan(&rows.num_owned, &rows.first, 1, MPI_INT64_T, MPI_SUM, comm));
  if (rank(comm) == 0) rows.first = 0;  // MPI_Exscan leaves it undefined there
  check_mpi(MPI_Allreduce(&rows.num_owned, &rows.num_global, 1, MPI_INT64_T, MPI_SUM, comm));
  return rows;
}

void make_frames_group(hid_t file, const std::string& path) {
  constexpr unsigned expected_frames = 2000;  // more would not fit the 64 KiB of a header block
  constexpr unsigned name_length = 6;
  const std::string doing = "make the group '" + path + "'";
  const Hdf5Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, doing);
  check_hdf5(H5Pset_link_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED), doing);
  check_hdf5(H5Pset_link_phase_change(creation.get(), /*max_compact=*/65535, /*min_dense=*/0), doing);
  check_hdf5(H5Pset_est_link_info(creation.get(), expected_frames, name_length), doing);
  Hdf5Handle frames(H5Gcreate2(file, path.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Gclose, doing);
  frames.close(doing);
}

void add_group(MPI_Comm comm, const std::filesystem::path& path, const Group& plan, Durability durability) {
  on_every_rank(comm, [&] {
    for (const auto& dataset : plan.datasets) {
      if (std::ssize(dataset.owned) != dataset.rows.num_owned * bytes_per_row(dataset)) {
        throw std::logic_error(fmt::format("output '{}': {} bytes for {} rows of {} columns", dataset.name,
                                           dataset.owned.size(), dataset.rows.num_owned, dataset.columns));
      }
    }
  });
  std::optional<UnpublishedGroup> group;  // on rank 0
  std::vector<std::int64_t> offsets(plan.datasets.size(), -1);
  on_root(comm, [&] {
    group.emplace(path, plan, durability);
    offsets = group->offsets();
  });
  check_mpi(MPI_Bcast(offsets.data(), static_cast<int>(offsets.size()), MPI_INT64_T, 0, comm));
  on_every_rank(comm, [&] {
    File file(path, FileMode::modify);
    for (std::size_t i = 0; i < offsets.size(); ++i) {
      const Dataset& dataset = plan.datasets[i];
      if (offsets[i] >= 0) file.write_at(offsets[i] + dataset.rows.first * bytes_per_row(dataset), dataset.owned);
    }
    if (durability == Durability::power) file.sync();
    file.close();
  });
  on_root(comm, [&] { group->publish(plan); });
}

void cut_to_content(const std::filesystem::path& path) {
  const QuietHdf5 quiet;
  File file(path, FileMode::modify);
  file.resize(end_of_content(path));
  file.close();
}

}  // namespace pliant
