// The distributed mesh: who owns what, what the overlap holds, where groups and mid-edge nodes end up.
#include "mesh/box_mesh.hpp"
#include "mesh/mesh.hpp"
#include "mesh/plex_points.hpp"
#include "mesh/scratch.hpp"

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <numeric>
#include <ostream>

#include <gtest/gtest.h>

namespace pliant::test_distribution {
namespace {

using test::BoxOptions;
using test::Key;
using test::key_of;
using test::PlexPoints;
using test::Scratch;
using test::write_box_msh;

const MPI_Comm comm = MPI_COMM_WORLD;

/// How the mesh comes in: by rank 0 and METIS, or in parts on every rank.
enum class Format { msh, h5 };

struct Box {
  std::array<int, 3> n;
  int refine = 0;
  Format format = Format::msh;
  long long num_cells() const { return 6LL * n[0] * n[1] * n[2] << (3 * refine); }
  long long num_vertices() const {
    return ((static_cast<long long>(n[0]) << refine) + 1) * ((n[1] << refine) + 1) * ((n[2] << refine) + 1);
  }
};

std::ostream& operator<<(std::ostream& out, const Box& box) {
  return out << box.n[0] << "x" << box.n[1] << "x" << box.n[2] << " refined " << box.refine
             << (box.format == Format::msh ? " msh" : " h5");
}

constexpr std::array<double, 3> size{2.0, 1.0, 0.5};

/// The .msh file, or the one in Pliant's own format that it becomes. Collective.
std::string in_format(Format format, const Scratch& scratch, const std::string& msh) {
  if (format == Format::msh) return msh;
  return scratch.file("box.h5", [&](const std::string& file) {
    MeshSource source;
    source.file = msh;
    (void)convert_mesh(source, file);
  });
}

class DistributedBox : public ::testing::TestWithParam<Box> {
 protected:
  Mesh read(const BoxOptions& options = {}) const {
    const std::string msh =
        scratch_.file("box.msh", [&](const std::string& file) { write_box_msh(file, size, GetParam().n, options); });
    MeshSource source;
    source.file = in_format(GetParam().format, scratch_, msh);
    source.refine = GetParam().refine;
    return read_mesh(comm, source);
  }

 private:
  Scratch scratch_{comm};
};

TEST_P(DistributedBox, ReportAgreesWithTheStructure) {
  const Box& box = GetParam();
  const MeshReport report = read().report;
  EXPECT_EQ(report.num_cells, box.num_cells());
  EXPECT_EQ(report.num_vertices, box.num_vertices());
  EXPECT_NEAR(report.volume, 1.0, 1e-13);
  EXPECT_EQ(std::accumulate(report.cells_per_rank.begin(), report.cells_per_rank.end(), 0LL), box.num_cells());
  EXPECT_EQ(std::accumulate(report.quality_histogram.begin(), report.quality_histogram.end(), 0LL), box.num_cells());
  EXPECT_EQ(report.bounds, (std::array<double, 6>{0, 0, 0, 2, 1, 0.5}));
  EXPECT_TRUE(report.notices.empty()) << report.notices.front();
  // Every rank has work, and none much more than its share of a mesh that is large enough to be cut evenly.
  for (const long long cells : report.cells_per_rank) {
    EXPECT_GT(cells, 0);
    if (box.num_cells() > 500) {
      EXPECT_LT(static_cast<double>(cells * num_ranks(comm)), 1.1 * static_cast<double>(box.num_cells()));
    }
  }
}

TEST_P(DistributedBox, EveryCellIsPositivelyOrientedAsItsClosureLists) {
  const Mesh mesh = read();
  const PlexPoints points(mesh.dm.get());
  for (PetscInt c = points.begin(3); c < points.end(3); ++c) {
    const auto x = points.corners(c);
    ASSERT_EQ(x.size(), 4u);
    double d[3][3];
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) d[i][k] = x[i + 1][k] - x[0][k];
    }
    EXPECT_GT(d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) - d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                  d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]),
              0.0);
  }
}

// What the assembly of an owned point's rows relies on: all cells around it are here.
TEST_P(DistributedBox, EveryOwnedPointHasAllItsCellsAndOneOwner) {
  const Mesh mesh = read();
  const PlexPoints points(mesh.dm.get());
  for (int dimension = 0; dimension <= 3; ++dimension) {
    std::vector<Key> incidences, owned;
    for (PetscInt c = points.begin(3); c < points.end(3); ++c) {
      if (!points.is_owned(c)) continue;
      for (const PetscInt p : points.closure(c, dimension)) incidences.push_back(key_of(points.middle(p)));
    }
    for (PetscInt p = points.begin(dimension); p < points.end(dimension); ++p) {
      if (points.is_owned(p)) owned.push_back(key_of(points.middle(p)));
    }
    const auto cells_around = test::counted_everywhere(comm, incidences);
    const auto owners = test::counted_everywhere(comm, owned);
    EXPECT_EQ(cells_around.size(), owners.size());
    for (const auto& [key, count] : owners) EXPECT_EQ(count, 1);
    for (PetscInt p = points.begin(dimension); p < points.end(dimension); ++p) {
      if (!points.is_owned(p)) continue;
      EXPECT_EQ(static_cast<int>(points.star(p, 3).size()), cells_around.at(key_of(points.middle(p))));
    }
  }
}

TEST_P(DistributedBox, EveryGhostCellTouchesAnOwnedOneAndEveryGhostPointHasAnOwnerElsewhere) {
  const Mesh mesh = read();
  const PlexPoints points(mesh.dm.get());
  for (PetscInt c = points.begin(3); c < points.end(3); ++c) {
    if (points.is_owned(c)) continue;
    bool touches = false;
    for (const PetscInt v : points.closure(c, 0)) {
      for (const PetscInt other : points.star(v, 3)) touches = touches || points.is_owned(other);
    }
    EXPECT_TRUE(touches);
  }
  PetscSF sf = nullptr;
  PetscInt num_leaves = 0;
  const PetscSFNode* roots = nullptr;
  check(DMGetPointSF(mesh.dm.get(), &sf));
  check(PetscSFGetGraph(sf, nullptr, &num_leaves, nullptr, &roots));
  for (PetscInt i = 0; i < num_leaves; ++i) EXPECT_NE(roots[i].rank, rank(comm));
}

// What owners tell of their points reaches the same points elsewhere.
TEST_P(DistributedBox, EveryGhostPointNamesTheSamePointOfItsOwner) {
  const Mesh mesh = read();
  const PlexPoints points(mesh.dm.get());
  PetscSF sf = nullptr;
  PetscInt num_roots = 0;
  check(DMGetPointSF(mesh.dm.get(), &sf));
  check(PetscSFGetGraph(sf, &num_roots, nullptr, nullptr, nullptr));
  if (num_ranks(comm) == 1) return;
  std::vector<double> here;
  for (PetscInt p = 0; p < num_roots; ++p) {
    const auto middle = points.middle(p);
    here.insert(here.end(), middle.begin(), middle.end());
  }
  std::vector<double> of_owner = here;
  MPI_Datatype place = MPI_DATATYPE_NULL;
  check_mpi(MPI_Type_contiguous(3, MPI_DOUBLE, &place));
  check_mpi(MPI_Type_commit(&place));
  check(PetscSFBcastBegin(sf, place, here.data(), of_owner.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(sf, place, here.data(), of_owner.data(), MPI_REPLACE));
  check_mpi(MPI_Type_free(&place));
  for (std::size_t i = 0; i < here.size(); ++i) EXPECT_NEAR(here[i], of_owner[i], 1e-14);
}

// Cells on both sides of an owned facet are then among those of own nodes. (A third rank may own all vertices of a
// facet.)
TEST_P(DistributedBox, OfTwoRanksTheOwnerOfAPointOwnsAVertexOfIt) {
  const Mesh mesh = read();
  const PlexPoints points(mesh.dm.get());
  if (num_ranks(comm) > 2) return;
  for (const int dimension : {1, 2}) {
    for (PetscInt p = points.begin(dimension); p < points.end(dimension); ++p) {
      const auto vertices = points.closure(p, 0);
      const bool has_own =
          std::any_of(vertices.begin(), vertices.end(), [&](PetscInt v) { return points.is_owned(v); });
      const auto around = points.star(p, 3);
      const bool is_shared = std::any_of(around.begin(), around.end(), [&](PetscInt c) { return !points.is_owned(c); });
      EXPECT_TRUE(has_own || !is_shared || !points.is_owned(p));
    }
  }
}

TEST_P(DistributedBox, TheCornersOfACellAreThoseOfItsClosure) {
  const Mesh mesh = read();
  const PlexPoints points(mesh.dm.get());
  ASSERT_EQ(std::ssize(mesh.corners), 4 * points.end(3));
  for (PetscInt c = 0; c < points.end(3); ++c) {
    const auto vertices = points.closure(c, 0);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(points.begin(0) + mesh.corners[4 * static_cast<std::size_t>(c) + i], vertices[i]);
    }
  }
}

// Facets inside, edges and vertices are shared by cells of several ranks.
TEST_P(DistributedBox, GroupsOfAllDimensionsHaveTheirPointsOnEveryRank) {
  BoxOptions options;
  options.cut = 1;
  options.outline = test::Outline::edge_and_corner;
  const Mesh mesh = read(options);
  const PlexPoints points(mesh.dm.get());
  const double x_of_cut = size[0] / GetParam().n[0];
  const auto is_at = [](double a, double b) { return std::abs(a - b) < 1e-12; };
  const std::map<std::string, std::function<bool(const std::array<double, 3>&)>> lies_in{
      {"cut", [&](const auto& x) { return is_at(x[0], x_of_cut); }},
      {"edge", [&](const auto& x) { return is_at(x[1], 0.0) && is_at(x[2], 0.0); }},
      {"corner", [&](const auto& x) { return is_at(x[0], size[0]) && is_at(x[1], 0.0) && is_at(x[2], 0.0); }}};
  int num_seen = 0;
  for (const auto& group : mesh.groups) {
    if (!lies_in.contains(group.name)) continue;
    ++num_seen;
    DMLabel label = nullptr;
    check(DMGetLabel(mesh.dm.get(), label_name(group).c_str(), &label));
    for (PetscInt p = points.begin(group.dimension); p < points.end(group.dimension); ++p) {
      PetscInt value = -1;
      check(DMLabelGetValue(label, p, &value));
      EXPECT_EQ(value == 1, lies_in.at(group.name)(points.middle(p))) << group.name;
    }
  }
  EXPECT_EQ(num_seen, 3);
}

TEST_P(DistributedBox, GroupsKeepTheirNamesMembersAndSizes) {
  const Box& box = GetParam();
  const Mesh mesh = read();
  ASSERT_EQ(mesh.groups.size(), 3u);
  ASSERT_EQ(mesh.report.groups.size(), 3u);
  EXPECT_EQ(mesh.groups[0].name, "clamp");
  EXPECT_EQ(mesh.groups[1].name, "tip");
  EXPECT_EQ(mesh.groups[2].name, "body");
  EXPECT_EQ(mesh.groups[2].tag, 3);
  const long long facets = 2LL * box.n[1] * box.n[2] << (2 * box.refine);
  for (const std::size_t g : {0u, 1u}) {
    EXPECT_EQ(mesh.report.groups[g].count, facets);
    EXPECT_NEAR(mesh.report.groups[g].measure, 0.5, 1e-14);
  }
  EXPECT_EQ(mesh.report.groups[2].count, box.num_cells());
  const PlexPoints points(mesh.dm.get());
  for (const auto& group : mesh.groups) {
    DMLabel label = nullptr;
    check(DMGetLabel(mesh.dm.get(), label_name(group).c_str(), &label));
    ASSERT_NE(label, nullptr);
    Handle<IS> members;
    check(DMLabelGetStratumIS(label, 1, members.out()));
    if (!members) continue;
    PetscInt n = 0;
    const PetscInt* p = nullptr;
    check(ISGetLocalSize(members.get(), &n));
    check(ISGetIndices(members.get(), &p));
    for (PetscInt i = 0; i < n; ++i) {
      EXPECT_GE(p[i], points.begin(group.dimension));
      EXPECT_LT(p[i], points.end(group.dimension));
      if (group.name == "clamp") {
        EXPECT_NEAR(points.middle(p[i])[0], 0.0, 1e-14);
      }
      if (group.name == "tip") {
        EXPECT_NEAR(points.middle(p[i])[0], 2.0, 1e-14);
      }
    }
    check(ISRestoreIndices(members.get(), &p));
  }
}

TEST_P(DistributedBox, GhostFacetsAreLabelledAsTheirOwnersLabelThem) {
  const Mesh mesh = read();
  const PlexPoints points(mesh.dm.get());
  DMLabel label = nullptr;
  check(DMGetLabel(mesh.dm.get(), label_name(mesh.groups[0]).c_str(), &label));
  for (PetscInt f = points.begin(2); f < points.end(2); ++f) {
    PetscInt value = -1;
    check(DMLabelGetValue(label, f, &value));
    EXPECT_EQ(value == 1, std::abs(points.middle(f)[0]) < 1e-14);
  }
}

TEST_P(DistributedBox, IsTheSameOnEveryCall) {
  if (GetParam().format == Format::h5) GTEST_SKIP() << "PTScotch cuts by the order in which messages arrive";
  const Mesh first = read(), second = read();
  const PlexPoints a(first.dm.get()), b(second.dm.get());
  ASSERT_EQ(a.end(3), b.end(3));
  for (PetscInt c = a.begin(3); c < a.end(3); ++c) EXPECT_EQ(a.corners(c), b.corners(c));
  EXPECT_EQ(first.report.edge_cut, second.report.edge_cut);
}

INSTANTIATE_TEST_SUITE_P(Boxes, DistributedBox,
                         ::testing::Values(Box{{1, 1, 1}}, Box{{3, 3, 3}}, Box{{7, 2, 1}}, Box{{5, 4, 6}},
                                           Box{{1, 1, 1}, 1}, Box{{3, 2, 2}, 1}, Box{{1, 1, 1}, 2},
                                           Box{{1, 1, 1}, 0, Format::h5}, Box{{3, 3, 3}, 0, Format::h5},
                                           Box{{7, 2, 1}, 0, Format::h5}, Box{{5, 4, 6}, 0, Format::h5},
                                           Box{{3, 2, 2}, 1, Format::h5}, Box{{1, 1, 1}, 2, Format::h5}));

/// Appends data to a box of one group: the corners of each tetrahedron, nine numbers and three.
void append_corners(const std::string& file) {
  std::ifstream in(file);
  std::string word;
  std::map<int, std::array<double, 3>> nodes;
  std::string first, last;
  int count = 0, num_cells = 0;
  while (in >> word && word != "$Nodes") {
  }
  in >> count;
  for (int n = 0, tag = 0; n < count; ++n) {
    in >> tag;
    for (double& x : nodes[tag]) in >> x;
  }
  in >> word >> word >> count;  // $EndNodes $Elements
  for (int n = 0; n < count; ++n) {
    int tag = 0, type = 0, skipped = 0;
    in >> tag >> type >> skipped >> skipped >> skipped;
    first += type == 4 ? std::to_string(tag) : "";
    last += type == 4 ? std::to_string(tag) : "";
    num_cells += type == 4 ? 1 : 0;
    for (int k = 0; k < (type == 4 ? 4 : 3); ++k) {
      int node = 0;
      in >> node;
      if (type != 4) continue;
      for (const double x : nodes[node]) (k < 3 ? first : last) += " " + std::to_string(x);
    }
    first += type == 4 ? "\n" : "";
    last += type == 4 ? "\n" : "";
  }
  in.close();
  std::ofstream out(file, std::ios::app);
  const auto write = [&](const std::string& name, int components, const std::string& values) {
    out << "$ElementData\n1\n\"" << name << "\"\n1\n0.0\n3\n0\n"
        << components << "\n"
        << num_cells << "\n"
        << values << "$EndElementData\n";
  };
  write("first corners", 9, first);
  write("last corner", 3, last);
}

// On ghosts too, and children of a refined cell have what their parent had: they lie in it.
TEST_P(DistributedBox, DataArriveOnTheirCells) {
  const Scratch scratch(comm);
  MeshSource source;
  // Corners at multiples of some 1e-2 are exact in the six digits of std::to_string.
  const auto [nx, ny, nz] = GetParam().n;
  const std::string msh = scratch.file("data.msh", [&, nx = nx, ny = ny, nz = nz](const std::string& file) {
    write_box_msh(file, {1.0 * nx, 1.0 * ny, 1.0 * nz}, GetParam().n);
    append_corners(file);
  });
  source.file = in_format(GetParam().format, scratch, msh);
  source.refine = GetParam().refine;
  const Mesh mesh = read_mesh(comm, source);
  ASSERT_EQ(mesh.cell_data.size(), 2u);
  EXPECT_EQ(mesh.cell_data[0].name, "first corners");
  EXPECT_EQ(mesh.cell_data[0].components, 9);
  EXPECT_EQ(mesh.cell_data[1].components, 3);
  const PlexPoints points(mesh.dm.get());
  const auto num_cells = static_cast<std::size_t>(points.end(3));
  ASSERT_EQ(mesh.cell_data[0].values.size(), 9 * num_cells);
  ASSERT_EQ(mesh.cell_data[1].values.size(), 3 * num_cells);
  for (PetscInt c = 0; c < points.end(3); ++c) {
    const auto corner = [&](std::size_t k) {
      const double* x = k < 3 ? &mesh.cell_data[0].values[9 * static_cast<std::size_t>(c) + 3 * k]
                              : &mesh.cell_data[1].values[3 * static_cast<std::size_t>(c)];
      return std::array<double, 3>{x[0], x[1], x[2]};
    };
    const auto volume = [](const std::array<std::array<double, 3>, 4>& x) {
      double d[3][3];
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) d[i][k] = x[i + 1][k] - x[0][k];
      }
      return d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) - d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
             d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
    };
    const std::array parent{corner(0), corner(1), corner(2), corner(3)};
    const double whole = volume(parent);
    for (std::size_t k = 0; k < 4; ++k) {
      auto part = parent;
      part[k] = points.middle(c);
      EXPECT_GT(volume(part) / whole, GetParam().refine == 0 ? 0.2499 : 0.01);
    }
  }
}

// Nodes on a cylinder shell: x along the axis, y the angle, z the radius. Edges in y are arcs.
std::array<double, 3> bent(std::array<double, 3> x) {
  const double angle = x[1], radius = 1.0 + x[2];
  return {x[0], radius * std::cos(angle), radius * std::sin(angle)};
}

TEST(CurvedBox, MidEdgeNodesArriveWithTheirEdges) {
  const Scratch scratch(comm);
  MeshSource source;
  BoxOptions options;
  options.order = 2;
  options.map = bent;
  source.file = scratch.file("bent.msh", [&](const std::string& file) {
    write_box_msh(file, size, {4, 3, 2}, options);
  });
  source.scale = 0.5;
  const Mesh mesh = read_mesh(comm, source);
  EXPECT_EQ(mesh.geometry_order, 2);
  EXPECT_EQ(mesh.report.num_vertices, 5 * 4 * 3);
  EXPECT_EQ(mesh.report.num_orphan_nodes, 0);
  const PlexPoints points(mesh.dm.get());
  ASSERT_EQ(mesh.edge_midpoints.size(), 3 * static_cast<std::size_t>(points.end(1) - points.begin(1)));
  for (PetscInt e = points.begin(1); e < points.end(1); ++e) {
    const auto x = points.corners(e);
    std::array<double, 3> parameters{};
    for (const auto& end : x) {
      parameters[0] += 0.5 * end[0] / source.scale;
      parameters[1] += 0.5 * std::atan2(end[2], end[1]);
      parameters[2] += 0.5 * (std::hypot(end[1], end[2]) / source.scale - 1.0);
    }
    const auto expected = bent(parameters);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(mesh.edge_midpoints[3 * static_cast<std::size_t>(e - points.begin(1)) + k],
                  source.scale * expected[k], 1e-14);
    }
  }
}

TEST(CurvedBox, StraightSecondOrderMeshesAreFirstOrderGeometry) {
  const Scratch scratch(comm);
  MeshSource source;
  BoxOptions options;
  options.order = 2;
  source.file = scratch.file("straight.msh", [&](const std::string& file) {
    write_box_msh(file, size, {2, 2, 2}, options);
  });
  source.refine = 1;
  const Mesh mesh = read_mesh(comm, source);
  EXPECT_EQ(mesh.geometry_order, 1);
  EXPECT_TRUE(mesh.edge_midpoints.empty());
  EXPECT_EQ(mesh.report.num_cells, 48 * 8);
  EXPECT_EQ(mesh.report.groups[0].count, 8 * 4);
}

}  // namespace
}  // namespace pliant::test_distribution
