#include "io/obstacle_writer.hpp"

#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

std::vector<Dataset> datasets_of(MPI_Comm comm, const OutputObstacles& obstacles) {
  return {CompanionSeries::dataset(comm, "points", std::span(obstacles.points), 3, {{"unit", "m"}}),
          CompanionSeries::dataset(comm, "triangles", std::span(obstacles.triangles), 3),
          CompanionSeries::dataset(comm, "obstacle", std::span(obstacles.obstacles),
                                   {{"names", fmt::format("{}", fmt::join(obstacles.names, "\n"))}})};
}

}  // namespace

ObstacleWriter::ObstacleWriter(MPI_Comm comm, const ResultWriter& bodies, std::string title,
                               const OutputObstacles& obstacles, std::int64_t last_step)
    : comm_(comm), series_(comm, bodies, "obstacles", std::move(title), datasets_of(comm, obstacles), last_step) {}

void ObstacleWriter::write_frame(double time, std::int64_t step, std::span<const double> points) {
  XdmfGrid grid;
  grid.coordinates = series_.array("points");
  grid.cells = series_.array("triangles");
  grid.fields = {{"obstacle", "", XdmfField::Center::cell, series_.array("obstacle")}};
  std::vector<Dataset> moved;
  if (!points.empty()) {
    moved.push_back(CompanionSeries::dataset(comm_, "points", points, 3, {{"unit", "m"}}));
    grid.coordinates = series_.array(moved.front(), step);
  }
  series_.write_frame(time, step, std::move(moved), std::move(grid));
}

}  // namespace pliant
