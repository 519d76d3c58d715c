#include "io/companion_series.hpp"

#include "base/file.hpp"
#include "petsc/collective.hpp"
#include "petsc/hdf5.hpp"
#include "petsc/session.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace pliant {
namespace {

using Number = XdmfArray::Number;

template <class T>
Dataset made(MPI_Comm comm, Number number, std::string name, std::span<const T> values, int columns) {
  const bool writes = rank(comm) == 0;
  const std::int64_t all = std::ssize(values) / columns;
  const RowBlock rows = writes ? RowBlock{0, all, all} : RowBlock{all, 0, all};
  return {std::move(name), number, rows, columns, std::as_bytes(writes ? values : values.first(0)), {}};
}

std::string name_of_frame(std::int64_t step) {
  return fmt::format("{:06}", step);
}

}  // namespace

std::string group_beside(std::string_view mesh_group, std::string_view name) {
  constexpr std::string_view stem = "mesh";
  const std::size_t at = mesh_group.find(stem);
  return std::string(name) + std::string(at < mesh_group.size() ? mesh_group.substr(at + stem.size()) : "");
}

CompanionSeries::CompanionSeries(MPI_Comm comm, const ResultWriter& bodies, const std::string& name, std::string title,
                                 std::vector<Dataset> datasets, std::int64_t last_step)
    : comm_(comm),
      bodies_(bodies),
      title_(std::move(title)),
      file_(bodies.companion_file(name)),
      group_("/" + group_beside(bodies.mesh_group(), name)),
      datasets_(datasets) {
  for (Dataset& dataset : datasets_) dataset.owned = {};
  const Group group{"/", group_.substr(1), [](hid_t) {}, std::move(datasets)};
  add_group(comm_, bodies_.hdf5_file(), group, Durability::process);
  on_root(comm_, [&] {
    {
      const QuietHdf5 quiet;
      Hdf5Handle file = open_hdf5(bodies_.hdf5_file(), Hdf5Mode::modify);
      make_frames_group(file.get(), group_ + "/frames");
      file.close("write '" + bodies_.hdf5_file().string() + "'");
    }
    grids_ = listed_frames(file_, last_step);
    write_text_atomically(file_, xdmf_document(title_, grids_), Durability::process);
  });
}

Dataset CompanionSeries::dataset(MPI_Comm comm, std::string name, std::span<const double> values, int columns,
                                 std::vector<std::pair<std::string, std::string>> attributes) {
  Dataset result = made(comm, Number::float64, std::move(name), values, columns);
  result.attributes = std::move(attributes);
  return result;
}

Dataset CompanionSeries::dataset(MPI_Comm comm, std::string name, std::span<const std::int64_t> values, int columns) {
  return made(comm, Number::int64, std::move(name), values, columns);
}

Dataset CompanionSeries::dataset(MPI_Comm comm, std::string name, std::span<const std::int32_t> values,
                                 std::vector<std::pair<std::string, std::string>> attributes) {
  Dataset result = made(comm, Number::int32, std::move(name), values, 1);
  result.attributes = std::move(attributes);
  return result;
}

XdmfArray CompanionSeries::array(std::string_view name) const {
  return array_in(group_, *std::ranges::find(datasets_, name, &Dataset::name));
}

XdmfArray CompanionSeries::array(const Dataset& dataset, std::int64_t step) const {
  return array_in(group_ + "/frames/" + name_of_frame(step), dataset);
}

XdmfArray CompanionSeries::array_in(const std::string& group, const Dataset& dataset) const {
  return {bodies_.hdf5_file().filename().string() + ":" + group + "/" + dataset.name, dataset.number,
          dataset.rows.num_global, dataset.columns};
}

void CompanionSeries::write_frame(double time, std::int64_t step, std::vector<Dataset> datasets, XdmfGrid grid) {
  if (!datasets.empty()) {
    const Group group{group_ + "/frames", name_of_frame(step), [](hid_t) {}, std::move(datasets)};
    add_group(comm_, bodies_.hdf5_file(), group, Durability::process);
  }
  on_root(comm_, [&] {
    grid.name = fmt::format("step {}", step);
    grid.time = time;
    grid.step = step;
    const std::string grids = grids_ + to_xml(grid);
    write_text_atomically(file_, xdmf_document(title_, grids), Durability::process);
    grids_ = grids;
  });
}

void CompanionSeries::sync() const {
  on_root(comm_, [&] {
    File file(file_, FileMode::modify);
    file.sync();
    file.close();
  });
}

}  // namespace pliant
