// Pliant's own format: what comes back is what went in, on any number of ranks; what is wrong with a file is told once.
// (test_distribution.cpp holds the distributed mesh to the same as one from a .msh file.)
#include "base/limits.hpp"
#include "mesh/box_mesh.hpp"
#include "mesh/isolated.hpp"
#include "mesh/mesh.hpp"
#include "mesh/plex_points.hpp"
#include "mesh/scratch.hpp"
#include "petsc/hdf5.hpp"

#include <algorithm>
#include <csignal>

#include <gtest/gtest.h>

namespace pliant::test_mesh_file {
namespace {

using test::BoxOptions;
using test::Outline;
using test::PlexPoints;
using test::Scratch;
using test::write_box_msh;

const MPI_Comm comm = MPI_COMM_WORLD;

MeshSource source_of(const std::string& file) {
  MeshSource source;
  source.file = file;
  source.where = {"input/beam.yaml", 3, 9};
  return source;
}

/// A box with groups of every dimension, one of them inside.
void write_grouped_box(const std::string& msh) {
  BoxOptions options;
  options.cut = 2;
  options.outline = Outline::edge_and_corner;
  write_box_msh(msh, {2, 1, 0.5}, {4, 3, 2}, options);
}

/// Whether rank 0 reads all of a file, or each rank its block.
class ReadMeshFile : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { check(PetscOptionsSetValue(nullptr, "-mesh_cells_on_root", GetParam())); }
  void TearDown() override { check(PetscOptionsClearValue(nullptr, "-mesh_cells_on_root")); }
};

INSTANTIATE_TEST_SUITE_P(Readers, ReadMeshFile, ::testing::Values("1000000", "0"),
                         [](const auto& of) { return std::string(of.param) == "0" ? "InBlocks" : "OnRoot"; });

TEST_P(ReadMeshFile, HasTheGroupsOfEveryDimension) {
  const Scratch scratch(comm);
  const std::string msh = scratch.file("box.msh", write_grouped_box);
  const std::string h5 = scratch.file("box.h5", [&](const std::string& f) { (void)convert_mesh(source_of(msh), f); });
  for (const int refine : {0, 1}) {
    MeshSource from_msh = source_of(msh), from_h5 = source_of(h5);
    from_msh.refine = from_h5.refine = refine;
    const MeshReport a = read_mesh(comm, from_msh).report, b = read_mesh(comm, from_h5).report;
    EXPECT_EQ(b.num_cells, a.num_cells);
    EXPECT_EQ(b.num_vertices, a.num_vertices);
    EXPECT_EQ(b.num_edges, a.num_edges);
    EXPECT_EQ(b.quality_histogram, a.quality_histogram);
    EXPECT_EQ(b.bounds, a.bounds);
    EXPECT_EQ(b.notices, a.notices);
    EXPECT_EQ(b.edge_cut == 0, num_ranks(comm) == 1);
    ASSERT_EQ(b.groups.size(), 6u);
    for (std::size_t g = 0; g < b.groups.size(); ++g) {
      EXPECT_EQ(b.groups[g].dimension, a.groups[g].dimension);
      EXPECT_EQ(b.groups[g].tag, a.groups[g].tag);
      EXPECT_EQ(b.groups[g].name, a.groups[g].name);
      EXPECT_GT(b.groups[g].count, 0);
      EXPECT_EQ(b.groups[g].count, a.groups[g].count);
      EXPECT_NEAR(b.groups[g].measure, a.groups[g].measure, 1e-13);
    }
  }
}

// What keeps the state of a run apart from the ranks that it ran on.
TEST_P(ReadMeshFile, VerticesAndCellsKeepTheirNumbers) {
  const Scratch scratch(comm);
  const std::string msh = scratch.file("box.msh", write_grouped_box);
  const std::string h5 = scratch.file("box.h5", [&](const std::string& f) { (void)convert_mesh(source_of(msh), f); });
  const Mesh mesh = read_mesh(comm, source_of(h5));
  const Hdf5Handle file = open_hdf5(h5, Hdf5Mode::read);
  const Hdf5Handle nodes(H5Dopen2(file.get(), "nodes", H5P_DEFAULT), H5Dclose, "open");
  const Hdf5Handle cells(H5Dopen2(file.get(), "cells", H5P_DEFAULT), H5Dclose, "open");
  const PlexPoints points(mesh.dm.get());
  ASSERT_EQ(mesh.vertex_numbers.size(), static_cast<std::size_t>(points.end(0) - points.begin(0)));
  ASSERT_EQ(mesh.cell_numbers.size(), static_cast<std::size_t>(points.end(3) - points.begin(3)));
  const auto number_of = [&](PetscInt vertex) {
    return mesh.vertex_numbers[static_cast<std::size_t>(vertex - points.begin(0))];
  };
  for (PetscInt v = points.begin(0); v < points.end(0); ++v) {
    std::array<double, 3> x{};
    read_rows(nodes.get(), {number_of(v), 1}, H5T_NATIVE_DOUBLE, x.data());
    EXPECT_EQ(points.middle(v), x);
  }
  for (PetscInt c = points.begin(3); c < points.end(3); ++c) {
    std::array<std::int64_t, 4> expected{};
    read_rows(cells.get(), {mesh.cell_numbers[static_cast<std::size_t>(c - points.begin(3))], 1}, H5T_NATIVE_INT64,
              expected.data());
    std::vector<std::int64_t> found;
    for (const PetscInt v : points.closure(c, 0)) found.push_back(number_of(v));
    EXPECT_TRUE(std::ranges::is_permutation(found, expected));
  }
}

TEST_P(ReadMeshFile, CoordinatesAreScaledOnTheWayInAndOut) {
  const Scratch scratch(comm);
  const std::string msh = scratch.file("box.msh", write_grouped_box);
  const std::string h5 = scratch.file("box.h5", [&](const std::string& f) {
    MeshSource source = source_of(msh);
    source.scale = 0.25;
    (void)convert_mesh(source, f);
  });
  MeshSource source = source_of(h5);
  source.scale = 2.0;
  EXPECT_NEAR(read_mesh(comm, source).report.volume, 0.125, 1e-14);
}

TEST(MeshFile, WhatTheWholeMeshLacksIsRepairedBefore) {
  const Scratch scratch(comm);
  // One tetrahedron turned inside out, a node of no tetrahedron, a triangle that is no facet of one.
  const std::string msh = scratch.text(
      "a.msh",
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n6 9 9 "
      "9\n$EndNodes\n"
      "$Elements\n5\n1 4 2 7 7 1 3 2 4\n2 4 2 7 7 2 3 4 5\n3 2 2 8 8 1 2 3\n4 2 2 8 8 1 2 5\n5 2 2 8 8 2 3 4\n"
      "$EndElements\n");
  MeshReport report;
  const std::string h5 = scratch.file("a.h5", [&](const std::string& f) { report = convert_mesh(source_of(msh), f); });
  if (rank(comm) == 0) {
    EXPECT_EQ(report.num_cells, 2);
    EXPECT_EQ(report.num_vertices, 5);
    EXPECT_EQ(report.num_inverted_cells, 1);
    EXPECT_EQ(report.num_orphan_nodes, 1);
    ASSERT_EQ(report.notices.size(), 3u);
    EXPECT_NE(report.notices[2].find("1 of its 3 elements are not part of a tetrahedron"), std::string::npos);
  }
  if (num_ranks(comm) > 2) return;  // every rank needs a tetrahedron
  const MeshReport read = read_mesh(comm, source_of(h5)).report;
  EXPECT_EQ(read.num_vertices, 5);
  EXPECT_EQ(read.groups.at(1).count, 2);
  EXPECT_NEAR(read.volume, 0.5, 1e-15);
}

/// What `work` tells the user, on every rank the same.
template <class Work>
std::string complaint(Work work) {
  std::string text;
  try {
    work();
  } catch (const InputError& e) {
    EXPECT_EQ(e.diagnostics().size(), 1u) << e.what();
    EXPECT_EQ(e.diagnostics().front().where.file, "input/beam.yaml");
    text = e.what();
  }
  EXPECT_EQ(broadcast(comm, text), text);
  return text;
}

TEST(MeshFile, IsNotMadeOfCurvedMeshesNorUnderAnotherName) {
  const Scratch scratch(comm);
  const std::string bent = scratch.file("bent.msh", [](const std::string& f) {
    BoxOptions options;
    options.order = 2;
    options.map = [](std::array<double, 3> x) { return std::array<double, 3>{x[0], x[1], x[2] + 0.1 * x[0] * x[0]}; };
    write_box_msh(f, {2, 1, 0.5}, {4, 3, 2}, options);
  });
  const auto converting = [&](const std::string& from, const std::string& to) {
    return complaint([&] { on_root(comm, [&] { (void)convert_mesh(source_of(from), to); }); });
  };
  EXPECT_NE(converting(bent, scratch.path("bent.h5")).find("second-order tetrahedra are curved"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(scratch.path("bent.h5")));
  EXPECT_NE(converting(bent, scratch.path("bent.vtk")).find("must be named .h5"), std::string::npos);
  EXPECT_NE(converting(scratch.path("a.h5"), scratch.path("b.h5")).find("own format already"), std::string::npos);
  const std::string straight = scratch.file("box.msh", write_grouped_box);
  EXPECT_THROW(on_root(comm, [&] { (void)convert_mesh(source_of(straight), scratch.path("no/where.h5")); }), FileError);
}

/// A way to spoil a good file.
struct Damage {
  const char* name;
  std::function<void(const std::string&)> spoil;
  const char* complaint;  // a part of it
};

using InFile = std::function<void(hid_t)>;
std::function<void(const std::string&)> inside(const InFile& change) {
  return [change](const std::string& file) {
    Hdf5Handle h5 = open_hdf5(file, Hdf5Mode::modify);
    change(h5.get());
    h5.close("close");
  };
}

/// The dataset with other numbers, from the first row on.
template <class T>
auto overwritten(const char* dataset, std::vector<T> values) {
  return inside([dataset, values](hid_t file) {
    const Hdf5Handle target(H5Dopen2(file, dataset, H5P_DEFAULT), H5Dclose, "open");
    std::vector<hsize_t> count = sizes_of(target.get());
    const std::vector<hsize_t> start(count.size(), 0);
    count[0] = values.size() / (count.size() == 2 ? count[1] : 1);
    const Hdf5Handle space(H5Dget_space(target.get()), H5Sclose, "select");
    check_hdf5(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
               "select");
    const Hdf5Handle memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose,
                            "select");
    const hid_t type = std::is_integral_v<T> ? H5T_NATIVE_INT64 : H5T_NATIVE_DOUBLE;
    check_hdf5(H5Dwrite(target.get(), type, memory.get(), space.get(), H5P_DEFAULT, values.data()), "write");
  });
}

/// The dataset made anew with these sizes, without numbers: it takes no space.
std::function<void(const std::string&)> resized(const char* dataset, hid_t type, const std::vector<hsize_t>& sizes) {
  return inside([=](hid_t file) {
    check_hdf5(H5Ldelete(file, dataset, H5P_DEFAULT), "delete");
    const Hdf5Handle space(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), H5Sclose, "make");
    const Hdf5Handle made(H5Dcreate2(file, dataset, type, space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose,
                          "make");
  });
}

std::function<void(const std::string&)> without(const char* name) {
  return inside([name](hid_t file) { check_hdf5(H5Ldelete(file, name, H5P_DEFAULT), "delete"); });
}

void cut(const std::string& file, std::uintmax_t bytes) {
  std::filesystem::resize_file(file, bytes);
}

std::vector<Damage> damages() {
  using Whole = std::int64_t;
  return {
      {"Empty", [](const std::string& f) { cut(f, 0); }, "it is empty"},
      {"OnlyTheSignature", [](const std::string& f) { cut(f, 40); }, "damaged"},
      {"Truncated", [](const std::string& f) { cut(f, std::filesystem::file_size(f) / 2); }, "truncated"},
      {"NotHdf5", [](const std::string& f) { std::ofstream(f) << "solid cube\n"; }, "not an HDF5 file"},
      {"NotAMesh", inside([](hid_t f) { check_hdf5(H5Adelete(f, "format"), "delete"); }), "not a mesh of Pliant"},
      {"OtherFormat", inside([](hid_t f) {
         check_hdf5(H5Adelete(f, "format"), "delete");
         write_attribute(f, "format", std::string("pliant-result"));
       }),
       "not a mesh of Pliant"},
      {"OtherVersion", inside([](hid_t f) {
         check_hdf5(H5Adelete(f, "version"), "delete");
         write_attribute(f, "version", std::int64_t{9});
       }),
       "version 9 of the format"},
      {"NoNodes", without("nodes"), "it contains no nodes"},
      {"NoCells", without("cells"), "it contains no cells"},
      {"FlatNodes", resized("nodes", H5T_NATIVE_DOUBLE, {60, 2}), "nodes must have rows of 3 numbers"},
      {"ListOfCells", resized("cells", H5T_NATIVE_INT32, {144}), "cells must have rows of 4 numbers"},
      {"RealCells", resized("cells", H5T_NATIVE_DOUBLE, {144, 4}), "cells must hold integers"},
      {"TooManyForTheIntegers", resized("cells", H5T_NATIVE_INT64, {hsize_t{1} << 62, 4}),
       "too many for 32-bit indices"},
      {"NoCellsAtAll", resized("cells", H5T_NATIVE_INT32, {0, 4}), "every rank needs at least one"},
      {"NotANumber", overwritten<double>("nodes", {nan, 0.0, 0.0}), "not finite numbers (or beyond 1e100) in row 0"},
      {"Infinite", overwritten<double>("nodes", {0.0, 0.0, 0.0, 1e300, 0.0, 0.0}), "in row 1 of nodes"},
      {"NoSuchNode", overwritten<Whole>("cells", {0, 1, 2, 60}), "row 0 of cells does not name four different nodes"},
      {"NegativeNode", overwritten<Whole>("cells", {0, 1, 2, -1}), "row 0 of cells"},
      {"NodeTwice", overwritten<Whole>("cells", {0, 1, 2, 2}), "row 0 of cells"},
      {"InsideOut", overwritten<double>("nodes", {9.0, 9.0, 9.0}), "inverted or flat tetrahedra"},
      {"AtOnePlace", overwritten<double>("nodes", std::vector<double>(180, 1.0)), "inverted or flat tetrahedra"},
      {"NoSuchMember", overwritten<Whole>("groups/2", {144, 0}),
       "'clamp' has a member that is not part of any cell, in row 0"},
      {"NoSuchFacet", overwritten<Whole>("groups/2", {0, 4}),
       "'clamp' has a member that is not part of any cell, in row 0"},
      {"NoSuchCell", overwritten<Whole>("groups/5", {-1}),
       "'body' has a member that is not part of any cell, in row 0"},
      {"MembersWithoutParts", inside([](hid_t f) {
         const Hdf5Handle group(H5Dopen2(f, "groups/0", H5P_DEFAULT), H5Dclose, "open");
         check_hdf5(H5Adelete(group.get(), "dimension"), "delete");
         write_attribute(group.get(), "dimension", std::int64_t{3});
       }),
       "groups/0 must have one dimension"},
      {"GroupWithoutName", inside([](hid_t f) {
         const Hdf5Handle group(H5Dopen2(f, "groups/0", H5P_DEFAULT), H5Dclose, "open");
         check_hdf5(H5Adelete(group.get(), "name"), "delete");
       }),
       "cannot read the attribute 'name'"},
      {"DimensionAsText", inside([](hid_t f) {
         const Hdf5Handle group(H5Dopen2(f, "groups/0", H5P_DEFAULT), H5Dclose, "open");
         check_hdf5(H5Adelete(group.get(), "dimension"), "delete");
         write_attribute(group.get(), "dimension", std::string("2"));
       }),
       "it is not an integer"},
  };
}

// Over which files it dies depends on what is in memory that it has not set; fuzzing found some.
TEST(MeshFile, WhereHdf5DiesTheFileIsToBlame) {
  const auto die = [] {
    (void)std::raise(SIGSEGV);
    return SerialMesh{};
  };
  try {
    (void)isolated({Suspect::hdf5}, die);
    FAIL() << "no defect";
  } catch (const MeshDefect& defect) {
    EXPECT_EQ(defect.reasons(),
              std::vector<std::string>{"the HDF5 library crashed while reading it (Segmentation fault): the file is "
                                       "damaged; write it again with `pliant mesh convert`"});
  }
}

class DamagedMeshFile : public ::testing::TestWithParam<Damage> {};

TEST_P(DamagedMeshFile, IsRefusedOnEveryRankWithOneReason) {
  const Scratch scratch(comm);
  const std::string msh = scratch.file("box.msh", write_grouped_box);
  const std::string h5 = scratch.file("box.h5", [&](const std::string& file) {
    (void)convert_mesh(source_of(msh), file);
    GetParam().spoil(file);
  });
  const std::string text = complaint([&] { (void)read_mesh(comm, source_of(h5)); });
  EXPECT_NE(text.find(GetParam().complaint), std::string::npos) << text;
}

INSTANTIATE_TEST_SUITE_P(All, DamagedMeshFile, ::testing::ValuesIn(damages()),
                         [](const auto& damage) { return std::string(damage.param.name); });

}  // namespace
}  // namespace pliant::test_mesh_file
