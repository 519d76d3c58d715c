#include "io/obstacle_writer.hpp"

#include "petsc/collective.hpp"
#include "petsc/hdf5.hpp"
#include "petsc/session.hpp"

#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

template <class T>
std::span<const std::byte> on_rank_0(MPI_Comm comm, std::span<const T> values) {
  return std::as_bytes(rank(comm) == 0 ? values : values.first(0));
}

}  // namespace

std::string obstacles_beside(std::string_view mesh_group) {
  constexpr std::string_view stem = "mesh";
  const std::size_t at = mesh_group.find(stem);
  return "obstacles" + std::string(at < mesh_group.size() ? mesh_group.substr(at + stem.size()) : "");
}

ObstacleWriter::ObstacleWriter(MPI_Comm comm, const ResultWriter& bodies, std::string title,
                               const OutputObstacles& obstacles, std::int64_t last_step)
    : comm_(comm),
      bodies_(bodies),
      title_(std::move(title)),
      num_points_(std::ssize(obstacles.points) / 3),
      num_triangles_(std::ssize(obstacles.obstacles)),
      group_("/" + obstacles_beside(bodies.mesh_group())) {
  using enum XdmfArray::Number;
  Group group{"/", obstacles_beside(bodies.mesh_group()), [](hid_t) {}, {}};
  group.datasets = {
      {"points", float64, rows(num_points_), 3, on_rank_0(comm_, std::span(obstacles.points)), {{"unit", "m"}}},
      {"triangles", int64, rows(num_triangles_), 3, on_rank_0(comm_, std::span(obstacles.triangles)), {}},
      {"obstacle",
       int32,
       rows(num_triangles_),
       1,
       on_rank_0(comm_, std::span(obstacles.obstacles)),
       {{"names", fmt::format("{}", fmt::join(obstacles.names, "\n"))}}}};
  add_group(comm_, bodies_.hdf5_file(), group, Durability::process);
  on_root(comm_, [&] {
    {
      const QuietHdf5 quiet;
      Hdf5Handle file = open_hdf5(bodies_.hdf5_file(), Hdf5Mode::modify);
      make_frames_group(file.get(), group_ + "/frames");
      file.close("write '" + bodies_.hdf5_file().string() + "'");
    }
    grids_ = listed_frames(bodies_.obstacles_file(), last_step);
    write_text_atomically(bodies_.obstacles_file(), xdmf_document(title_, grids_), Durability::process);
  });
}

void ObstacleWriter::write_frame(double time, std::int64_t step, std::span<const double> points) {
  using enum XdmfArray::Number;
  std::string place = group_ + "/points";
  if (!points.empty()) {
    Group group{group_ + "/frames", fmt::format("{:06}", step), [](hid_t) {}, {}};
    group.datasets = {{"points", float64, rows(num_points_), 3, on_rank_0(comm_, points), {{"unit", "m"}}}};
    add_group(comm_, bodies_.hdf5_file(), group, Durability::process);
    place = group.parent + "/" + group.name + "/points";
  }
  on_root(comm_, [&] {
    XdmfGrid grid;
    grid.name = fmt::format("step {}", step);
    grid.time = time;
    grid.step = step;
    grid.cells = array(group_ + "/triangles", int64, num_triangles_, 3);
    grid.coordinates = array(place, float64, num_points_, 3);
    grid.fields = {{"obstacle", "", XdmfField::Center::cell, array(group_ + "/obstacle", int32, num_triangles_, 1)}};
    const std::string grids = grids_ + to_xml(grid);
    write_text_atomically(bodies_.obstacles_file(), xdmf_document(title_, grids), Durability::process);
    grids_ = grids;
  });
}

void ObstacleWriter::sync() const {
  on_root(comm_, [&] {
    File file(bodies_.obstacles_file(), FileMode::modify);
    file.sync();
    file.close();
  });
}

RowBlock ObstacleWriter::rows(std::int64_t num_global) const {
  return rank(comm_) == 0 ? RowBlock{0, num_global, num_global} : RowBlock{num_global, 0, num_global};
}

XdmfArray ObstacleWriter::array(const std::string& place, XdmfArray::Number number, std::int64_t num_rows,
                                int columns) const {
  return {bodies_.hdf5_file().filename().string() + ":" + place, number, num_rows, columns};
}

}  // namespace pliant
