// Names of nodes, pressures and cells are the same on any number of ranks: as on one.
#include "fem/body.hpp"
#include "fem/entry_keys.hpp"
#include "petsc/plex.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <map>

#include <gtest/gtest.h>

namespace pliant::test_entry_keys {
namespace {

using test::Point;

const MPI_Comm comm = MPI_COMM_WORLD;

struct Case {
  int order, geometry_order, refine;
};

class EntryKeys : public ::testing::TestWithParam<Case> {
 protected:
  /// On all ranks together, or on each for itself.
  Mesh read(MPI_Comm of) const {
    MeshSource source;
    source.file = file_;
    source.refine = GetParam().refine;
    return read_mesh(of, source);
  }
  test::Scratch scratch_{comm};
  std::string file_ = scratch_.file("box.msh", [](const std::string& file) {
    test::BoxOptions options;
    options.order = GetParam().geometry_order;
    options.map = options.order == 2 ? test::bent : test::jittered;
    test::write_box_msh(file, {1.0, 1.0, 1.0}, {3, 2, 2}, options);
  });
};

TEST_P(EntryKeys, ANodeIsAtTheSamePlaceOnAnyNumberOfRanks) {
  const Mesh spread = read(comm), whole = read(MPI_COMM_SELF);
  const NodeLayout here = make_layout(spread, GetParam().order), alone = make_layout(whole, GetParam().order);
  std::map<EntryKey, Point> places;
  const auto all = node_keys(alone);
  for (PetscInt n = 0; n < alone.num_owned_nodes; ++n) places[all[n]] = alone.position(n);
  EXPECT_EQ(std::ssize(places), alone.num_global_nodes);
  const auto keys = node_keys(here);
  for (PetscInt n = 0; n < here.num_owned_nodes; ++n) {
    ASSERT_TRUE(places.contains(keys[n]));
    EXPECT_EQ(places[keys[n]], here.position(n));
  }
  EXPECT_EQ(GlobalOrder(comm, keys).num_global(), here.num_global_nodes);
}

TEST_P(EntryKeys, ACellHasTheSameVerticesOnAnyNumberOfRanks) {
  const Mesh spread = read(comm), whole = read(MPI_COMM_SELF);
  const auto cells_of = [](const Mesh& mesh) {
    DM dm = mesh.dm.get();
    const PointRange cells = stratum(dm, 3), vertices = stratum(dm, 0);
    std::map<std::int64_t, std::vector<std::int64_t>> result;
    for (PetscInt c = cells.begin; c < cells.end; ++c) {
      auto& corners = result[mesh.cell_numbers[c - cells.begin]];
      for (const PetscInt p : Closure(dm, c)) {
        if (vertices.contains(p)) corners.push_back(mesh.vertex_numbers[p - vertices.begin]);
      }
      std::ranges::sort(corners);
    }
    return result;
  };
  const auto all = cells_of(whole);
  EXPECT_EQ(std::ssize(all), stratum(whole.dm.get(), 3).size());
  for (const auto& [number, corners] : cells_of(spread)) {
    ASSERT_TRUE(all.contains(number));
    EXPECT_EQ(all.at(number), corners);
  }
}

TEST_P(EntryKeys, TheFingerprintIsThatOfTheMesh) {
  const Mesh spread = read(comm), whole = read(MPI_COMM_SELF);
  const NodeLayout here = make_layout(spread, GetParam().order), alone = make_layout(whole, GetParam().order);
  EXPECT_EQ(fingerprint(here), fingerprint(alone));
  NodeLayout moved = make_layout(spread, GetParam().order);
  if (rank(comm) == 0) moved.coordinates[0] += 1e-15;
  EXPECT_NE(fingerprint(moved), fingerprint(here));
}

TEST_P(EntryKeys, APressureBelongsToAVertexAndABody) {
  const Mesh mesh = read(comm);
  const NodeLayout layout = make_layout(mesh, GetParam().order);
  std::vector<int> body_of_cell(static_cast<std::size_t>(layout.num_local_cells));
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    body_of_cell[c] = static_cast<int>(layout.cell_numbers[c] % 2);
  }
  const PressureLayout pressures = make_pressure_layout(layout, body_of_cell, 2);
  const auto keys = pressure_keys(layout, pressures);
  EXPECT_EQ(GlobalOrder(comm, keys).num_global(), pressures.num_global);
}

INSTANTIATE_TEST_SUITE_P(Meshes, EntryKeys,
                         ::testing::Values(Case{1, 1, 0}, Case{2, 1, 0}, Case{2, 2, 0}, Case{1, 1, 2}, Case{2, 1, 1}),
                         [](const auto& tested) {
                           const Case& c = tested.param;
                           return "P" + std::to_string(c.order) + "OfGeometry" + std::to_string(c.geometry_order) +
                                  "Refined" + std::to_string(c.refine);
                         });

}  // namespace
}  // namespace pliant::test_entry_keys
