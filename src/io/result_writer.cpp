#include "io/result_writer.hpp"

#include "base/error.hpp"
#include "base/file.hpp"
#include "petsc/check.hpp"
#include "petsc/collective.hpp"
#include "petsc/hdf5.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cassert>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr std::chrono::seconds time_between_syncs{10};

void make_empty_file(const std::filesystem::path& path, const std::string& title) {
  const QuietHdf5 quiet;
  const std::string doing = "write '" + path.string() + "'";
  // A reader that waits for the file finds it complete.
  std::filesystem::path part = path;
  part += ".part";
  File(part, FileMode::anew).reserve(0, 256 * 1024);
  Hdf5Handle file = open_hdf5(part, Hdf5Mode::create);
  write_attribute(file.get(), "format", std::string("pliant-result"));
  write_attribute(file.get(), "version", result_version);
  write_attribute(file.get(), "title", title);
  make_frames_group(file.get(), "/frames");
  file.close(doing);
  replace_file(part, path, Durability::process);
}

std::string lines(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, "\n"));
}

/// The group of the mesh of the first run, and of those that continued it.
std::string name_of_mesh(std::int64_t number) {
  return number == 0 ? "mesh" : fmt::format("mesh_{}", number);
}

/// Numbers for what a run adds to the result that it continues.
struct Continuation {
  std::int64_t mesh_number;
  std::int64_t next_frame;
};

/// Removes the frames that `grids` does not refer to.
Continuation keep_listed(const std::filesystem::path& path, const std::string& grids) {
  const QuietHdf5 quiet;
  const std::string doing = "continue '" + path.string() + "'";
  Hdf5Handle file = open_hdf5(path, Hdf5Mode::modify);
  Hdf5Handle frames(H5Gopen2(file.get(), "frames", H5P_DEFAULT), H5Gclose, doing);
  Continuation next{0, 0};
  for (const auto& name : names_in(frames.get())) {
    if (grids.find(":/frames/" + name + "/") != std::string::npos) {
      next.next_frame = std::stoll(name) + 1;
    } else {
      check_hdf5(H5Ldelete(frames.get(), name.c_str(), H5P_DEFAULT), doing);
    }
  }
  const auto taken = names_in(file.get());
  while (std::ranges::find(taken, name_of_mesh(next.mesh_number)) != taken.end()) ++next.mesh_number;
  frames.close(doing);
  file.close(doing);
  return next;
}

}  // namespace

ResultWriter::ResultWriter(MPI_Comm comm, const ResultPlace& place, std::string title, const OutputMesh& mesh)
    : ResultWriter(comm, place, std::move(title), mesh, /*last_step=*/-1) {}

ResultWriter::ResultWriter(MPI_Comm comm, const ResultPlace& place, std::string title, const OutputMesh& mesh,
                           std::int64_t last_step)
    : comm_(comm),
      title_(std::move(title)),
      hdf5_file_(place.directory / (place.name + ".h5")),
      xdmf_file_(place.directory / (place.name + ".xdmf")),
      nodes_per_cell_(mesh.nodes_per_cell),
      nodes_{mesh.first_node, std::ssize(mesh.coordinates) / 3, mesh.global_num_nodes},
      cells_(row_block(comm, std::ssize(mesh.bodies))) {
  assert(nodes_per_cell_ == 4 || nodes_per_cell_ == 10);
  on_root(comm_, [&] {
    make_directory(place.directory);
    grids_ = listed_frames(xdmf_file_, last_step);
    std::error_code ignored;
    if (!std::filesystem::exists(hdf5_file_, ignored)) grids_.clear();  // the frames have been removed from outside
    if (grids_.empty()) {
      start_files();
    } else {
      write_text_atomically(xdmf_file_, xdmf_document(title_, grids_));
      const Continuation next = hdf5_in_child(hdf5_file_, [&] { return keep_listed(hdf5_file_, grids_); });
      mesh_ = name_of_mesh(next.mesh_number);
      next_frame_ = next.next_frame;
    }
  });
  mesh_ = broadcast(comm_, mesh_);
  check_mpi(MPI_Bcast(&next_frame_, 1, MPI_INT64_T, 0, comm_));
  write_mesh(mesh);
  write_groups(mesh);
  on_root(comm_, [&] { write_text_atomically(xdmf_file_, xdmf_document(title_, grids_)); });
}

void ResultWriter::start_files() const {
  // The old lists of frames are removed first, so that they never describe the new file. The old data are removed and
  // not emptied, which does not disturb a reader that has them open. A failure shows when the new files are created.
  std::error_code ignored;
  std::filesystem::remove(xdmf_file_, ignored);
  for (const char* companion : companions) std::filesystem::remove(companion_file(companion), ignored);
  std::filesystem::remove(hdf5_file_, ignored);
  make_empty_file(hdf5_file_, title_);
}

void ResultWriter::write_mesh(const OutputMesh& mesh) const {
  using enum XdmfArray::Number;
  const std::vector<std::int32_t> bodies(mesh.bodies.begin(), mesh.bodies.end());
  const std::vector<std::int32_t> ranks(mesh.bodies.size(), rank(comm_));
  std::vector<std::pair<std::string, std::string>> names{{"names", lines(mesh.body_names)}};
  if (!mesh.masses.empty()) names.emplace_back("masses", lines(mesh.masses));
  if (!mesh.rigid.empty()) names.emplace_back("rigid", lines(mesh.rigid));
  if (!mesh.rods.empty()) names.emplace_back("rods", lines(mesh.rods));
  if (!mesh.rectangular_rods.empty()) names.emplace_back("rectangular_rods", lines(mesh.rectangular_rods));
  if (!mesh.sections.empty()) names.emplace_back("sections", lines(mesh.sections));
  if (!mesh.shells.empty()) names.emplace_back("shells", lines(mesh.shells));
  Group group{"/", mesh_, [](hid_t) {}, {}};
  group.datasets = {{"coordinates", float64, nodes_, 3, std::as_bytes(std::span(mesh.coordinates)), {{"unit", "m"}}},
                    {"cells", int64, cells_, nodes_per_cell_, std::as_bytes(std::span(mesh.cells)), {}},
                    {"body", int32, cells_, 1, std::as_bytes(std::span(bodies)), std::move(names)},
                    {"rank", int32, cells_, 1, std::as_bytes(std::span(ranks)), {}}};
  add_group(comm_, hdf5_file_, group, Durability::process);
}

void ResultWriter::write_groups(const OutputMesh& mesh) const {
  if (mesh.groups.empty()) return;
  const int nodes_per_facet = nodes_per_cell_ == 4 ? 3 : 6;
  std::vector<std::int64_t> nodes, facets, cells;
  std::vector<std::string> names, dimensions;
  for (std::size_t g = 0; g < mesh.groups.size(); ++g) {
    const OutputGroup& group = mesh.groups[g];
    names.push_back(group.name);
    dimensions.push_back(std::to_string(group.dimension));
    std::vector<std::int64_t>& rows = group.dimension == 3 ? cells : group.dimension == 2 ? facets : nodes;
    const std::size_t width = group.dimension == 2 ? static_cast<std::size_t>(nodes_per_facet) : 1;
    for (std::size_t i = 0; i < group.entries.size(); ++i) {
      if (i % width == 0) rows.push_back(static_cast<std::int64_t>(g));
      rows.push_back(group.entries[i]);
    }
  }
  std::string name = mesh_;
  name.replace(0, std::string_view("mesh").size(), "groups");
  Group group{"/", name, {}, {}};
  group.write_attributes = [&](hid_t written) {
    write_attribute(written, "names", lines(names));
    write_attribute(written, "dimensions", lines(dimensions));
  };
  const auto add = [&](const char* dataset, const std::vector<std::int64_t>& rows, int columns) {
    const RowBlock block = row_block(comm_, std::ssize(rows) / columns);
    if (block.num_global == 0) return;
    group.datasets.push_back({dataset, XdmfArray::Number::int64, block, columns, std::as_bytes(std::span(rows)), {}});
  };
  add("nodes", nodes, 2);
  add("facets", facets, 1 + nodes_per_facet);
  add("cells", cells, 2);
  add_group(comm_, hdf5_file_, group, Durability::process);
}

void ResultWriter::write_frame(double time, std::int64_t step, std::span<const OutputField> fields,
                               const std::string& label) {
  Group group{"/frames", fmt::format("{:06}", next_frame_++), {}, {}};
  group.write_attributes = [&](hid_t frame) {
    write_attribute(frame, "time", time);
    write_attribute(frame, "step", step);
    write_attribute(frame, "mesh", "/" + mesh_);
    if (!label.empty()) write_attribute(frame, "label", label);
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
  add_group(comm_, hdf5_file_, group, Durability::process);
  int is_old = 0;
  on_root(comm_, [&] {
    XdmfGrid grid = grid_of_frame("/frames/" + group.name, fields);
    grid.name = label.empty() ? fmt::format("step {}", step) : label;
    grid.time = time;
    grid.step = step;
    const std::string grids = grids_ + to_xml(grid);
    write_text_atomically(xdmf_file_, xdmf_document(title_, grids), Durability::process);
    grids_ = grids;
    is_old = std::chrono::steady_clock::now() - synced_ > time_between_syncs ? 1 : 0;
  });
  check_mpi(MPI_Bcast(&is_old, 1, MPI_INT, 0, comm_));
  if (is_old != 0) bring_to_disk();
}

void ResultWriter::sync() {
  on_root(comm_, [&] { cut_to_content(hdf5_file_); });
  bring_to_disk();
}

void ResultWriter::bring_to_disk() {
  on_every_rank(comm_, [&] {
    File file(hdf5_file_, FileMode::modify);
    file.sync();
    file.close();
  });
  on_root(comm_, [&] {
    File file(xdmf_file_, FileMode::modify);
    file.sync();
    file.close();
  });
  synced_ = std::chrono::steady_clock::now();
}

XdmfArray ResultWriter::array(const std::string& place, XdmfArray::Number number, const RowBlock& rows,
                              int columns) const {
  return {hdf5_file_.filename().string() + ":" + place, number, rows.num_global, columns};
}

std::filesystem::path ResultWriter::companion_file(const std::string& companion) const {
  return xdmf_file_.parent_path() / (xdmf_file_.stem().string() + "_" + companion + ".xdmf");
}

XdmfGrid ResultWriter::grid_of_frame(const std::string& group, std::span<const OutputField> fields) const {
  XdmfGrid grid;
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
  return grid;
}

}  // namespace pliant
