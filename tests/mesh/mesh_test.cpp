#include "mesh/mesh.hpp"

#include "mesh/box_mesh.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"

#include <filesystem>
#include <iostream>

#include <gtest/gtest.h>

namespace pliant {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;

TEST(Mesh, Box) {
  const std::string file = "/tmp/box_first.msh";
  on_root(comm, [&] { testing::write_box_msh(file, {1, 1, 1}, {3, 3, 3}); });
  MeshSource source;
  source.file = file;
  const Mesh mesh = read_mesh(comm, source);
  if (rank(comm) == 0) std::cout << describe(mesh.report);
  EXPECT_EQ(mesh.report.num_cells, 162);
  EXPECT_NEAR(mesh.report.volume, 1.0, 1e-12);
}

}  // namespace
}  // namespace pliant
