// Every way into the program gives the same box: the four kinds of .msh, and geometry that gmsh meshes.
#include "mesh/box_mesh.hpp"
#include "mesh/gmsh/session.hpp"
#include "mesh/mesh.hpp"
#include "mesh/scratch.hpp"

#include <gmsh.h>
#include <gtest/gtest.h>

namespace pliant::test_format {
namespace {

using test::BoxOptions;
using test::Scratch;
using test::write_box_msh;

const MPI_Comm comm = MPI_COMM_WORLD;

Mesh read(const std::string& file, std::optional<double> size = {}) {
  MeshSource source;
  source.file = file;
  source.size = size;
  return read_mesh(comm, source);
}

const GroupReport& group(const Mesh& mesh, const std::string& name) {
  for (const auto& g : mesh.report.groups) {
    if (g.name == name) return g;
  }
  throw std::runtime_error("no group " + name);
}

bool has_notice(const Mesh& mesh, const std::string& part) {
  for (const auto& notice : mesh.report.notices) {
    if (notice.find(part) != std::string::npos) return true;
  }
  return false;
}

double mean_edge(const Mesh& mesh) {
  // Of tetrahedra that fill space, in the mean: V per cell of a regular tetrahedron is l^3 / (6 sqrt 2).
  return std::cbrt(6.0 * std::sqrt(2.0) * mesh.report.volume / static_cast<double>(mesh.report.num_cells));
}

struct MshKind {
  double version;
  int is_binary;
  int order;
};

class MshFormats : public ::testing::TestWithParam<MshKind> {};

TEST_P(MshFormats, WrittenByGmshReadTheSame) {
  const auto [version, is_binary, order] = GetParam();
  const Scratch scratch(comm);
  BoxOptions options;
  options.order = order;
  if (order == 2) {
    options.map = [](std::array<double, 3> x) { return std::array<double, 3>{x[0], x[1], x[2] + 0.1 * x[0] * x[0]}; };
  }
  const std::string original = scratch.file("original.msh", [&](const std::string& f) {
    write_box_msh(f, {2, 1, 1}, {3, 2, 2}, options);
  });
  const std::string rewritten = scratch.file("rewritten.msh", [&](const std::string& f) {
    const GmshSession gmsh;
    gmsh.run("rewrite", [&] {
      gmsh::open(original);
      gmsh::option::setNumber("Mesh.MshFileVersion", version);
      gmsh::option::setNumber("Mesh.Binary", is_binary);
      gmsh::write(f);
    });
  });
  const Mesh a = read(original), b = read(rewritten);
  EXPECT_EQ(b.geometry_order, order);
  EXPECT_EQ(b.report.num_cells, 72);
  EXPECT_EQ(b.report.num_vertices, a.report.num_vertices);
  EXPECT_NEAR(b.report.volume, a.report.volume, 1e-12);
  ASSERT_EQ(b.groups.size(), 3u);
  for (std::size_t g = 0; g < 3; ++g) {
    EXPECT_EQ(b.groups[g].name, a.groups[g].name);
    EXPECT_EQ(b.groups[g].tag, a.groups[g].tag);
    EXPECT_EQ(b.report.groups[g].count, a.report.groups[g].count);
  }
  EXPECT_EQ(group(b, "clamp").count, 8);
}

INSTANTIATE_TEST_SUITE_P(All, MshFormats,
                         ::testing::Values(MshKind{2.2, 0, 1}, MshKind{2.2, 1, 1}, MshKind{4.1, 0, 1},
                                           MshKind{4.1, 1, 1}, MshKind{2.2, 0, 2}, MshKind{2.2, 1, 2},
                                           MshKind{4.1, 0, 2}, MshKind{4.1, 1, 2}));

TEST(MshFormat, PartitionsAreReadAsOneAndNoneIsTakenForTheWhole) {
  const Scratch scratch(comm);
  const std::string whole = scratch.file("parts.msh", [&](const std::string& f) {
    write_box_msh(f, {2, 1, 1}, {3, 2, 2});
    const GmshSession gmsh;
    gmsh.run("partition", [&] {
      gmsh::open(f);
      gmsh::model::mesh::partition(3);
      gmsh::option::setNumber("Mesh.MshFileVersion", 4.1);
      gmsh::write(f);
      gmsh::option::setNumber("Mesh.PartitionSplitMeshFiles", 1);
      gmsh::write(f);
    });
  });
  const Mesh mesh = read(whole);
  EXPECT_EQ(mesh.report.num_cells, 72);
  EXPECT_EQ(group(mesh, "clamp").count, 8);
  try {
    (void)read(scratch.path("parts_2.msh"));
    FAIL() << "a third of a body is no body";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("holds 1 of a mesh's 3 partitions"), std::string::npos) << error.what();
  }
}

TEST_P(MshFormats, DataOfElementsReadTheSame) {
  const auto [version, is_binary, order] = GetParam();
  const Scratch scratch(comm);
  BoxOptions options;
  options.order = order;
  const std::string original = scratch.file("original.msh", [&](const std::string& f) {
    write_box_msh(f, {2, 1, 1}, {1, 1, 1}, options);
  });
  // Elements 5 to 10 are the tetrahedra, 1 to 4 triangles.
  const std::string rewritten = scratch.file("rewritten.msh", [&](const std::string& f) {
    const GmshSession gmsh;
    gmsh.run("rewrite", [&] {
      gmsh::open(original);
      gmsh::option::setNumber("Mesh.MshFileVersion", version);
      gmsh::option::setNumber("Mesh.Binary", is_binary);
      gmsh::option::setNumber("PostProcessing.SaveMesh", 0);
      gmsh::write(f);
      std::string model;
      gmsh::model::getCurrent(model);
      const auto add = [&](const std::string& name, const std::vector<std::vector<double>>& values) {
        const int view = gmsh::view::add(name);
        gmsh::view::addModelData(view, 0, model, "ElementData", {3, 5, 6, 7, 8, 10}, values, 0.0,
                                 static_cast<int>(values[0].size()));
        gmsh::view::write(view, f, true);
      };
      add("a stiffness", {{-1}, {0.5}, {1.5}, {2.5}, {3.5}, {1e9}});
      add("fibre", {{0, 0, 0}, {1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {1, 0, 0}, {0, 1, -1}});
    });
  });
  const Mesh mesh = read(rewritten);
  ASSERT_EQ(mesh.cell_data.size(), 2u);
  EXPECT_EQ(mesh.cell_data[0].name, "a stiffness");
  EXPECT_EQ(mesh.cell_data[0].components, 1);
  EXPECT_EQ(mesh.cell_data[1].name, "fibre");
  EXPECT_EQ(mesh.cell_data[1].components, 3);
  if (num_ranks(comm) > 1) return;  // where cells go is another test's
  const auto& stiffness = mesh.cell_data[0].values;
  const auto& fibre = mesh.cell_data[1].values;
  ASSERT_EQ(stiffness.size(), 6u);
  ASSERT_EQ(fibre.size(), 18u);
  for (const std::size_t c : {0u, 1u, 2u, 3u}) EXPECT_EQ(stiffness[c], 0.5 + static_cast<double>(c));
  EXPECT_TRUE(std::isnan(stiffness[4])) << "element 9 has none";
  EXPECT_EQ(stiffness[5], 1e9);
  for (const std::size_t k : {0u, 1u, 8u}) EXPECT_EQ(fibre[k], 1.0 + static_cast<double>(k));
  EXPECT_EQ(fibre[17], -1.0);
}

constexpr char two_tets[] = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
5
10 0 0 0
20 1 0 0
30 0 1 0
40 0 0 1
500000000 1 1 1
$EndNodes
$Elements
2
7 4 2 0 1 10 20 30 40
9 4 2 0 1 20 30 40 500000000
$EndElements
)";

TEST(Msh, TwoTetrahedraWithGapsInTheNumbers) {
  if (num_ranks(comm) > 2) GTEST_SKIP() << "two cells for three ranks";
  const Scratch scratch(comm);
  const Mesh mesh = read(scratch.text("two.msh", two_tets));
  EXPECT_EQ(mesh.report.num_cells, 2);
  EXPECT_EQ(mesh.report.num_vertices, 5);
  EXPECT_EQ(mesh.report.num_edges, 9);
  EXPECT_NEAR(mesh.report.volume, 1.0 / 6.0 + 2.0 / 6.0, 1e-15);
  EXPECT_TRUE(mesh.groups.empty());
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Msh, DamagedDataAreRefused) {
  const Scratch scratch(comm);
  const std::string good = R"($ElementData
1
"d"
1
0.0
3
0
1
2
7 1.5
9 2.5
$EndElementData
)";
  const auto message = [&](const std::string& from, const std::string& to) -> std::string {
    try {
      read(scratch.text("data.msh", two_tets + replaced(good, from, to)));
    } catch (const InputError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_NE(message("3\n0\n1\n2", "3\n0\n1\n2000").find("number of elements of the data"), std::string::npos);
  EXPECT_NE(message("3\n0\n1\n2", "3\n0\n10\n2").find("components of the data must be 1 to 9"), std::string::npos);
  EXPECT_NE(message("3\n0\n1\n2", "2\n0\n1").find("three integer tags"), std::string::npos);
  EXPECT_NE(message("9 2.5\n", "").find("the number of an element"), std::string::npos);
  EXPECT_NE(message("9 2.5", "-9 2.5").find("must not be negative"), std::string::npos);
}

TEST(Msh, InvertedTetrahedraAreTurnedRoundAndOrphansDropped) {
  if (num_ranks(comm) > 2) GTEST_SKIP() << "two cells for three ranks";
  const Scratch scratch(comm);
  std::string text = replaced(two_tets, "10 20 30 40", "20 10 30 40");
  text = replaced(text, "5\n10 0 0 0", "6\n77 5 5 5\n10 0 0 0");
  const Mesh mesh = read(scratch.text("inverted.msh", text));
  EXPECT_EQ(mesh.report.num_inverted_cells, 1);
  EXPECT_EQ(mesh.report.num_orphan_nodes, 1);
  EXPECT_NEAR(mesh.report.volume, 0.5, 1e-15);
  EXPECT_EQ(mesh.report.bounds[3], 1.0);
  EXPECT_TRUE(has_notice(mesh, "1 inverted tetrahedron was reoriented: element 7"));
  EXPECT_TRUE(has_notice(mesh, "node 77"));
}

TEST(Msh, ElementsOfOnePhysicalGroupPerElementNotPerEntity) {
  // Converters write one elementary entity for all; the physical tag of each element counts.
  if (num_ranks(comm) > 2) GTEST_SKIP() << "two cells for three ranks";
  const Scratch scratch(comm);
  std::string text = replaced(two_tets, "7 4 2 0 1", "7 4 2 5 1");
  text = replaced(text, "9 4 2 0 1", "9 4 2 6 1");
  const Mesh mesh = read(scratch.text("entities.msh", text));
  ASSERT_EQ(mesh.report.groups.size(), 2u);
  EXPECT_NEAR(mesh.report.groups[0].measure, 1.0 / 6.0, 1e-15);
  EXPECT_NEAR(mesh.report.groups[1].measure, 2.0 / 6.0, 1e-15);
}

TEST(Msh, OnlyPhysicalVolumesAreTakenIfThereAreAny) {
  if (num_ranks(comm) > 1) GTEST_SKIP() << "one cell";
  const Scratch scratch(comm);
  const Mesh mesh = read(scratch.text("partial.msh", replaced(two_tets, "7 4 2 0 1", "7 4 2 5 1")));
  EXPECT_EQ(mesh.report.num_cells, 1);
  EXPECT_EQ(mesh.report.num_vertices, 4);
  EXPECT_TRUE(has_notice(mesh, "1 tetrahedra are in no physical volume"));
}

TEST(Msh, PartsAndHingesAreNoticed) {
  const Scratch scratch(comm);
  const std::string file = scratch.file("parts.msh", [](const std::string& f) {
    write_box_msh(f, {1, 1, 1}, {2, 1, 1});
    std::ifstream in(f);
    std::string text((std::istreambuf_iterator<char>(in)), {});
    // one more tetrahedron at a corner, and one far away
    text = replaced(text, "$Nodes\n12\n",
                    "$Nodes\n19\n101 2 2 2\n102 3 2 2\n103 2 3 2\n104 -1 0 0\n105 0 -1 0\n106 0 0 -1\n107 2 2 3\n");
    text = replaced(text, "$Elements\n16\n", "$Elements\n18\n201 4 2 3 3 101 102 103 107\n202 4 2 3 3 1 104 106 105\n");
    std::ofstream(f) << text;
  });
  const Mesh mesh = read(file);
  EXPECT_EQ(mesh.report.num_cells, 14);
  EXPECT_TRUE(has_notice(mesh, "2 disconnected parts"));
  EXPECT_TRUE(has_notice(mesh, "hinge"));
}

TEST(Msh, GroupsOfCurvesAndPointsAreLabelled) {
  const Scratch scratch(comm);
  const std::string file = scratch.file("low.msh", [](const std::string& f) {
    write_box_msh(f, {1, 1, 1}, {2, 1, 1});
    std::ifstream in(f);
    std::string text((std::istreambuf_iterator<char>(in)), {});
    text = replaced(text, "$PhysicalNames\n3\n",
                    "$PhysicalNames\n6\n0 9 \"corner\"\n1 9 \"rim of it\"\n2 77 \"nothing\"\n");
    text = replaced(text, "$Elements\n16\n", "$Elements\n19\n301 15 2 9 1 3\n302 1 2 9 1 1 2\n303 1 2 9 1 2 3\n");
    std::ofstream(f) << text;
  });
  const Mesh mesh = read(file);
  EXPECT_EQ(group(mesh, "corner").count, 1);
  EXPECT_EQ(group(mesh, "rim of it").count, 2);
  EXPECT_NEAR(group(mesh, "rim of it").measure, 1.0, 1e-15);
  EXPECT_EQ(group(mesh, "nothing").count, 0);
  EXPECT_TRUE(has_notice(mesh, "physical surface 'nothing' has no elements"));
}

TEST(Msh, FacetsOffTheTetrahedraAreNoticed) {
  const Scratch scratch(comm);
  const std::string file = scratch.file("off.msh", [](const std::string& f) {
    write_box_msh(f, {1, 1, 1}, {2, 1, 1});
    std::ifstream in(f);
    std::string text((std::istreambuf_iterator<char>(in)), {});
    std::ofstream(f) << replaced(text, "$Elements\n16\n", "$Elements\n17\n301 2 2 1 1 1 6 11\n");
  });
  const Mesh mesh = read(file);
  EXPECT_EQ(group(mesh, "clamp").count, 2);
  EXPECT_TRUE(has_notice(mesh, "physical surface 'clamp': 1 of its 3 elements"));
}

TEST(Msh, TheReportReadsWell) {
  const Scratch scratch(comm);
  const Mesh mesh = read(scratch.file("box.msh", [](const std::string& f) { write_box_msh(f, {1, 1, 1}, {2, 1, 1}); }));
  const std::string text = describe(mesh.report);
  for (const char* part : {"12 tetrahedra", "12 vertices", "clamp", "2 facets", "0.7-0.8", "####"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in\n" << text;
  }
}

constexpr char block_geo[] = R"(SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Box(2) = {1, 0, 0, 1, 1, 1};
BooleanFragments{ Volume{1, 2}; Delete; }{}
Physical Volume("left") = {1};
Physical Volume("right") = {2};
Physical Surface("clamp") = Surface In BoundingBox{-0.1, -0.1, -0.1, 0.1, 1.1, 1.1};
Mesh.MeshSizeMax = 0.5;
)";

TEST(Geo, IsMeshedWithItsOwnSizesAndGroups) {
  const Scratch scratch(comm);
  const Mesh mesh = read(scratch.text("block.geo", block_geo));
  EXPECT_NEAR(mesh.report.volume, 2.0, 1e-12);
  EXPECT_NEAR(group(mesh, "left").measure, 1.0, 1e-12);
  EXPECT_NEAR(group(mesh, "right").measure, 1.0, 1e-12);
  EXPECT_NEAR(group(mesh, "clamp").measure, 1.0, 1e-12);
  EXPECT_EQ(mesh.report.num_orphan_nodes, 0);
  EXPECT_GT(mesh.report.min_quality, 0.1);
}

class GeoSizes : public ::testing::TestWithParam<const char*> {};

TEST_P(GeoSizes, AnExplicitSizeWinsOverTheFile) {
  const Scratch scratch(comm);
  const std::string file = scratch.text("sized.geo", std::string(GetParam()) + "\n");
  for (const double size : {0.4, 0.2, 0.1}) {
    const Mesh mesh = read(file, size);
    EXPECT_NEAR(mesh.report.volume, 1.0, 1e-12);
    EXPECT_NEAR(mean_edge(mesh) / size, 1.0, 0.25) << "size " << size;
    EXPECT_LT(mesh.report.max_edge, 2.2 * size);
  }
}

#define UNIT_BOX "SetFactory(\"OpenCASCADE\"); Box(1) = {0, 0, 0, 1, 1, 1}; Physical Volume(\"v\") = {1};\n"
INSTANTIATE_TEST_SUITE_P(All, GeoSizes,
                         ::testing::Values(UNIT_BOX, UNIT_BOX "Mesh.MeshSizeMax = 0.05; Mesh.MeshSizeMin = 0.05;",
                                           UNIT_BOX "MeshSize{:} = 2;", UNIT_BOX "Mesh.MeshSizeFactor = 3;",
                                           UNIT_BOX
                                           "Transfinite Curve{:} = 2; Transfinite Surface{:}; Transfinite Volume{1};",
                                           UNIT_BOX "Field[1] = MathEval; Field[1].F = \"0.03\"; Background Field = 1;",
                                           UNIT_BOX "Mesh.MeshSizeFromCurvature = 40; Mesh 3;"));

TEST(Geo, PrescribedDivisionsThatWinAreNoticed) {
  const Scratch scratch(comm);
  const std::string file =
      scratch.text("layers.geo",
                   "Point(1) = {0,0,0,9}; Point(2) = {1,0,0,9}; Point(3) = {1,1,0,9}; Point(4) = {0,1,0,9};\n"
                   "Line(1) = {1,2}; Line(2) = {2,3}; Line(3) = {3,4}; Line(4) = {4,1};\n"
                   "Curve Loop(1) = {1,2,3,4}; Plane Surface(1) = {1};\n"
                   "Extrude{0,0,1}{ Surface{1}; Layers{3}; }\n");
  EXPECT_FALSE(has_notice(read(file, 0.3), "instead of the requested"));
  EXPECT_TRUE(has_notice(read(file, 0.05), "instead of the requested"));
}

TEST(Geo, SecondOrderCurvesOfASphere) {
  const Scratch scratch(comm);
  const Mesh mesh = read(scratch.text("ball.geo",
                                      "SetFactory(\"OpenCASCADE\"); Sphere(1) = {0, 0, 0, 1};\n"
                                      "Physical Surface(\"skin\") = Surface{:}; Physical Volume(\"ball\") = {1};\n"
                                      "Mesh.ElementOrder = 2; Mesh.HighOrderOptimize = 2;\n"),
                         0.4);
  EXPECT_EQ(mesh.geometry_order, 2);
  double farthest = 0.0;
  for (std::size_t i = 0; i < mesh.edge_midpoints.size(); i += 3) {
    farthest =
        std::max(farthest, std::hypot(mesh.edge_midpoints[i], mesh.edge_midpoints[i + 1], mesh.edge_midpoints[i + 2]));
  }
  EXPECT_NEAR(maximum(comm, farthest), 1.0, 1e-6);
}

void write_solids(const std::string& file, int count) {
  const GmshSession gmsh;
  gmsh.run("write solids", [&] {
    gmsh::model::add("solids");
    for (int i = 0; i < count; ++i) gmsh::model::occ::addBox(100.0 * i, 0, 0, 100, 20, 10);
    gmsh::model::occ::synchronize();
    gmsh::write(file);
  });
}

TEST(Cad, StepIsInMetresWhateverItsUnit) {
  const Scratch scratch(comm);
  const std::string file = scratch.file("bar.step", [](const std::string& f) { write_solids(f, 1); });  // in mm
  const Mesh mesh = read(file, 0.008);
  EXPECT_NEAR(mesh.report.volume, 0.1 * 0.02 * 0.01, 1e-12);
  EXPECT_NEAR(mean_edge(mesh) / 0.008, 1.0, 0.25);
  EXPECT_TRUE(has_notice(read(file), "no size is given"));
}

TEST(Cad, TouchingSolidsAreJoined) {
  const Scratch scratch(comm);
  for (const char* name : {"pair.stp", "pair.brep"}) {
    const std::string file = scratch.file(name, [](const std::string& f) { write_solids(f, 2); });
    const Mesh mesh = read(file);
    EXPECT_NEAR(mesh.report.bounds[3] / mesh.report.bounds[4], 10.0, 1e-9);
    EXPECT_FALSE(has_notice(mesh, "disconnected"));
  }
}

std::string box_stl(const std::string& name, std::array<double, 3> lower, std::array<double, 3> upper) {
  std::string text = "solid " + name + "\n";
  constexpr std::array<std::array<int, 4>, 6> quads{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  const auto vertex = [&](int i) {
    std::string line = "vertex";
    for (std::size_t k = 0; k < 3; ++k) line += " " + std::to_string((i >> k & 1) != 0 ? upper[k] : lower[k]);
    return line + "\n";
  };
  for (const auto& q : quads) {
    for (const auto& t : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int i : t) text += vertex(q[static_cast<std::size_t>(i)]);
      text += "endloop\nendfacet\n";
    }
  }
  return text + "endsolid " + name + "\n";
}

TEST(Stl, AClosedSurfaceIsFilled) {
  const Scratch scratch(comm);
  const std::string file = scratch.text("cube.stl", box_stl("cube", {0, 0, 0}, {1, 1, 1}));
  EXPECT_NEAR(read(file).report.volume, 1.0, 1e-12);
  for (const double size : {0.4, 0.2}) {
    const Mesh mesh = read(file, size);
    EXPECT_NEAR(mesh.report.volume, 1.0, 1e-9);
    EXPECT_NEAR(mean_edge(mesh) / size, 1.0, 0.3);
  }
}

TEST(Stl, ShellsInsideAreCavitiesAndOthersAreBodies) {
  const Scratch scratch(comm);
  const std::string text = box_stl("outer", {0, 0, 0}, {3, 3, 3}) + box_stl("cavity", {1, 1, 1}, {2, 2, 2}) +
                           box_stl("pebble", {1.25, 1.25, 1.25}, {1.75, 1.75, 1.75}) +
                           box_stl("other", {5, 0, 0}, {6, 1, 1});
  const std::string file = scratch.text("shells.stl", text);
  for (const std::optional<double> size : {std::optional<double>{}, std::optional<double>{0.3}}) {
    const Mesh mesh = read(file, size);
    EXPECT_NEAR(mesh.report.volume, 27.0 - 1.0 + 0.125 + 1.0, 1e-8);
    EXPECT_TRUE(has_notice(mesh, "3 disconnected parts"));
  }
}

}  // namespace
}  // namespace pliant::test_format
