// Pieces of a mesh that hang together and that nothing holds.
#include "fem/body.hpp"
#include "fem/components.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <tuple>

namespace pliant::test_free_components {
namespace {

using test::Body;
using test::Point;
using test::Scratch;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double gap = 0.5;

/// A file of gmsh 2.2 with boxes of one length [m] along x, one behind the other.
void write_boxes(const std::string& file, const std::vector<double>& lengths) {
  std::ostringstream nodes, elements;
  int num_nodes = 0, num_elements = 0;
  double begin = 0.0;
  for (const double length : lengths) {
    test::BoxOptions options;
    options.groups = false;
    options.origin = {begin, 0.0, 0.0};
    test::write_box_msh(file, {length, 1.0, 1.0}, {4, 2, 2}, options);
    begin += length + gap;
    std::ifstream in(file);
    std::string line;
    int count = 0;
    while (std::getline(in, line) && line != "$Nodes") {
    }
    in >> count;
    const int first = num_nodes;
    for (int k = 0; k < count; ++k) {
      int number = 0;
      std::string x, y, z;
      in >> number >> x >> y >> z;
      nodes << ++num_nodes << ' ' << x << ' ' << y << ' ' << z << '\n';
    }
    while (std::getline(in, line) && line != "$Elements") {
    }
    in >> count;
    for (int k = 0; k < count; ++k) {
      int number = 0, type = 0, tags = 0, physical = 0, entity = 0;
      in >> number >> type >> tags >> physical >> entity;
      elements << ++num_elements << ' ' << type << " 2 " << physical << ' ' << entity;
      for (int i = 0; i < (type == 4 ? 4 : 3); ++i) {
        in >> number;
        elements << ' ' << first + number;
      }
      elements << '\n';
    }
  }
  std::ofstream out(file);
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n"
      << num_nodes << '\n'
      << nodes.str() << "$EndNodes\n$Elements\n"
      << num_elements << '\n'
      << elements.str() << "$EndElements\n";
}

class FreeComponents : public ::testing::TestWithParam<int> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("boxes.msh", [](const std::string& f) { write_boxes(f, {1.0, 2.0, 0.7}); });
  Body body_{comm, file_, GetParam()};
  const NodeLayout& layout_ = body_.layout;

  /// Least and largest x of the nodes of each body, and their number, on all ranks.
  std::vector<std::tuple<double, double, double>> extents(const std::vector<std::vector<PetscInt>>& bodies) const {
    std::vector<std::tuple<double, double, double>> all;
    for (const auto& nodes : bodies) {
      double least = 1e9, largest = -1e9;
      for (const PetscInt a : nodes) {
        EXPECT_LT(a, layout_.num_owned_nodes);
        least = std::min(least, layout_.position(a)[0]);
        largest = std::max(largest, layout_.position(a)[0]);
      }
      all.emplace_back(minimum(comm, least), maximum(comm, largest), sum(comm, static_cast<double>(nodes.size())));
    }
    std::ranges::sort(all);
    return all;
  }
};

INSTANTIATE_TEST_SUITE_P(Orders, FreeComponents, ::testing::Values(1, 2));

TEST_P(FreeComponents, AreFoundWhereverTheirCellsAre) {
  const auto found = extents(free_components(layout_, [](PetscInt) { return false; }));
  ASSERT_EQ(found.size(), 3);
  const double per_body = GetParam() == 1 ? 5 * 3 * 3 : 9 * 5 * 5;
  const std::vector<std::tuple<double, double, double>> expected{
      {0.0, 1.0, per_body}, {1.5, 3.5, per_body}, {4.0, 4.7, per_body}};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(std::get<0>(found[k]), std::get<0>(expected[k]), 1e-12);
    EXPECT_NEAR(std::get<1>(found[k]), std::get<1>(expected[k]), 1e-12);
    EXPECT_EQ(std::get<2>(found[k]), std::get<2>(expected[k]));
  }
}

TEST_P(FreeComponents, OfWhichOneNodeIsHeldAreLeftOut) {
  const auto found = extents(free_components(layout_, [&](PetscInt a) {
    const Point x = layout_.position(a);
    return std::abs(x[0] - 3.5) + x[1] + x[2] < 1e-9;  // a corner of the second
  }));
  ASSERT_EQ(found.size(), 2);
  EXPECT_NEAR(std::get<1>(found[0]), 1.0, 1e-12);
  EXPECT_NEAR(std::get<0>(found[1]), 4.0, 1e-12);
}

}  // namespace
}  // namespace pliant::test_free_components
