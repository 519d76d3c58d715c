// Values at nodes from values in cells: polynomials come back exactly, on any ranks.
#include "base/vector3.hpp"
#include "fem/body.hpp"
#include "fem/cell_integration.hpp"
#include "fem/patch_recovery.hpp"
#include "fem/quadrature.hpp"
#include "fem/selection.hpp"
#include "petsc/collective.hpp"

#include <map>

namespace pliant::test_patch_recovery {
namespace {

using test::BodySpec;
using test::Point;
using test::Shape;

const MPI_Comm comm = MPI_COMM_WORLD;

class Patches : public test::OnBodies {
 protected:
  /// Two functions of the place, of the degree.
  static std::array<double, 2> field(const Point& X, int degree) {
    const double c = degree > 1 ? 1.0 : 0.0, b = degree > 0 ? 1.0 : 0.0;
    return {1.0 + b * (2.0 * X[0] - X[1]) + c * (X[0] * X[2] - X[1] * X[1]), 3.0 - b * X[2] + c * X[0] * X[1]};
  }

  std::vector<double> sampled(const PatchRecovery::Samples& samples, int degree) const {
    std::vector<double> values;
    for (PetscInt cell = 0; cell < layout_.num_local_cells; ++cell) {
      for (const auto& xi : samples.points) {
        for (const double value : field(position_in_cell(layout_, cell, xi), degree)) values.push_back(value);
      }
    }
    return values;
  }

  /// The largest difference from the field at the nodes of the rank, ghosts included.
  double error(const std::vector<double>& at_nodes, int degree) const {
    double largest = 0.0;
    for (PetscInt n = 0; n < layout_.num_local_nodes; ++n) {
      const auto wanted = field(layout_.position(n), degree);
      for (std::size_t c = 0; c < 2; ++c) largest = std::max(largest, std::abs(at_nodes[2 * n + c] - wanted[c]));
    }
    return maximum(comm, largest);
  }

  std::vector<int> one_body() const { return std::vector<int>(static_cast<std::size_t>(layout_.num_local_cells), 0); }
};

INSTANTIATE_TEST_SUITE_P(Bodies, Patches,
                         ::testing::Values(BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::jittered, 3},
                                           BodySpec{2, Shape::curved, 3}),
                         [](const auto& of) { return test::name_of(of.param); });

TEST_P(Patches, RecoverPolynomials) {
  for (const int degree : {1, 2}) {
    const PatchRecovery::Samples samples{simplex_rule<3>(degree).points, degree};
    const PatchRecovery recovery(layout_, one_body(), samples);
    const auto at_nodes = recovery.at_nodes(sampled(samples, degree), 2, std::vector<char>{1}).values;
    EXPECT_LT(error(at_nodes, degree), 1e-10) << degree;
  }
}

TEST_P(Patches, RecoverLinearFunctionsEverywhereFromFourPointsInEachCell) {
  const PatchRecovery::Samples samples{simplex_rule<3>(2).points, 2};
  const PatchRecovery recovery(layout_, one_body(), samples);
  EXPECT_LT(error(recovery.at_nodes(sampled(samples, 1), 2, std::vector<char>{1}).values, 1), 1e-11);
}

TEST_P(Patches, KeepBodiesApart) {
  // The halves below and above z = 1/2, by the centroids of cells, have different constants.
  std::vector<int> body_of_cell;
  std::vector<double> values;
  for (PetscInt cell = 0; cell < layout_.num_local_cells; ++cell) {
    const bool is_above = position_in_cell(layout_, cell, {0.25, 0.25, 0.25})[2] > 0.5;
    body_of_cell.push_back(is_above ? 1 : 0);
    values.push_back(is_above ? 5.0 : 2.0);
  }
  const PatchRecovery recovery(layout_, body_of_cell, {{{0.25, 0.25, 0.25}}, 1});
  for (const int body : {0, 1}) {
    std::vector<char> is_taken(2, 0);
    is_taken[static_cast<std::size_t>(body)] = 1;
    const auto [at_nodes, has_value] = recovery.at_nodes(values, 1, is_taken);
    for (PetscInt n = 0; n < layout_.num_local_nodes; ++n) {
      EXPECT_NEAR(at_nodes[n], has_value[n] != 0 ? (body == 0 ? 2.0 : 5.0) : 0.0, 1e-12);
    }
  }
}

TEST_P(Patches, CountEachOfTwoBodiesOnceWhereTheyMeet) {
  // A body of a few cells in a corner: its own patches are poorer than those of the other body.
  std::vector<int> body_of_cell;
  std::vector<double> values;
  for (PetscInt cell = 0; cell < layout_.num_local_cells; ++cell) {
    const Point X = position_in_cell(layout_, cell, {0.25, 0.25, 0.25});
    const bool is_corner = X[0] + X[1] + X[2] < 0.6;
    body_of_cell.push_back(is_corner ? 1 : 0);
    values.push_back(is_corner ? 5.0 : 2.0);
  }
  const PatchRecovery recovery(layout_, body_of_cell, {{{0.25, 0.25, 0.25}}, 1, 1.0});
  const auto of = [&](std::vector<char> is_taken) { return recovery.at_nodes(values, 1, is_taken); };
  const auto first = of({1, 0}), second = of({0, 1}), both = of({1, 1});
  double num_shared = 0.0;
  for (PetscInt n = 0; n < layout_.num_local_nodes; ++n) {
    const int bodies = (first.has_value[n] != 0 ? 1 : 0) + (second.has_value[n] != 0 ? 1 : 0);
    num_shared += bodies == 2 ? 1.0 : 0.0;
    EXPECT_NEAR(bodies * both.values[n], first.values[n] + second.values[n], 1e-11);
  }
  EXPECT_GT(maximum(comm, num_shared), 0.0);
}

TEST_P(Patches, AreTheSameOnAnyRanks) {
  const test::Body alone(MPI_COMM_SELF, file_, GetParam().order);
  const PatchRecovery::Samples samples{simplex_rule<3>(2).points, 2};
  const auto rough_values = [&](const NodeLayout& layout) {
    std::vector<double> values;
    for (PetscInt cell = 0; cell < layout.num_local_cells; ++cell) {
      for (const auto& xi : samples.points) values.push_back(test::rough(position_in_cell(layout, cell, xi), 0, 1));
    }
    return values;
  };
  const auto key = [](const Point& X) {
    return std::array{std::lround(X[0] * 1e8), std::lround(X[1] * 1e8), std::lround(X[2] * 1e8)};
  };
  const auto recovered = [&](const NodeLayout& layout) {
    const std::vector<int> bodies(static_cast<std::size_t>(layout.num_local_cells), 0);
    return PatchRecovery(layout, bodies, samples).at_nodes(rough_values(layout), 1, std::vector<char>{1}).values;
  };
  const auto whole = recovered(alone.layout);
  std::map<std::array<long, 3>, double> at;
  for (PetscInt n = 0; n < alone.layout.num_local_nodes; ++n) at[key(alone.layout.position(n))] = whole[n];
  const auto mine = recovered(layout_);
  for (PetscInt n = 0; n < layout_.num_local_nodes; ++n) {
    EXPECT_NEAR(mine[n], at.at(key(layout_.position(n))), 1e-9);
  }
}

TEST_P(Patches, CellsOfFacetsAreOnBothSides) {
  const auto sum_of = [&](const FacetList& facets, int sides) {
    std::vector<PetscInt> owned;
    for (PetscInt f = 0; f < facets.size(); ++f) {
      const auto nodes = facets.nodes_of(f);
      if (facets.is_owned[f] != 0) owned.insert(owned.end(), nodes.begin(), nodes.end());
    }
    double area = 0.0;
    const auto cells = cells_of_facets(layout_, owned, facets.nodes_per_facet);
    for (std::size_t f = 0; f < cells.size(); ++f) {
      EXPECT_GE(cells[f][0], 0);
      EXPECT_EQ(cells[f][1] >= 0, sides == 2);
      const auto nodes = std::span(owned).subspan(f * facets.nodes_per_facet, facets.nodes_per_facet);
      for_each_point_of_facet(layout_, nodes, [&](const IntegrationPoint& point) { area += point.weight; });
    }
    return sum(comm, area);
  };
  const double area = sum_of(surface_facets(body_.mesh, layout_, [](const auto&) { return true; }), 1);
  if (GetParam().shape == Shape::jittered) {
    EXPECT_NEAR(area, 6.0, 1e-12);
  }
  double volume = 0.0;
  for (PetscInt cell = 0; cell < layout_.num_owned_cells; ++cell) {
    for_each_point_of_cell(layout_, cell, [&](const IntegrationPoint& point) { volume += point.weight; });
  }
  EXPECT_NEAR(sum(comm, volume), GetParam().volume(), 1e-12);
}

}  // namespace
}  // namespace pliant::test_patch_recovery
