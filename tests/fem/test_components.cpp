// Parts of a mesh that share no node are told apart on any ranks, and found where they overlap.
#include "fem/body.hpp"
#include "fem/components.hpp"

#include <bit>
#include <cmath>
#include <numeric>
#include <set>

namespace pliant::test_components {
namespace {

using test::Point;
using test::Scratch;

const MPI_Comm comm = MPI_COMM_WORLD;

/// Unit cubes at these places, which share nothing.
class Cubes {
 public:
  Cubes(const std::vector<Point>& corners, int order)
      : scratch_(comm),
        mesh_(test::read_file(comm, scratch_.text("cubes.msh", text_of(corners)))),
        layout_(make_layout(mesh_, order)) {}

  const NodeLayout& layout() const { return layout_; }
  std::vector<double> at_rest() const { return std::vector<double>(3 * layout_.num_local_nodes, 0.0); }

 private:
  /// Six tetrahedra around the diagonal of each cube.
  static std::string text_of(const std::vector<Point>& corners) {
    std::string nodes, cells;
    constexpr std::array<std::array<int, 4>, 6> kuhn{
        {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};
    int num_cells = 0;
    for (std::size_t b = 0; b < corners.size(); ++b) {
      for (std::size_t i = 0; i < 8; ++i) {
        nodes += std::to_string(8 * b + i + 1);
        for (std::size_t k = 0; k < 3; ++k) {
          nodes += " " + std::to_string(corners[b][k] + static_cast<double>((i >> k) & 1U));
        }
        nodes += "\n";
      }
      for (const auto& cell : kuhn) {
        cells += std::to_string(++num_cells) + " 4 2 1 1";
        for (const int n : cell) cells += " " + std::to_string(8 * static_cast<int>(b) + n + 1);
        cells += "\n";
      }
    }
    return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(8 * corners.size()) + "\n" + nodes +
           "$EndNodes\n$Elements\n" + std::to_string(num_cells) + "\n" + cells + "$EndElements\n";
  }

  Scratch scratch_;
  Mesh mesh_;
  NodeLayout layout_;
};

class ComponentsOfCubes : public ::testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Orders, ComponentsOfCubes, ::testing::Values(1, 2));

TEST_P(ComponentsOfCubes, AreTheCubes) {
  const Cubes cubes({{0, 0, 0}, {3, 0, 0}, {0, 5, 0}}, GetParam());
  const NodeLayout& layout = cubes.layout();
  const Components components = connected_components(layout);
  EXPECT_EQ(components.count, 3);
  ASSERT_EQ(std::ssize(components.of_node), layout.num_local_nodes);
  const auto cube_of = [](const Point& X) { return X[1] > 2.0 ? 2 : X[0] > 2.0 ? 1 : 0; };
  // The number of each cube is the same everywhere.
  std::vector<double> lowest(3, 9.0), highest(3, -9.0);
  for (PetscInt n = 0; n < layout.num_local_nodes; ++n) {
    const auto cube = static_cast<std::size_t>(cube_of(layout.position(n)));
    lowest[cube] = std::min(lowest[cube], static_cast<double>(components.of_node[n]));
    highest[cube] = std::max(highest[cube], static_cast<double>(components.of_node[n]));
  }
  std::set<double> numbers;
  for (std::size_t cube = 0; cube < 3; ++cube) {
    EXPECT_EQ(minimum(comm, lowest[cube]), maximum(comm, highest[cube]));
    numbers.insert(minimum(comm, lowest[cube]));
  }
  EXPECT_EQ(numbers, (std::set<double>{0.0, 1.0, 2.0}));
}

TEST_P(ComponentsOfCubes, AreOneWhereTheyAreJoined) {
  const Cubes cubes({{0, 0, 0}, {3, 0, 0}, {0, 5, 0}}, GetParam());
  const NodeLayout& layout = cubes.layout();
  Components components = connected_components(layout);
  std::vector<PetscInt> in_plane;
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    if (layout.position(n)[1] < 0.1) in_plane.push_back(n);
  }
  join(components, layout, in_plane);
  EXPECT_EQ(components.count, 2);
  for (PetscInt n = 0; n < layout.num_local_nodes; ++n) {
    EXPECT_GE(components.of_node[n], 0);
    EXPECT_LT(components.of_node[n], 2);
  }
}

TEST_P(ComponentsOfCubes, OverlapAsDeepAsTheyDo) {
  // Cells of the second are offset, so that its corner lies within the first by .1 of each side.
  const Cubes cubes({{0, 0, 0}, {0.9, 0.9, 0.9}}, GetParam());
  const auto overlap = deepest_overlap(cubes.layout(), connected_components(cubes.layout()), cubes.at_rest());
  ASSERT_TRUE(overlap.has_value());
  EXPECT_GT(overlap->depth, 0.01);
  EXPECT_LT(overlap->depth, 0.1001);
  EXPECT_EQ(std::min(overlap->of, overlap->in), 0);
  EXPECT_EQ(std::max(overlap->of, overlap->in), 1);
}

TEST_P(ComponentsOfCubes, ThatAreKeptApartDoNotCount) {
  const Cubes cubes({{0, 0, 0}, {0.9, 0.9, 0.9}, {-0.85, -0.85, -0.85}}, GetParam());
  const Components components = connected_components(cubes.layout());
  const auto deepest = [&](const std::vector<char>& are_kept_apart) {
    return deepest_overlap(cubes.layout(), components, cubes.at_rest(), 20000, are_kept_apart);
  };
  const auto all = deepest({});
  ASSERT_TRUE(all.has_value());
  std::vector<char> are_kept_apart(9, 0);
  are_kept_apart[static_cast<std::size_t>(3 * all->of + all->in)] = 1;
  are_kept_apart[static_cast<std::size_t>(3 * all->in + all->of)] = 1;
  const auto next = deepest(are_kept_apart);
  ASSERT_TRUE(next.has_value());
  EXPECT_LT(next->depth, all->depth);
  EXPECT_NE(std::minmax({next->of, next->in}), std::minmax({all->of, all->in}));
  EXPECT_FALSE(deepest(std::vector<char>(9, 1)).has_value());
}

TEST_P(ComponentsOfCubes, ThatTouchDoNotOverlap) {
  for (const Point& corner : {Point{1, 0.3, 0.2}, {0.3, 1, 0}, {1, 0.5, 1}, {1.001, 0.3, 0.3}, {3, 3, 3}}) {
    const Cubes cubes({{0, 0, 0}, corner}, GetParam());
    EXPECT_FALSE(deepest_overlap(cubes.layout(), connected_components(cubes.layout()), cubes.at_rest()).has_value());
  }
}

TEST_P(ComponentsOfCubes, OverlapWhenTheyHaveMoved) {
  const Cubes cubes({{0, 0, 0}, {3, 0, 0}}, GetParam());
  const NodeLayout& layout = cubes.layout();
  const Components components = connected_components(layout);
  std::vector<double> u = cubes.at_rest();
  for (PetscInt n = 0; n < layout.num_local_nodes; ++n) {
    if (layout.position(n)[0] > 2.0) {
      u[3 * n] = -2.3;
      u[3 * n + 1] = u[3 * n + 2] = 0.2;
    }
  }
  const auto overlap = deepest_overlap(layout, components, u);
  ASSERT_TRUE(overlap.has_value());
  EXPECT_GT(overlap->at[0], 0.69);
  EXPECT_LT(overlap->at[0], 1.01);
}

TEST_P(ComponentsOfCubes, MayBeApartWhereTheirSidesAreBent) {
  const Cubes cubes({{0, 0, 0}, {0.9, 0, 0}}, GetParam());
  const NodeLayout& layout = cubes.layout();
  const Components components = connected_components(layout);
  if (layout.order == 1) return;  // all nodes are corners, and none lies within the other cube
  ASSERT_TRUE(deepest_overlap(layout, components, cubes.at_rest()).has_value());
  // The nodes on edges of the side x = 1 of the first cube move inwards, as far as the second one comes.
  std::vector<double> u = cubes.at_rest();
  for (PetscInt n = 0; n < layout.num_local_nodes; ++n) {
    const auto [x, y, z] = layout.position(n);
    const bool is_corner = std::fmod(y, 1.0) == 0.0 && std::fmod(z, 1.0) == 0.0;
    if (x == 1.0 && !is_corner) u[3 * n] = -0.1;
  }
  EXPECT_FALSE(deepest_overlap(layout, components, u).has_value());
}

/// Two bodies of many cells, the second within the first: what is said of them is the same on any number of ranks.
TEST_P(ComponentsOfCubes, HaveTheSameSurfaceAndOverlapOnAnyRanks) {
  const Scratch scratch(comm);
  const std::string file = scratch.file("bodies.msh", [](const std::string& name) {
    test::BoxOptions options;
    options.missing = 6;
    options.map = [](Point x) { return x[0] > 6.5 ? Point{x[0] - 4.3, x[1] + 0.13, x[2] + 0.21} : x; };
    test::write_box_msh(name, {11.0, 6.0, 6.0}, {11, 6, 6}, options);
  });
  const test::Body spread(comm, file, GetParam()), whole(MPI_COMM_SELF, file, GetParam());
  const auto num_outer = [](const Components& components) {
    PetscInt64 count = 0;
    for (const unsigned char sides : components.outer_sides) count += std::popcount(sides);
    return count;
  };
  const Components of_spread = connected_components(spread.layout), of_whole = connected_components(whole.layout);
  EXPECT_EQ(num_outer(of_whole), 4 * (36 + 2 * 36) + 4 * (36 + 2 * 24));
  EXPECT_EQ(sum(comm, num_outer(of_spread)), num_outer(of_whole));
  const auto deepest = [](const test::Body& body, const Components& components) {
    return deepest_overlap(body.layout, components, std::vector<double>(3 * body.layout.num_local_nodes, 0.0));
  };
  const auto found = deepest(spread, of_spread), expected = deepest(whole, of_whole);
  ASSERT_TRUE(found && expected);
  EXPECT_NEAR(found->depth, expected->depth, 1e-12);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found->at[i], expected->at[i], 1e-12);
}

}  // namespace
}  // namespace pliant::test_components
