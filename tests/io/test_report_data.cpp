// What a page shows of a result: history and frames read back, surfaces, packed numbers.
#include "base/error.hpp"
#include "base/vector3.hpp"
#include "io/body_surface.hpp"
#include "io/history_reader.hpp"
#include "io/history_writer.hpp"
#include "io/packed.hpp"
#include "io/packed_result.hpp"
#include "io/result_reader.hpp"
#include "petsc/check.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "sample.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <set>

#include <gtest/gtest.h>

namespace pliant::test_report_data {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double volume_of_sample = 1.5, area_of_sample = 2.0 * (1.5 + 1.5 + 1.0);

/// Writes frames at 0, 0.1, ... s, steps 0, 10, ...; the file. Collective.
std::filesystem::path sample_result(const std::string& name, int nodes_per_cell, int num_frames) {
  auto directory = empty_directory(comm, name);
  const OutputMesh mesh = sample_mesh(comm, nodes_per_cell);
  ResultWriter writer(comm, directory, "sample", mesh);
  for (int i = 0; i < num_frames; ++i) write_sample_frame(writer, mesh, 0.1 * i, 10 * i);
  writer.sync();
  return directory;
}

/// Area and, by the divergence theorem, volume within the surface of one body.
std::pair<double, double> area_and_volume(const OutputMesh& mesh, const BodySurface& surface, int body) {
  const auto positions = at_vertices(surface, mesh.coordinates, FieldLocation::node, 3);
  const auto x = [&](std::size_t corner) {
    const double* at = &positions[3 * static_cast<std::size_t>(surface.triangles[corner])];
    return Vector3<double>{at[0], at[1], at[2]};
  };
  double area = 0.0, volume = 0.0;
  for (std::size_t c = 0; c < surface.triangles.size(); c += 3) {
    if (surface.bodies[static_cast<std::size_t>(surface.triangles[c])] != body) continue;
    const auto normal = 0.5 * cross(x(c + 1) - x(c), x(c + 2) - x(c));
    area += norm(normal);
    volume += dot(normal, x(c) + x(c + 1) + x(c + 2)) / 9.0;
  }
  return {area, volume};
}

TEST(BodySurface, SurroundsEachBody) {
  for (const int nodes_per_cell : {4, 10}) {
    OutputMesh mesh = sample_mesh(MPI_COMM_SELF, nodes_per_cell);
    // The bodies are halves of the list of cells: together the block, with the interface once on either side.
    const BodySurface both = surface_of_bodies(mesh);
    EXPECT_EQ(both.triangles_per_facet, nodes_per_cell == 10 ? 4 : 1);
    EXPECT_NEAR(area_and_volume(mesh, both, 0).second + area_and_volume(mesh, both, 1).second, volume_of_sample, 1e-14);
    std::ranges::fill(mesh.bodies, 0);
    const BodySurface one = surface_of_bodies(mesh);
    const auto [area, volume] = area_and_volume(mesh, one, 0);
    EXPECT_NEAR(area, area_of_sample, 1e-14);
    EXPECT_NEAR(volume, volume_of_sample, 1e-14);
    // A vertex on an edge of the block belongs to two sides, one at a corner to three; all others to one: Euler's
    // formula for each of the six sides, which are discs.
    const auto num_triangles = static_cast<std::ptrdiff_t>(one.triangles.size() / 3);
    std::set<std::pair<std::int32_t, std::int32_t>> edges;
    for (std::size_t c = 0; c < one.triangles.size(); ++c) {
      edges.insert(std::minmax(one.triangles[c], one.triangles[c % 3 == 2 ? c - 2 : c + 1]));
    }
    EXPECT_EQ(std::ssize(one.nodes) - std::ssize(edges) + num_triangles, 6);
    EXPECT_EQ(surface_of_bodies(mesh, /*most_divided=*/1).triangles_per_facet, 1);
  }
}

// A tetrahedron in the box [-1, 1] x [-2, 2] x [-3, 3] about (5, 0, 0), its corners in both orders that occur.
TEST(BodySurface, MassesAreEllipsoids) {
  for (const auto& corners : {std::array<std::int64_t, 4>{1, 0, 2, 3}, {0, 2, 1, 3}}) {
    OutputMesh mesh = sample_mesh(MPI_COMM_SELF, 4);
    const std::int64_t first = mesh.global_num_nodes;
    mesh.global_num_nodes += 4;
    mesh.coordinates.insert(mesh.coordinates.end(), {6, 2, 3, 6, -2, -3, 4, 2, -3, 4, -2, 3});
    for (const std::int64_t corner : corners) mesh.cells.push_back(first + corner);
    mesh.bodies.push_back(2);
    mesh.body_names.emplace_back("bob");
    mesh.masses = {"bob"};
    const BodySurface surface = surface_of_bodies(mesh);
    const auto x = at_vertices(surface, mesh.coordinates, FieldLocation::node, 3);
    std::vector<double> number(mesh.bodies.size());
    number.back() = 7.0;
    const auto of_cells = at_vertices(surface, number, FieldLocation::cell, 1);
    std::size_t count = 0;
    for (std::size_t v = 0; v < surface.num_vertices(); ++v) {
      if (surface.bodies[v] != 2) continue;
      ++count;
      EXPECT_NEAR(norm(Vector3<double>{x[3 * v] - 5, x[3 * v + 1] / 2, x[3 * v + 2] / 3}), 1.0, 1e-14);
      EXPECT_EQ(of_cells[v], 7.0);
    }
    EXPECT_EQ(count, 258U);
    // The volume of a polyhedron inscribed in an ellipsoid, with triangles that are 1/8 of a quarter circle wide.
    const double volume = area_and_volume(mesh, surface, 2).second;
    EXPECT_LT(volume, 8.0 * std::numbers::pi);
    EXPECT_GT(volume, 0.97 * 8.0 * std::numbers::pi);
    EXPECT_NEAR(area_and_volume(mesh, surface, 0).second + area_and_volume(mesh, surface, 1).second, volume_of_sample,
                1e-12);
  }
}

TEST(BodySurface, ValuesOfCellsAreAveragedWithinTheBody) {
  const OutputMesh mesh = sample_mesh(MPI_COMM_SELF, 4);
  const BodySurface surface = surface_of_bodies(mesh);
  const std::vector<double> of_body(mesh.bodies.begin(), mesh.bodies.end());
  const auto at = at_vertices(surface, of_body, FieldLocation::cell, 1);
  for (std::size_t v = 0; v < surface.num_vertices(); ++v) EXPECT_NEAR(at[v], surface.bodies[v], 1e-14);
  const auto x = at_vertices(surface, mesh.coordinates, FieldLocation::node, 3);
  EXPECT_EQ(x[4], mesh.coordinates[3 * static_cast<std::size_t>(surface.nodes[1]) + 1]);
}

TEST(Quantisation, TakesTheNearestLevel) {
  const Quantisation scale{-1.0, 1.0, 200};
  EXPECT_EQ(scale(-1.0), 0);
  EXPECT_EQ(scale(0.0034), 100);
  EXPECT_EQ(scale(7.0), 200);
  EXPECT_EQ(scale(-7.0), 0);
  EXPECT_EQ(scale(std::nan("")), 0);
  EXPECT_EQ((Quantisation{2.0, 2.0, 65535}(2.0)), 0);
}

TEST(PackedText, IsBase64OfAStreamOfZlib) {
  // zlib has one stream for no bytes: header 78 da, an empty block, the checksum 1.
  EXPECT_EQ(packed_text({}), "eNoDAAAAAAE=");
}

TEST(ResultReader, ReadsWhatWasWritten) {
  for (const int nodes_per_cell : {4, 10}) {
    const auto directory = sample_result("reader", nodes_per_cell, 3);
    const OutputMesh mesh = sample_mesh(MPI_COMM_SELF, nodes_per_cell);
    const ResultReader result(result_file(directory / "result.xdmf"));
    EXPECT_EQ(result.title(), "sample");
    ASSERT_EQ(result.frames().size(), 3U);
    const ResultFrame& last = result.frames().back();
    EXPECT_EQ(last.time, 0.2);
    EXPECT_EQ(last.step, 20);
    const OutputMesh read = result.mesh(last.mesh);
    EXPECT_EQ(read.coordinates, mesh.coordinates);
    EXPECT_EQ(read.cells, mesh.cells);
    EXPECT_EQ(read.bodies, mesh.bodies);
    EXPECT_EQ(read.body_names, mesh.body_names);
    EXPECT_FALSE(result.obstacles(last.mesh));
    const auto fields = result.fields(last);
    ASSERT_EQ(fields.size(), 3U);
    EXPECT_EQ(fields[0].name, "cauchy_stress");
    EXPECT_EQ(fields[0].unit, "Pa");
    EXPECT_EQ(fields[0].location, FieldLocation::cell);
    EXPECT_EQ(fields[0].components, 6);
    EXPECT_EQ(result.values(last, fields[0]), sample_stress(mesh, 0.2));
    EXPECT_EQ(result.values(last, fields[2]), sample_displacement(mesh, 0.2));
    check_mpi(MPI_Barrier(comm));
  }
  EXPECT_THROW(result_file("nowhere"), FileError);
}

TEST(PackedResult, ReducesTensorsToInvariants) {
  const auto file = result_file(sample_result("packed", 4, 5));
  const PackedResult packed = pack_result(ResultReader(file), 1'000'000);
  EXPECT_EQ(packed.frames.size(), 5U);
  ASSERT_EQ(packed.fields.size(), 4U);
  EXPECT_EQ(packed.fields[0].name, "displacement");
  EXPECT_EQ(packed.fields[1].name, "von_mises_stress");
  EXPECT_EQ(packed.fields[2].name, "mean_stress");
  // At the end, in the body 1, the stress is (1 + t, 1 + 2 t, ..., 1 + 6 t).
  const double t = 0.4, shear = (1 + 4 * t) * (1 + 4 * t) + (1 + 5 * t) * (1 + 5 * t) + (1 + 6 * t) * (1 + 6 * t);
  EXPECT_NEAR(packed.fields[1].scales[0].high, std::sqrt(3 * t * t + 3 * shear), 1e-6);
  EXPECT_NEAR(packed.fields[2].scales[0].high, 1 + 2 * t, 1e-6);
  check_mpi(MPI_Barrier(comm));
}

TEST(PackedResult, KeepsWithinItsSizeByLeavingOutFrames) {
  const auto directory = empty_directory(comm, "thinned");
  const OutputMesh mesh = sample_mesh(comm, 4);
  ResultWriter writer(comm, directory, "noise", mesh);
  std::mt19937 random(1);
  for (int i = 0; i < 40; ++i) {
    std::vector<double> noise(mesh.coordinates.size());
    for (double& u : noise) u = static_cast<double>(random()) * 1e-9;
    if (i == 20) noise[0] = std::nan("");  // such a frame cannot be drawn
    writer.write_frame(0.1 * i, i, std::vector<OutputField>{{"displacement", "m", FieldLocation::node, 3, noise}});
  }
  const ResultReader result(result_file(directory));
  const PackedResult all = pack_result(result, 1'000'000);
  EXPECT_EQ(all.frames.size(), 39U);
  EXPECT_EQ(all.num_frames, 40U);
  const PackedResult some = pack_result(result, all.size() / 2);
  EXPECT_LE(some.size(), all.size() / 2);
  EXPECT_GE(some.frames.size(), 14U);  // the mesh takes its part
  EXPECT_LE(some.frames.size(), 19U);
  EXPECT_EQ(some.frames.front().step, 0);
  EXPECT_EQ(some.frames.back().step, 39);
  EXPECT_EQ(pack_result(result, 1).frames.size(), 2U);
  check_mpi(MPI_Barrier(comm));
}

TEST(HistoryReader, ReadsCompleteRows) {
  const auto file = empty_directory(comm, "history_reader") / "history.csv";
  {
    HistoryWriter writer(comm, file, {"step", "a, \"b\""});
    writer.append(std::vector<double>{0.0, 0.1});
    writer.append(std::vector<double>{1.0, std::nan("")});
  }
  on_root(comm, [&] { std::ofstream(file, std::ios::app) << "2,0.2\n3,0.3"; });
  const HistoryTable history = read_history(file);
  EXPECT_EQ(history.names, (std::vector<std::string>{"step", "a, \"b\""}));
  ASSERT_EQ(history.num_rows(), 3U);
  EXPECT_EQ(history.columns[1][0], 0.1);
  EXPECT_TRUE(std::isnan(history.columns[1][1]));
  EXPECT_EQ(history.find("step")->back(), 2.0);
  EXPECT_EQ(history.find("b"), nullptr);
  EXPECT_EQ(read_history(file.parent_path() / "nothing.csv").num_rows(), 0U);
  check_mpi(MPI_Barrier(comm));
}

TEST(HistoryTable, UnitsOfItsColumns) {
  for (const auto& [name, unit] : std::vector<std::pair<std::string, std::string>>{{"step", ""},
                                                                                   {"newton_iterations", ""},
                                                                                   {"time", "s"},
                                                                                   {"elastic_energy", "J"},
                                                                                   {"support_work", "J"},
                                                                                   {"dissipated_contact", "J"},
                                                                                   {"px", "N s"},
                                                                                   {"Lz", "N m s"},
                                                                                   {"tip_x", "m"},
                                                                                   {"tip_uz", "m"},
                                                                                   {"tip_vz", "m/s"},
                                                                                   {"floor_ball_fy", "N"},
                                                                                   {"floor_jx", "N s"},
                                                                                   {"hub_tz", "N m"},
                                                                                   {"chamber_pressure", "Pa"},
                                                                                   {"flexor_tension", "N"},
                                                                                   {"wire_length", "m"},
                                                                                   {"knuckle_angle", "rad"},
                                                                                   {"contact_gap_min", "m"},
                                                                                   {"chamber_volume", "m^3"}}) {
    EXPECT_EQ(unit_of_column(name), unit) << name;
  }
}

}  // namespace
}  // namespace pliant::test_report_data
