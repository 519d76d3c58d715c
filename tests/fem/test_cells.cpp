// Packs of cells: their measure, their gradients, their bookkeeping.
#include "base/error.hpp"
#include "fem/body.hpp"
#include "fem/cells.hpp"

namespace pliant::test_cells {
namespace {

using test::Body;
using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;

const MPI_Comm comm = MPI_COMM_WORLD;

template <int Order>
CellGroups<Order> groups_of(const Body& body, int degree) {
  return make_cell_groups<Order>(body.layout, body.pattern,
                                 std::vector<int>(static_cast<std::size_t>(body.layout.num_local_cells), 0), {degree});
}

class Cells : public test::OnBodies {
 protected:
  /// Calls the template argument's body with the order as a constant.
  template <class Run>
  void for_order(Run run) const {
    if (GetParam().order == 1) {
      run(std::integral_constant<int, 1>{});
    } else {
      run(std::integral_constant<int, 2>{});
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Bodies, Cells,
                         ::testing::Values(BodySpec{1, Shape::straight, 1}, BodySpec{1, Shape::jittered, 3},
                                           BodySpec{2, Shape::jittered, 2}, BodySpec{2, Shape::curved, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

// The determinant of a quadratic map is a cubic: a rule of degree 3 or more is exact.
TEST_P(Cells, OwnedMeasuresSumToTheVolume) {
  for_order([&](auto order) {
    for (const int degree : {3, 4, 5, 7}) {
      double mine = 0.0;
      for (const auto& group : groups_of<order>(body_, degree)) {
        for (std::size_t b = 0; b < group.batches.size(); ++b) {
          for (int q = 0; q < group.rule.size(); ++q) {
            mine += sum(group.batches[b].owned * (group.rule.weights[q] * group.jacobian[group.geometry(b, q)]));
          }
        }
      }
      EXPECT_NEAR(pliant::sum(comm, mine), GetParam().volume(), 1e-13);
    }
  });
}

TEST_P(Cells, EveryLocalCellIsInOneLane) {
  for_order([&](auto order) {
    std::vector<int> uses(static_cast<std::size_t>(layout_.num_local_cells), 0);
    double owned = 0.0;
    for (const auto& group : groups_of<order>(body_, 2)) {
      ASSERT_EQ(group.cells.size(), group.batches.size() * pack_size);
      for (std::size_t b = 0; b < group.batches.size(); ++b) {
        const auto& batch = group.batches[b];
        owned += sum(batch.owned);
        for (int lane = 0; lane < pack_size; ++lane) {
          const PetscInt cell = group.cells[b * pack_size + lane];
          EXPECT_EQ(cell >= 0, lane < batch.num_lanes);
          if (cell < 0) {
            EXPECT_EQ(batch.owned[lane], 0.0);
            EXPECT_EQ(group.jacobian[group.geometry(b, 0)][lane], 0.0);
            continue;
          }
          ++uses[static_cast<std::size_t>(cell)];
          const auto nodes = layout_.nodes_of_cell(cell);
          for (std::size_t a = 0; a < nodes.size(); ++a) EXPECT_EQ(batch.nodes[a][lane], nodes[a]);
          EXPECT_EQ(group.shape == CellShape::affine, layout_.cell_is_affine[cell] != 0);
        }
      }
    }
    EXPECT_EQ(owned, static_cast<double>(layout_.num_owned_cells));
    EXPECT_EQ(uses, std::vector<int>(uses.size(), 1));
  });
}

// A field of the element's degree in X on straight cells; on curved ones affine fields are what P2 holds exactly.
TEST_P(Cells, GradientsOfPolynomialsAreExact) {
  const bool quadratic = GetParam().order == 2 && GetParam().shape != Shape::curved;
  const double c = quadratic ? 1.0 : 0.0;
  const auto field = [&](const Point& x) {
    return Point{1.0 + 0.3 * x[0] - 0.2 * x[1] + c * x[0] * x[1], 0.7 * x[2] + c * (x[2] * x[2] - x[0] * x[2]),
                 -0.4 * x[0] + 0.1 * x[1] + 0.6 * x[2] + c * x[1] * x[1]};
  };
  const auto gradient = [&](const Point& x) {
    return Tensor3<double>{{0.3 + c * x[1], -0.2 + c * x[0], 0.0, -c * x[2], 0.0, 0.7 + c * (2.0 * x[2] - x[0]), -0.4,
                            0.1 + 2.0 * c * x[1], 0.6}};
  };
  std::vector<double> u;
  for (PetscInt a = 0; a < layout_.num_local_nodes; ++a) {
    for (const double value : field(layout_.position(a))) u.push_back(value);
  }
  for_order([&](auto order) {
    for (const auto& group : groups_of<order>(body_, 4)) {
      for (std::size_t b = 0; b < group.batches.size(); ++b) {
        const auto values = gather<order>(group.batches[b], u.data());
        const auto at = gather<order>(group.batches[b], layout_.coordinates.data());
        for (int q = 0; q < group.rule.size(); ++q) {
          const auto H =
              displacement_gradient<order>(values, group.gradients(q), group.inverse_jacobian[group.geometry(b, q)]);
          const auto N = Tet<order>::values(group.rule.points[q]);
          for (int lane = 0; lane < group.batches[b].num_lanes; ++lane) {
            Point x{};
            for (std::size_t a = 0; a < N.size(); ++a) {
              for (int k = 0; k < 3; ++k) x[k] += N[a] * at[a][k][lane];
            }
            const auto expected = gradient(x);
            for (int i = 0; i < 9; ++i) EXPECT_NEAR(H.a[i][lane], expected.a[i], 2e-14);
          }
        }
      }
    }
  });
}

// A motion of the whole body by 1000 m does not disturb the gradient of strains of 1e-8 more than its own rounding.
TEST_P(Cells, CommonMotionsCancelBeforeTheyAreMultiplied) {
  std::vector<double> u(layout_.coordinates.size(), 1000.0);
  for_order([&](auto order) {
    for (const auto& group : groups_of<order>(body_, 2)) {
      for (std::size_t b = 0; b < group.batches.size(); ++b) {
        const auto values = gather<order>(group.batches[b], u.data());
        const auto H =
            displacement_gradient<order>(values, group.gradients(0), group.inverse_jacobian[group.geometry(b, 0)]);
        for (const Pack& h : H.a) EXPECT_TRUE(all_of(h == 0.0));
      }
    }
  });
}

TEST_P(Cells, ScatterIsTheTransposeOfGather) {
  std::vector<double> u(layout_.coordinates.size()), counts(u.size(), 0.0), expected(u.size(), 0.0);
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = std::sin(3.0 * static_cast<double>(i));
  for (const PetscInt n : layout_.cell_nodes) {
    for (int k = 0; k < 3; ++k) expected[3 * n + k] += u[3 * n + k];
  }
  for_order([&](auto order) {
    for (const auto& group : groups_of<order>(body_, 1)) {
      for (const auto& batch : group.batches) scatter_add<order>(batch, gather<order>(batch, u.data()), counts.data());
    }
  });
  for (std::size_t i = 0; i < u.size(); ++i) EXPECT_NEAR(counts[i], expected[i], 1e-12);
}

TEST_P(Cells, BodiesAreKeptApart) {
  std::vector<int> body_of_cell(static_cast<std::size_t>(layout_.num_local_cells));
  for (PetscInt c = 0; c < layout_.num_local_cells; ++c) {
    body_of_cell[c] = layout_.position(layout_.nodes_of_cell(c)[0])[0] < 0.3 ? 0 : (c % 2 == 0 ? 1 : -1);
  }
  for_order([&](auto order) {
    PetscInt counted = 0;
    for (const auto& group : make_cell_groups<order>(layout_, body_.pattern, body_of_cell, {2, 4})) {
      EXPECT_EQ(group.rule.size(), simplex_rule<3>(group.body == 0 ? 2 : 4).size());
      for (const PetscInt cell : group.cells) {
        if (cell < 0) continue;
        EXPECT_EQ(body_of_cell[cell], group.body);
        ++counted;
      }
    }
    const auto without = std::count(body_of_cell.begin(), body_of_cell.end(), -1);
    EXPECT_EQ(counted + without, layout_.num_local_cells);
  });
}

TEST(FoldedCells, AreRefusedByName) {
  const Scratch scratch(comm);
  const auto file = scratch.file("body.msh", [&](const std::string& f) { test::write_body(f, {2, Shape::curved, 1}); });
  Body body(MPI_COMM_SELF, file, 2);
  // Fold the first cell: the middle of its first edge far beyond the opposite corner.
  const auto nodes = body.layout.nodes_of_cell(0);
  for (int k = 0; k < 3; ++k) {
    body.layout.coordinates[3 * nodes[4] + k] +=
        3.0 * (body.layout.coordinates[3 * nodes[3] + k] - body.layout.coordinates[3 * nodes[0] + k]) +
        3.0 * (body.layout.coordinates[3 * nodes[2] + k] - body.layout.coordinates[3 * nodes[0] + k]);
  }
  body.layout.cell_is_affine.assign(body.layout.cell_is_affine.size(), 0);
  EXPECT_THROW(groups_of<2>(body, 4), InputError);
}

}  // namespace
}  // namespace pliant::test_cells
