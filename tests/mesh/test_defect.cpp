// Meshes that cannot be used: every rank hears the same InputError, at the place that names the file, with what is
// wrong.
#include "mesh/box_mesh.hpp"
#include "mesh/mesh.hpp"
#include "mesh/scratch.hpp"

#include <gtest/gtest.h>

namespace pliant::test_defect {
namespace {

using test::BoxOptions;
using test::Scratch;
using test::write_box_msh;

const MPI_Comm comm = MPI_COMM_WORLD;

/// What read_mesh says to the file; empty if it takes it. The same on every rank.
std::string complaint(MeshSource source) {
  source.where = {"input/beam.yaml", 3, 9};
  try {
    (void)read_mesh(comm, source);
    return "";
  } catch (const InputError& e) {
    for (const auto& d : e.diagnostics()) {
      EXPECT_EQ(d.where.file, "input/beam.yaml");
      EXPECT_EQ(d.where.line, 3);
      EXPECT_NE(d.message.find("mesh file '"), std::string::npos) << d.message;
    }
    EXPECT_EQ(broadcast(comm, e.what()), e.what());
    return e.what();
  }
}

std::string complaint_about(const std::string& file) {
  MeshSource source;
  source.file = file;
  return complaint(source);
}

// A cube of six tetrahedra about the diagonal 1-7, as pieces to break.
struct Pieces {
  std::string format = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  std::string names = "$PhysicalNames\n2\n2 1 \"clamp\"\n3 2 \"body\"\n$EndPhysicalNames\n";
  std::string nodes = "$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n$EndNodes\n";
  std::string elements =
      "$Elements\n7\n1 2 2 1 1 1 2 3\n2 4 2 2 1 1 2 3 7\n3 4 2 2 1 1 3 4 7\n4 4 2 2 1 1 4 8 7\n5 4 2 2 1 1 8 5 7\n"
      "6 4 2 2 1 1 5 6 7\n7 4 2 2 1 1 6 2 7\n$EndElements\n";
  std::string text() const { return format + names + nodes + elements; }
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("not in the text: " + from);
  return text.replace(at, from.size(), to);
}

/// The cube with `from` replaced by `to`.
std::string broken(const std::string& from, const std::string& to) {
  return replaced(Pieces{}.text(), from, to);
}

struct Defect {
  const char* name;
  std::string file;
  std::string content;
  std::string complaint;  // a part of it
};

std::ostream& operator<<(std::ostream& out, const Defect& defect) {  // not its bytes, of which some have no value
  return out << defect.name;
}

std::vector<Defect> defects() {
  const Pieces cube;
  const std::string text = cube.text();
  const std::string v41 = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
  const std::string box_geo = "SetFactory(\"OpenCASCADE\");\nBox(1) = {0, 0, 0, 1, 1, 1};\n";
  std::string many_twice = broken("7 4 2 2 1 1 6 2 7", "7 4 2 2 1 1 6 2 7\n8 4 2 2 1 1 7 2 6");
  many_twice = replaced(many_twice, "$Elements\n7", "$Elements\n8");
  return {
      {"Empty", "a.msh", "", "it is empty"},
      {"Blank", "a.msh", "\n\n  \n", "without a $Nodes section"},
      {"NotAMesh", "a.msh", "solid cube\nfacet normal 0 0 1\n", "line 1: the file does not begin with $MeshFormat"},
      {"UnknownExtension", "a.xyz", text, "extension"},
      {"NoExtension", "mesh", text, "extension"},
      {"HeaderOnly", "a.msh", cube.format, "without a $Nodes section"},
      {"NoElements", "a.msh", cube.format + cube.nodes, "without a $Elements section"},
      {"NoNodes", "a.msh", cube.format + cube.elements, "elements come before the nodes"},
      {"Version1", "a.msh", "$NOD\n1\n1 0 0 0\n$ENDNOD\n", "2.2 or 4.1"},
      {"Version40", "a.msh", replaced(text, "2.2 0 8", "4 0 8"), "version 4 of the format is not supported"},
      {"Version9", "a.msh", replaced(text, "2.2 0 8", "9.9 0 8"), "msh41"},
      {"VersionText", "a.msh", replaced(text, "2.2 0 8", "two 0 8"),
       "line 2: the version of the format is expected here, not 'two'"},
      {"DataSize", "a.msh", replaced(text, "2.2 0 8", "2.2 0 4"), "data size"},
      {"FileType", "a.msh", replaced(text, "2.2 0 8", "2.2 7 8"), "0 (ascii) or 1 (binary)"},
      {"AsciiSaidBinary", "a.msh", replaced(text, "2.2 0 8", "2.2 1 8"), "byte order is wrong"},
      {"CutInNodes", "a.msh", text.substr(0, text.find("6 1 0 1")), "truncated"},
      {"CutInElements", "a.msh", text.substr(0, text.find("5 4 2 2")), "truncated"},
      {"CutBeforeTheEnd", "a.msh", text.substr(0, text.find("$EndElements")), "truncated"},
      {"CutInNames", "a.msh", text.substr(0, text.find("3 2 \"bo")), "truncated"},
      {"TooFewNodes", "a.msh", broken("$Nodes\n8", "$Nodes\n9"), "$EndNodes"},
      {"TooManyNodes", "a.msh", broken("$Nodes\n8", "$Nodes\n7"), "$EndNodes is expected here"},
      {"HugeCount", "a.msh", broken("$Nodes\n8", "$Nodes\n800000000000"), "damaged"},
      {"NegativeCount", "a.msh", broken("$Elements\n7", "$Elements\n-7"), "damaged"},
      {"WordForANumber", "a.msh", broken("6 1 0 1", "6 1 zero 1"), "a coordinate is expected here, not 'zero'"},
      {"MissingCoordinate", "a.msh", broken("8 0 1 1\n$", "8 0 1\n$"),
       "a coordinate is expected here, not '$EndNodes'"},
      {"UnknownNode", "a.msh", broken("1 2 3 7", "1 2 3 70"), "element 2: an element refers to node 70"},
      {"NegativeNode", "a.msh", broken("1 2 3 7", "1 2 3 -7"),
       "line 23: a node of an element is expected here, not '-7'"},
      {"NodeTwice", "a.msh", broken("8 0 1 1", "7 0 1 1"), "node 7 is defined twice"},
      {"UnknownType", "a.msh", broken("2 4 2 2 1", "2 140 2 2 1"), "type 140"},
      {"SecondNodes", "a.msh", text + cube.nodes, "second $Nodes"},
      {"NotANumber", "a.msh", broken("6 1 0 1", "6 1 nan 1"), "not finite numbers (or beyond 1e100) at node 6"},
      {"Infinite", "a.msh", broken("6 1 0 1", "6 1 -inf 1"), "node 6"},
      {"FarTooFar", "a.msh", broken("6 1 0 1", "6 1 1e300 1"), "node 6"},
      {"FlatCell", "a.msh", broken("6 1 0 1", "6 1 1 1"), "without volume"},
      {"NoSuchCorner", "a.msh", broken("1 2 3 7", "1 2 2 7"), "without volume: element 2"},
      {"CellTwice", "a.msh", many_twice, "duplicate tetrahedra (the same four nodes as another): element 8"},
      {"NodesCoincide", "a.msh", replaced(broken("$Nodes\n8", "$Nodes\n9\n9 1 1 1"), "1 2 3 7", "1 2 3 9"),
       "coincide with another node: "},
      {"Folded", "a.msh", broken("2 1 0 0", "2 0.2 0.9 0.4"), "overlap"},
      {"ThreeAtAFacet", "a.msh",
       replaced(broken("$Elements\n7", "$Elements\n8\n8 4 2 2 1 1 3 7 9"), "$Nodes\n8", "$Nodes\n9\n9 0.9 0.1 0.45"),
       "facet"},
      {"NameTwice", "a.msh", broken("2\n2 1 \"clamp\"", "3\n2 4 \"clamp\"\n2 1 \"clamp\""), "have the name 'clamp'"},
      {"NameWithoutQuotes", "a.msh", broken("\"clamp\"", "clamp"), "in double quotes"},
      {"OnlyTriangles", "a.msh", cube.format + cube.nodes + "$Elements\n1\n1 2 2 1 1 1 2 3\n$EndElements\n",
       "contains no tetrahedra, only 1 of type 3-node triangle"},
      {"NoElementsAtAll", "a.msh", cube.format + cube.nodes + "$Elements\n0\n$EndElements\n",
       "contains no tetrahedra, only nodes"},
      {"Hexahedron", "a.msh", cube.format + cube.nodes + "$Elements\n1\n1 5 2 1 1 1 2 3 4 5 6 7 8\n$EndElements\n",
       "1 of type 8-node hexahedron"},
      {"Mixed", "a.msh",
       replaced(broken("$Elements\n7", "$Elements\n8"), "$EndElements", "8 6 2 2 1 1 2 3 5 6 7\n$EndElements"),
       "1 of type 6-node prism"},
      {"Version41Blocks", "a.msh", v41 + "$Nodes\n1 2 1 2\n3 1 0 1\n1\n0 0 0\n$EndNodes\n",
       "the blocks of nodes hold 1 nodes, but the section says 2"},
      {"Version41Dimension", "a.msh", v41 + "$Nodes\n1 1 1 1\n7 1 0 1\n1\n0 0 0\n$EndNodes\n",
       "dimension of an entity"},
      {"Version41Elements", "a.msh",
       v41 + "$Nodes\n1 1 1 1\n3 1 0 1\n1\n0 0 0\n$EndNodes\n$Elements\n1 1 1 1\n2 1 4 1\n1 1 1 1 1\n$EndElements\n",
       "in an entity of dimension 2"},
      {"GeoSyntax", "a.geo", box_geo + "Phisical Volume(1) = {1};\n", "line 3"},
      {"GeoUnknownSurface", "a.geo", "Point(1) = {0, 0, 0};\nLine(1) = {1, 2};\n", "2"},
      {"GeoWithoutVolume", "a.geo",
       "SetFactory(\"OpenCASCADE\");\nRectangle(1) = {0, 0, 0, 1, 1};\nPhysical Surface(1) = {1};\n", "no tetrahedra"},
      {"GeoEmpty", "a.geo", "// nothing yet\n", "no tetrahedra"},
      {"GeoWithoutLastLineBreak", "a.geo", box_geo + "Physical Volume(1) = {1}; Physical Surface(2) = {1};",
       "add a line break"},
      {"GeoThatExits", "a.geo", box_geo + "Exit;\n", "Exit"},
      {"GeoHexahedra", "a.geo",
       box_geo + "Transfinite Curve{:} = 3; Transfinite Surface{:}; Recombine Surface{:}; Transfinite Volume{1};\n",
       "hexahedron"},
      {"GeoOrder3", "a.geo", box_geo + "Mesh.ElementOrder = 3;\n", "order 1 or 2"},
      {"StepGarbage", "a.step", "ISO-10303-21;\nHEADER;\nnonsense\n", "gmsh"},
      {"StepText", "a.stp", "hello\n", "gmsh"},
      {"BrepGarbage", "a.brep", "DBRep_DrawableShape\nCASCADE Topology V1, (c) Matra-Datavision\n", "truncated"},
      {"StlGarbage", "a.stl", "hello\n", "no triangles"},
      {"StlOpen", "a.stl",
       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
       "facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
       "not closed: 4 edges have one triangle"},
  };
}

class BadMesh : public ::testing::TestWithParam<Defect> {};

TEST_P(BadMesh, IsRefusedOnEveryRankWithAReason) {
  const Scratch scratch(comm);
  const std::string text = complaint_about(scratch.text(GetParam().file, GetParam().content));
  EXPECT_FALSE(text.empty());
  EXPECT_NE(text.find(GetParam().complaint), std::string::npos) << text;
}

INSTANTIATE_TEST_SUITE_P(All, BadMesh, ::testing::ValuesIn(defects()),
                         [](const auto& defect) { return std::string(defect.param.name); });

TEST(MeshSourceErrors, TheCubeItselfIsGood) {
  const Scratch scratch(comm);
  EXPECT_EQ(complaint_about(scratch.text("a.msh", Pieces{}.text())), "");
}

TEST(MeshSourceErrors, MissingFileAndDirectory) {
  const Scratch scratch(comm);
  EXPECT_NE(complaint_about(scratch.path("none.msh")).find("the file does not exist"), std::string::npos);
  EXPECT_NE(complaint_about(scratch.path("none.step")).find("the file does not exist"), std::string::npos);
  on_root(comm, [&] { std::filesystem::create_directory(scratch.path("folder.msh")); });
  EXPECT_NE(complaint_about(scratch.path("folder.msh")).find("directory"), std::string::npos);
}

TEST(MeshSourceErrors, NumbersOutOfRange) {
  const Scratch scratch(comm);
  MeshSource source;
  source.file = scratch.text("a.msh", Pieces{}.text());
  source.size = -1.0;
  source.scale = 0.0;
  source.refine = -1;
  const std::string text = complaint(source);
  for (const char* part : {"size", "scale", "refine"}) EXPECT_NE(text.find(part), std::string::npos) << part;
}

TEST(MeshSourceErrors, ASizeInTheWrongUnit) {
  const Scratch scratch(comm);
  MeshSource source;
  source.file = scratch.text("a.geo", "SetFactory(\"OpenCASCADE\");\nBox(1) = {0, 0, 0, 1000, 200, 100};\n");
  source.size = 0.02;
  EXPECT_NE(complaint(source).find("unit"), std::string::npos);
}

TEST(MeshSourceErrors, CurvedMeshesCannotBeRefined) {
  const Scratch scratch(comm);
  BoxOptions options;
  options.order = 2;
  options.map = [](std::array<double, 3> x) { return std::array<double, 3>{x[0], x[1], x[2] + 0.1 * x[0] * x[0]}; };
  MeshSource source;
  source.file = scratch.file("a.msh", [&](const std::string& f) { write_box_msh(f, {1, 1, 1}, {2, 1, 1}, options); });
  source.refine = 1;
  EXPECT_NE(complaint(source).find("mesh it finer in gmsh"), std::string::npos);
}

TEST(MeshSourceErrors, CurvedCellsThatFold) {
  const Scratch scratch(comm);
  BoxOptions options;
  options.order = 2;
  // The edge's middle at x = 0.5 is pushed beyond its end.
  options.map = [](std::array<double, 3> x) { return std::array<double, 3>{x[0] == 0.5 ? 0.95 : x[0], x[1], x[2]}; };
  MeshSource source;
  source.file = scratch.file("a.msh", [&](const std::string& f) { write_box_msh(f, {1, 1, 1}, {1, 1, 1}, options); });
  EXPECT_NE(complaint(source).find("folded"), std::string::npos);
}

TEST(MeshSourceErrors, MoreRanksThanCells) {
  if (num_ranks(comm) < 3) GTEST_SKIP() << "two cells for one or two ranks";
  const Scratch scratch(comm);
  std::string text = broken("$Elements\n7", "$Elements\n2");
  text.erase(text.find("3 4 2 2 1"), text.find("$EndElements") - text.find("3 4 2 2 1"));
  text = replaced(text, "1 2 2 1 1 1 2 3\n", "3 4 2 2 1 1 3 4 7\n");
  const std::string said = complaint_about(scratch.text("a.msh", text));
  EXPECT_NE(said.find("2 tetrahedra for 3 ranks"), std::string::npos) << said;
}

TEST(MeshSourceErrors, SeveralMistakesAreToldAtOnce) {
  const Scratch scratch(comm);
  std::string text = replaced(broken("$Nodes\n8", "$Nodes\n9\n9 1 1 1"), "1 2 3 7", "1 2 3 9");
  text = replaced(text, "1 3 4 7", "1 3 3 7");
  const std::string said = complaint_about(scratch.text("a.msh", text));
  EXPECT_NE(said.find("coincide"), std::string::npos) << said;
  EXPECT_NE(said.find("without volume: element 3"), std::string::npos) << said;
}

TEST(MeshSourceErrors, FilesCutAnywhereAreRefused) {
  const Scratch scratch(comm);
  const std::string text = Pieces{}.text();
  for (std::size_t size = 1; size + 2 < text.size(); size += 11) {
    EXPECT_NE(complaint_about(scratch.text("cut.msh", text.substr(0, size))), "") << size;
  }
}

}  // namespace
}  // namespace pliant::test_defect
