#include "io/result_writer.hpp"

#include "base/error.hpp"
#include "base/file.hpp"
#include "petsc/check.hpp"
#include "petsc/collective.hpp"
#include "petsc/hdf5.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cassert>
#include <fstream>
#include <functional>
#include <optional>
#include <sstream>
#include <system_error>
#include <tuple>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// A rows x columns dataset spread over the ranks, and this rank's rows.
struct Dataset {
  std::string name;
  XdmfArray::Number number = XdmfArray::Number::float64;
  RowBlock rows;
  int columns = 1;
  std::span<const std::byte> owned;
  std::vector<std::pair<std::string, std::string>> attributes;
};

/// A group to be added to the file with all that belongs to it.
struct Group {
  std::string parent;
  std::string name;
  std::function<void(hid_t)> write_attributes;
  std::vector<Dataset> datasets;
};

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

/// Rows owned by the ranks before this one, and by all. Collective.
RowBlock row_block(MPI_Comm comm, std::int64_t num_owned) {
  RowBlock rows{0, num_owned, 0};
  check_mpi(MPI_Exscan(&rows.num_owned, &rows.first, 1, MPI_INT64_T, MPI_SUM, comm));
  if (rank(comm) == 0) rows.first = 0;  // MPI_Exscan leaves it undefined there
  check_mpi(MPI_Allreduce(&rows.num_owned, &rows.num_global, 1, MPI_INT64_T, MPI_SUM, comm));
  return rows;
}

/// Makes a dataset with its space in the file, unwritten. Returns where its first row lies [bytes], -1 if it has none.
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
  if (offset == HADDR_UNDEF) throw FileError("cannot " + doing + ": HDF5 gave it no place in the file");
  return static_cast<std::int64_t>(offset);
}

/// A group under construction, on rank 0: everything in it is in the file, but no path leads to it before `publish`.
/// Dropped unpublished, it leaves no trace.
class UnpublishedGroup {
 public:
  UnpublishedGroup(const std::filesystem::path& path, const Group& plan) : path_(path.string()) {
    reserve_space(plan);
    file_ = open_hdf5(path_, Hdf5Mode::modify);
    const std::string doing = "write '" + path_ + "'";
    group_ = Hdf5Handle(H5Gcreate_anon(file_.get(), H5P_DEFAULT, H5P_DEFAULT), H5Gclose, doing);
    plan.write_attributes(group_.get());
    for (const auto& dataset : plan.datasets) offsets_.push_back(make_dataset(group_.get(), dataset));
    check_hdf5(H5Fflush(file_.get(), H5F_SCOPE_LOCAL), doing);
  }

  const std::vector<std::int64_t>& offsets() const { return offsets_; }

  void publish(const Group& plan) {
    const std::string doing = "write '" + path_ + "'";
    const Hdf5Handle parent(H5Gopen2(file_.get(), plan.parent.c_str(), H5P_DEFAULT), H5Gclose, doing);
    check_hdf5(H5Olink(group_.get(), parent.get(), plan.name.c_str(), H5P_DEFAULT, H5P_DEFAULT), doing);
    group_.close(doing);
    file_.close(doing);
    File file(path_, FileMode::modify);
    file.sync();
    file.close();
  }

 private:
  /// HDF5 does not survive a full disk (it crashes when the process ends): take the space before it starts. What is too
  /// much it cuts off when it closes the file.
  void reserve_space(const Group& plan) const {
    constexpr std::int64_t metadata = 64 * 1024;  // [bytes], several times of what a group of a few datasets takes
    std::int64_t needed = metadata;
    for (const auto& dataset : plan.datasets) needed += metadata / 8 + dataset.rows.num_global * bytes_per_row(dataset);
    File file(path_, FileMode::modify);
    file.reserve(needed);
    file.close();
  }

  QuietHdf5 quiet_;
  std::string path_;
  Hdf5Handle file_;
  Hdf5Handle group_;
  std::vector<std::int64_t> offsets_;
};

/// Adds a group with its datasets to the file. Collective; a failure throws on every rank.
void add_group(MPI_Comm comm, const std::filesystem::path& path, const Group& plan) {
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
    group.emplace(path, plan);
    offsets = group->offsets();
  });
  check_mpi(MPI_Bcast(offsets.data(), static_cast<int>(offsets.size()), MPI_INT64_T, 0, comm));
  on_every_rank(comm, [&] {
    File file(path, FileMode::modify);
    for (std::size_t i = 0; i < offsets.size(); ++i) {
      const Dataset& dataset = plan.datasets[i];
      if (offsets[i] >= 0) file.write_at(offsets[i] + dataset.rows.first * bytes_per_row(dataset), dataset.owned);
    }
    file.sync();
    file.close();
  });
  on_root(comm, [&] { group->publish(plan); });
}

/// Makes the group of the frames such that adding a frame is one write of one block, which a kill cannot cut in two:
/// its links lie in its header, with room for 2000 of them; later ones take two writes each. (An ordinary group spreads
/// a new link over a B-tree, a heap and a symbol table, and is unreadable if the process dies between.)
void make_frames_group(hid_t file) {
  constexpr unsigned expected_frames = 2000;  // more would not fit the 64 KiB of a header block
  constexpr unsigned name_length = 6;
  const std::string doing = "make the group '/frames'";
  const Hdf5Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, doing);
  check_hdf5(H5Pset_link_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED), doing);
  check_hdf5(H5Pset_link_phase_change(creation.get(), /*max_compact=*/65535, /*min_dense=*/0), doing);
  check_hdf5(H5Pset_est_link_info(creation.get(), expected_frames, name_length), doing);
  Hdf5Handle frames(H5Gcreate2(file, "frames", H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Gclose, doing);
  frames.close(doing);
}

void make_empty_file(const std::filesystem::path& path, const std::string& title) {
  const QuietHdf5 quiet;
  const std::string doing = "write '" + path.string() + "'";
  File(path, FileMode::create).reserve(256 * 1024);
  Hdf5Handle file = open_hdf5(path, Hdf5Mode::create);
  write_attribute(file.get(), "format", std::string("pliant-result"));
  write_attribute(file.get(), "version", std::int64_t{1});
  write_attribute(file.get(), "title", title);
  make_frames_group(file.get());
  file.close(doing);
}

std::string lines(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, "\n"));
}

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

herr_t append_name(hid_t, const char* name, const H5L_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

std::vector<std::string> names_in(hid_t group) {
  std::vector<std::string> names;
  check_hdf5(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, append_name, &names), "list a group");
  return names;
}

/// Removes the frames that `grids` does not refer to. Returns the number of the next frame and a name for the next
/// mesh.
std::pair<std::int64_t, std::string> keep_listed(const std::filesystem::path& path, const std::string& grids) {
  const QuietHdf5 quiet;
  const std::string doing = "continue '" + path.string() + "'";
  Hdf5Handle file = open_hdf5(path, Hdf5Mode::modify);
  Hdf5Handle frames(H5Gopen2(file.get(), "frames", H5P_DEFAULT), H5Gclose, doing);
  std::int64_t next = 0;
  for (const auto& name : names_in(frames.get())) {
    if (grids.find(":/frames/" + name + "/") != std::string::npos) {
      next = std::stoll(name) + 1;
    } else {
      check_hdf5(H5Ldelete(frames.get(), name.c_str(), H5P_DEFAULT), doing);
    }
  }
  std::string mesh = "mesh";
  const auto taken = names_in(file.get());
  for (int i = 1; std::find(taken.begin(), taken.end(), mesh) != taken.end(); ++i) mesh = fmt::format("mesh_{}", i);
  frames.close(doing);
  file.close(doing);
  return {next, mesh};
}

}  // namespace

ResultWriter::ResultWriter(MPI_Comm comm, const std::filesystem::path& directory, std::string title,
                           const OutputMesh& mesh)
    : ResultWriter(comm, directory, std::move(title), mesh, /*last_step=*/-1) {}

ResultWriter::ResultWriter(MPI_Comm comm, const std::filesystem::path& directory, std::string title,
                           const OutputMesh& mesh, std::int64_t last_step)
    : comm_(comm),
      title_(std::move(title)),
      hdf5_file_(directory / "result.h5"),
      xdmf_file_(directory / "result.xdmf"),
      nodes_per_cell_(mesh.nodes_per_cell),
      nodes_{mesh.first_node, std::ssize(mesh.coordinates) / 3, mesh.global_num_nodes},
      cells_(row_block(comm, std::ssize(mesh.bodies))) {
  assert(nodes_per_cell_ == 4 || nodes_per_cell_ == 10);
  on_root(comm_, [&] {
    make_directory(directory);
    grids_ = grids_up_to_step(text_of(xdmf_file_), last_step);
    if (grids_.empty()) {
      start_files();
    } else {
      write_text_atomically(xdmf_file_, xdmf_document(title_, grids_));
      std::tie(next_frame_, mesh_) = keep_listed(hdf5_file_, grids_);
    }
  });
  mesh_ = broadcast(comm_, mesh_);
  check_mpi(MPI_Bcast(&next_frame_, 1, MPI_INT64_T, 0, comm_));
  write_mesh(mesh);
  on_root(comm_, [&] { write_text_atomically(xdmf_file_, xdmf_document(title_, grids_)); });
}

void ResultWriter::start_files() const {
  // The old list of frames goes first, so that it never describes the new file; removing the old numbers, rather than
  // emptying them, leaves a reader that has them open undisturbed. A failure shows when the new files are made.
  std::error_code ignored;
  std::filesystem::remove(xdmf_file_, ignored);
  std::filesystem::remove(hdf5_file_, ignored);
  make_empty_file(hdf5_file_, title_);
}

void ResultWriter::write_mesh(const OutputMesh& mesh) const {
  using enum XdmfArray::Number;
  const std::vector<std::int32_t> bodies(mesh.bodies.begin(), mesh.bodies.end());
  const std::vector<std::int32_t> ranks(mesh.bodies.size(), rank(comm_));
  Group group{"/", mesh_, [](hid_t) {}, {}};
  group.datasets = {{"coordinates", float64, nodes_, 3, std::as_bytes(std::span(mesh.coordinates)), {{"unit", "m"}}},
                    {"cells", int64, cells_, nodes_per_cell_, std::as_bytes(std::span(mesh.cells)), {}},
                    {"body", int32, cells_, 1, std::as_bytes(std::span(bodies)), {{"names", lines(mesh.body_names)}}},
                    {"rank", int32, cells_, 1, std::as_bytes(std::span(ranks)), {}}};
  add_group(comm_, hdf5_file_, group);
}

void ResultWriter::write_frame(double time, std::int64_t step, std::span<const OutputField> fields) {
  Group group{"/frames", fmt::format("{:06}", next_frame_++), {}, {}};
  group.write_attributes = [&](hid_t frame) {
    write_attribute(frame, "time", time);
    write_attribute(frame, "step", step);
    write_attribute(frame, "mesh", "/" + mesh_);
  };
  for (const auto& field : fields) {
    const std::string location = field.location == FieldLocation::node ? "node" : "cell";
    group.datasets.push_back({field.name,
                              XdmfArray::Number::float64,
                              rows_of(field.location),
                              field.components,
                              std::as_bytes(field.values),
                              {{"unit", field.unit}, {"location", location}}});
  }
  add_group(comm_, hdf5_file_, group);
  on_root(comm_, [&] {
    const std::string grids = grids_ + grid_of_frame(time, step, "/frames/" + group.name, fields);
    write_text_atomically(xdmf_file_, xdmf_document(title_, grids));
    grids_ = grids;
  });
}

XdmfArray ResultWriter::array(const std::string& place, XdmfArray::Number number, const RowBlock& rows,
                              int columns) const {
  return {hdf5_file_.filename().string() + ":" + place, number, rows.num_global, columns};
}

std::string ResultWriter::grid_of_frame(double time, std::int64_t step, const std::string& group,
                                        std::span<const OutputField> fields) const {
  XdmfGrid grid;
  grid.name = fmt::format("step {}", step);
  grid.time = time;
  grid.step = step;
  grid.cells = array("/" + mesh_ + "/cells", XdmfArray::Number::int64, cells_, nodes_per_cell_);
  grid.coordinates = array("/" + mesh_ + "/coordinates", XdmfArray::Number::float64, nodes_, 3);
  for (const auto& field : fields) {
    const auto center = field.location == FieldLocation::node ? XdmfField::Center::node : XdmfField::Center::cell;
    grid.fields.push_back(
        {field.name, field.unit, center,
         array(group + "/" + field.name, XdmfArray::Number::float64, rows_of(field.location), field.components)});
  }
  for (const std::string name : {"body", "rank"}) {
    grid.fields.push_back(
        {name, "", XdmfField::Center::cell, array("/" + mesh_ + "/" + name, XdmfArray::Number::int32, cells_, 1)});
  }
  return to_xml(grid);
}

}  // namespace pliant
