#include "io/mechanism_writer.hpp"

#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

std::vector<Dataset> datasets_of(MPI_Comm comm, const OutputMechanisms& mechanisms) {
  std::vector<Dataset> datasets{
      CompanionSeries::dataset(comm, "points", std::span(mechanisms.points), 3, {{"unit", "m"}}),
      CompanionSeries::dataset(comm, "segments", std::span(mechanisms.segments), 2),
      CompanionSeries::dataset(comm, "part", std::span(mechanisms.parts),
                               {{"names", fmt::format("{}", fmt::join(mechanisms.names, "\n"))},
                                {"kinds", fmt::format("{}", fmt::join(mechanisms.kinds, "\n"))}})};
  if (!mechanisms.joints.empty()) {
    datasets.push_back(CompanionSeries::dataset(comm, "joints", std::span(mechanisms.joints), 1));
  }
  return datasets;
}

}  // namespace

MechanismWriter::MechanismWriter(MPI_Comm comm, const ResultWriter& bodies, std::string title,
                                 const OutputMechanisms& mechanisms, std::int64_t last_step)
    : comm_(comm), series_(comm, bodies, "mechanisms", std::move(title), datasets_of(comm, mechanisms), last_step) {}

void MechanismWriter::write_frame(double time, std::int64_t step, const MechanismState& state) {
  const Dataset points = CompanionSeries::dataset(comm_, "points", std::span(state.points), 3, {{"unit", "m"}});
  const Dataset tension = CompanionSeries::dataset(comm_, "tension", std::span(state.tensions), 1, {{"unit", "N"}});
  std::vector<Dataset> datasets{points, tension};
  if (!state.axes.empty()) datasets.push_back(CompanionSeries::dataset(comm_, "axes", std::span(state.axes), 3));
  XdmfGrid grid;
  grid.cells = series_.array("segments");
  grid.coordinates = series_.array(points, step);
  grid.fields = {{"tension", "N", XdmfField::Center::cell, series_.array(tension, step)},
                 {"part", "", XdmfField::Center::cell, series_.array("part")}};
  series_.write_frame(time, step, std::move(datasets), std::move(grid));
}

}  // namespace pliant
