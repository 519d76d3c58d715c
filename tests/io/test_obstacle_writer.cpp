#include "io/obstacle_writer.hpp"
#include "io/result_info.hpp"
#include "petsc/collective.hpp"
#include "petsc/hdf5.hpp"
#include "petsc/session.hpp"
#include "places.hpp"
#include "sample.hpp"

#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace pliant::test_obstacle_writer {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;

/// What tests/io/check_obstacles.py expects: a sheet and a tetrahedron that has moved by (0, 0, step/10).
OutputObstacles sample_obstacles() {
  return {{"floor", "tip"},
          {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, /**/ 0, 0, 1, 1, 0, 1, 0, 1, 1, 0, 0, 2},
          {0, 1, 2, 0, 2, 3, /**/ 4, 6, 5, 4, 5, 7, 5, 6, 7, 6, 4, 7},
          {0, 0, 1, 1, 1, 1}};
}

std::vector<double> moved(const OutputObstacles& obstacles, std::int64_t step) {
  std::vector<double> points = obstacles.points;
  for (std::size_t i = 4; i < 8; ++i) points[3 * i + 2] += 0.1 * static_cast<double>(step);
  return points;
}

/// 0 if the result has frames of the obstacles at the steps 0, 10, ..., moved as described.
int check_obstacles(const std::filesystem::path& directory, int num_frames, const char* motion) {
  const std::string command = fmt::format("/usr/bin/python3 '{}/tests/io/check_obstacles.py' '{}' {} {}",
                                          source_root().string(), directory.string(), num_frames, motion);
  return std::system(command.c_str());
}

TEST(ObstacleWriter, FramesAreReadAsTheyWereWrittenAndContinued) {
  const auto directory = empty_directory(comm, "obstacles");
  const OutputMesh mesh = sample_mesh(comm, 4);
  const OutputObstacles obstacles = sample_obstacles();
  const auto write = [&](ResultWriter& bodies, ObstacleWriter& writer, std::int64_t step) {
    writer.write_frame(0.01 * static_cast<double>(step), step, moved(obstacles, step));
    write_sample_frame(bodies, mesh, 0.01 * static_cast<double>(step), step);
  };
  {
    ResultWriter bodies(comm, directory, "block", mesh);
    ObstacleWriter writer(comm, bodies, "block", obstacles, -1);
    for (const std::int64_t step : {0, 10, 20, 30}) write(bodies, writer, step);
    writer.sync();
  }
  on_root(comm, [&] { EXPECT_EQ(check_obstacles(directory, 4, "moves"), 0); });
  // From step 15: what was written at 20 and 30 gives way.
  ResultWriter bodies(comm, directory, "block", mesh, 15);
  ObstacleWriter writer(comm, bodies, "block", obstacles, 15);
  on_root(comm, [&] { EXPECT_EQ(check_obstacles(directory, 2, "moves"), 0); });
  for (const std::int64_t step : {20, 30, 40}) write(bodies, writer, step);
  on_root(comm, [&] {
    EXPECT_EQ(check_obstacles(directory, 5, "moves"), 0);
    EXPECT_NE(describe_result(directory / "result.h5").find("obstacles: floor, tip\n"), std::string::npos);
  });
}

TEST(ObstacleWriter, WhatRestsIsWrittenOnce) {
  const auto directory = empty_directory(comm, "resting_obstacles");
  const OutputMesh mesh = sample_mesh(comm, 4);
  ResultWriter bodies(comm, directory, "block", mesh);
  ObstacleWriter writer(comm, bodies, "block", sample_obstacles(), -1);
  for (const std::int64_t step : {0, 10}) {
    writer.write_frame(0.01 * static_cast<double>(step), step, {});
    write_sample_frame(bodies, mesh, 0.01 * static_cast<double>(step), step);
  }
  on_root(comm, [&] {
    EXPECT_EQ(check_obstacles(directory, 2, "rests"), 0);
    const Hdf5Handle file = open_hdf5(directory / "result.h5", Hdf5Mode::read);
    const Hdf5Handle frames(H5Gopen2(file.get(), "obstacles/frames", H5P_DEFAULT), H5Gclose, "open the frames");
    EXPECT_TRUE(names_in(frames.get()).empty());
  });
}

TEST(ObstacleWriter, ListOfAnEarlierRunGoesWithItsNumbers) {
  const auto directory = empty_directory(comm, "earlier_obstacles");
  const OutputMesh mesh = sample_mesh(comm, 4);
  ResultWriter bodies(comm, directory, "block", mesh);
  ObstacleWriter writer(comm, bodies, "block", sample_obstacles(), -1);
  writer.write_frame(0.0, 0, {});
  write_sample_frame(bodies, mesh, 0.0, 0);
  const ResultWriter without(comm, directory, "block", mesh);
  on_root(comm, [&] { EXPECT_FALSE(std::filesystem::exists(without.companion_file("obstacles"))); });
}

}  // namespace
}  // namespace pliant::test_obstacle_writer
