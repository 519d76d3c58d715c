// Order of convergence in space against a manufactured solution (docs: verification), with the reference's error norms.
#include "material/states.hpp"
#include "places.hpp"
#include "solver/problem.hpp"

namespace pliant::test_manufactured {
namespace {

using test::Point;
using test::Problem;
using test::ProblemSpec;
using test::Scratch;
using test::Shape;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;
using Real = long double;
using RealPoint = std::array<Real, 3>;

const ElasticLawSpec spec_of_law = make_law("saint-venant-kirchhoff", 20000.0, 0.3);
const auto law = std::get<SaintVenantKirchhoff<double>>(instantiate(spec_of_law));

RealPoint exact(const RealPoint& X) {
  const auto [x, y, z] = X;
  return {(x * y + x * x + y * y * y + 6 * z) / 80, (z * x - z * z * z + x * y * y + 3 * x * x * x * x) / 80,
          (x * y * z + z * z * y * y - 2 * x) / 80};
}

Tensor3<Real> exact_gradient(const RealPoint& X) {
  const auto [x, y, z] = X;
  return Real(1) / 80 *
         Tensor3<Real>{{y + 2 * x, x + 3 * y * y, 6, z + y * y + 12 * x * x * x, 2 * x * y, x - 3 * z * z, y * z - 2,
                        x * z + 2 * z * z * y, x * y + 2 * z * y * y}};
}

/// -Div P(grad u), by central differences of fourth order; their error is far below a double's.
Point body_force(const Point& x) {
  const Real h = 1e-3L;
  const auto stress = [&](int axis, Real distance) {
    RealPoint X{x[0], x[1], x[2]};
    X[static_cast<std::size_t>(axis)] += distance;
    // The textbook's formula: P = F (2 mu E + lambda tr(E) I).
    const auto F = add_to_diagonal(exact_gradient(X), 1);
    const auto E = Real(0.5) * add_to_diagonal(matmul(transpose(F), F), -1);
    return matmul(F, add_to_diagonal(Real(2 * law.mu) * E, law.lambda * trace(E)));
  };
  Point b{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto near = stress(axis, h) - stress(axis, -h), far = stress(axis, 2 * h) - stress(axis, -2 * h);
    for (int i = 0; i < 3; ++i) b[i] -= static_cast<double>((8 * near(i, axis) - far(i, axis)) / (12 * h));
  }
  return b;
}

/// The reference's rule for loads and errors: Gauss-Legendre's four points in each direction of the cube, collapsed. It
/// is exact to degree 5 only, which its error norms show: an exact rule finds errors larger by 1e-4 (P1) and 1e-2 (P2)
/// of them.
QuadratureRule<3> collapsed_rule() {
  constexpr std::array<std::array<double, 2>, 4> gauss{{{0.5 - 0.4305681557970263, 0.1739274225687269},
                                                        {0.5 - 0.1699905217924281, 0.3260725774312731},
                                                        {0.5 + 0.1699905217924281, 0.3260725774312731},
                                                        {0.5 + 0.4305681557970263, 0.1739274225687269}}};
  QuadratureRule<3> rule;
  for (const auto& [a, wa] : gauss) {
    for (const auto& [b, wb] : gauss) {
      for (const auto& [c, wc] : gauss) {
        rule.points.push_back({c * (1 - a) * (1 - b), b * (1 - a), a});
        rule.weights.push_back(wa * wb * wc * (1 - a) * (1 - a) * (1 - b));
      }
    }
  }
  return rule;
}

/// The corners of a cell of the structured mesh in the reference's order, on which a collapsed rule depends: from the
/// lowest to the highest, those between so that the cell is positively oriented.
std::array<int, 4> reference_order(const NodeLayout& layout, std::span<const PetscInt> nodes) {
  std::array<int, 4> order{0, 1, 2, 3};
  const auto height = [&](int a) {
    const Point x = layout.position(nodes[a]);
    return x[0] + x[1] + x[2];
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return height(a) < height(b); });
  int inversions = 0;
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
  }
  if (inversions % 2 == 1) std::swap(order[1], order[2]);
  return order;
}

/// Calls `visit(nodes, point, N, weight)` at the points of the reference's rule.
template <int Order, class Visit>
void for_each_point(const NodeLayout& layout, PetscInt num_cells, Visit visit) {
  const auto rule = collapsed_rule();
  for (PetscInt c = 0; c < num_cells; ++c) {
    const auto nodes = layout.nodes_of_cell(c);
    const auto order = reference_order(layout, nodes);
    Tensor3<double> J{};
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) J(i, k) = layout.position(nodes[k + 1])[i] - layout.position(nodes[0])[i];
    }
    for (int q = 0; q < rule.size(); ++q) {
      const auto weights = Tet<1>::values(rule.points[q]);
      std::array<double, 4> L{};  // barycentric coordinates in the cell's own order
      for (int a = 0; a < 4; ++a) L[order[a]] = weights[a];
      Point X{};
      for (int a = 0; a < 4; ++a) {
        for (int i = 0; i < 3; ++i) X[i] += L[a] * layout.position(nodes[a])[i];
      }
      visit(nodes, X, Tet<Order>::values({L[1], L[2], L[3]}), rule.weights[q] * det(J));
    }
  }
}

template <int Order>
double error_on(const Scratch& scratch, int n) {
  const auto file = scratch.file("cube" + std::to_string(n) + ".msh", [&](const std::string& f) {
    test::write_body(f, {1, Shape::straight, n});
  });
  ProblemSpec spec;
  spec.order = Order;
  spec.law = spec_of_law;
  spec.newton.relative = 1e-10;
  spec.supports = {{test::on_the_surface,
                    {Expression("(x*y+x^2+y^3+6*z)/80"), Expression("(z*x-z^3+x*y^2+3*x^4)/80"),
                     Expression("(x*y*z+z^2*y^2-2*x)/80")}}};
  spec.loads = [](const Solid& solid) {
    const NodeLayout& layout = solid.layout();
    std::vector<double> f(3 * static_cast<std::size_t>(layout.num_local_nodes), 0.0);
    for_each_point<Order>(layout, layout.num_local_cells,
                          [&](auto nodes, const Point& X, const auto& N, double weight) {
                            const Point b = body_force(X);
                            for (std::size_t a = 0; a < nodes.size(); ++a) {
                              for (int i = 0; i < 3; ++i) f[3 * nodes[a] + i] += weight * N[a] * b[i];
                            }
                          });
    std::vector<std::unique_ptr<EnergyTerm>> loads;
    loads.push_back(std::make_unique<test::NodalForces>(layout, std::move(f)));
    return loads;
  };
  Problem problem(comm, file, spec);
  const auto q = problem.solid().vector(test::at_rest);
  const auto report = problem.solve_static(q);
  EXPECT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  const auto u = test::local_values(q.get());
  double square = 0.0;
  const NodeLayout& layout = problem.solid().layout();
  for_each_point<Order>(layout, layout.num_owned_cells, [&](auto nodes, const Point& X, const auto& N, double weight) {
    const auto expected = exact({X[0], X[1], X[2]});
    for (int i = 0; i < 3; ++i) {
      double value = 0.0;
      for (std::size_t a = 0; a < nodes.size(); ++a) value += N[a] * u[3 * nodes[a] + i];
      square += weight * std::pow(value - static_cast<double>(expected[i]), 2);
    }
  });
  return std::sqrt(sum(comm, square));
}

template <int Order>
void expect_errors(const std::vector<double>& reference, double tolerance) {
  const Scratch scratch(comm);
  std::vector<double> errors;
  for (std::size_t level = 0; level < reference.size(); ++level) {
    errors.push_back(error_on<Order>(scratch, 2 << level));
    EXPECT_NEAR(errors[level], reference[level], tolerance * reference[level]);
  }
  const double slope = std::log2(errors[errors.size() - 2] / errors.back());
  EXPECT_NEAR(slope, Order + 1.0, 0.15);
}

TEST(ManufacturedSolution, LinearElementsAreOfSecondOrder) {
  expect_errors<1>({4.901220e-3, 1.288143e-3, 3.257730e-4}, 1e-6);
}

// The reference integrates the stiffness by 27 collapsed points, not quite exactly; here it is exact.
TEST(ManufacturedSolution, QuadraticElementsAreOfThirdOrder) {
  if (num_ranks(comm) > 1) GTEST_SKIP() << "linear elements show that ranks do not matter";
  std::vector<double> reference{3.834696e-4, 4.874802e-5};
  if (has_time()) reference.push_back(6.118475e-6);
  expect_errors<2>(reference, 5e-5);
}

}  // namespace
}  // namespace pliant::test_manufactured
