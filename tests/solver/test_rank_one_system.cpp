// Parts of rank one in linear systems and in Newton's method.
#include "solver/linear.hpp"
#include "solver/problem.hpp"
#include "solver/rank_one_system.hpp"

namespace pliant::test_rank_one_system {
namespace {

using test::BodySpec;
using test::Point;
using test::Problem;
using test::ProblemSpec;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;

TEST(RankOneSystems, AreSolvedAsFastAsTheSparsePartAlone) {
  const Scratch scratch(comm);
  const auto file = scratch.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::jittered, 4});
  });
  const Solid solid(comm, file, 1, 1);
  const auto elastic = solid.elastic(make_law("neo-hookean", 1e6, 0.3));
  const auto inertia = solid.inertia(1000.0, Mass::consistent);
  IncrementalPotential potential(solid.layout(), solid.pattern(), {elastic.get(), inertia.get()},
                                 solid.nothing_prescribed());
  TestStage stage(solid, 0.0, 0.1);
  potential.begin_stage(stage.point);
  const Handle<Mat> K = potential.make_hessian();
  potential.hessian(stage.q0.get(), K.get(), Projection::none);
  const auto b = solid.vector(test::rough_field(1.0, 1));
  const Handle<Vec> x = potential.make_vector(), Ax = potential.make_vector();
  for (const auto kind : {LinearKind::cholesky, LinearKind::amg}) {
    for (const auto symmetry : {Symmetry::symmetric, Symmetry::unsymmetric}) {
      PetscInt alone = 0;
      for (const double c : {0.0, 1e3, 1e9}) {
        std::vector<RankOne> parts;
        for (int k = 0; k < 3; ++k) {
          parts.push_back({c * (k + 1), solid.vector(test::rough_field(1.0, 5 + k))});
        }
        parts[2].g = test::moved(parts[0].g.get(), 0.1, parts[1].g.get());  // hardly independent
        Handle<KSP> ksp;
        check(KSPCreate(comm, ksp.out()));
        configure_linear_solver(ksp.get(), K.get(), kind, symmetry);
        check(KSPSetTolerances(ksp.get(), 1e-9, PETSC_DEFAULT, PETSC_DEFAULT, 500));
        RankOneSystem system(ksp.get(), K.get(), parts);
        ASSERT_EQ(set_up_preconditioner(system.inner(), K.get()), SetUp::sound);
        ASSERT_TRUE(system.set_up());
        EXPECT_EQ(system.negative_eigenvalues(), 0);
        check(KSPSolve(ksp.get(), b.get(), x.get()));
        PetscInt iterations = 0;
        check(KSPGetIterationNumber(ksp.get(), &iterations));
        check(MatMult(system.matrix(), x.get(), Ax.get()));
        // Backward error: an iteration that measures P r sees little of r along g, where P is small.
        double size = test::norm(b.get());
        for (const auto& [factor, g] : parts) {
          size += factor * std::pow(test::norm(g.get()), 2) * test::norm(x.get());
        }
        EXPECT_LE(test::distance(Ax.get(), b.get()), 1e-9 * size) << "c = " << c;
        if (c == 0.0) alone = iterations;
        EXPECT_LE(iterations, alone + 6) << "c = " << c;  // at most two more for each part
      }
    }
  }
}

// diag(-1, 1, 1, ...) + c e0 e0^T is definite where c > 1.
TEST(RankOneSystems, TellHowManyNegativeEigenvaluesTheWholeHas) {
  Handle<Mat> K;
  check(MatCreateAIJ(comm, 4, 4, PETSC_DETERMINE, PETSC_DETERMINE, 1, nullptr, 0, nullptr, K.out()));
  PetscInt first = 0, end = 0;
  check(MatGetOwnershipRange(K.get(), &first, &end));
  for (PetscInt i = first; i < end; ++i) check(MatSetValue(K.get(), i, i, i == 0 ? -1.0 : 1.0, INSERT_VALUES));
  check(MatAssemblyBegin(K.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K.get(), MAT_FINAL_ASSEMBLY));
  check(MatSetOption(K.get(), MAT_SYMMETRIC, PETSC_TRUE));
  for (const double c : {0.0, 0.5, 2.0}) {
    std::vector<RankOne> parts(1);
    parts[0].c = c;
    check(MatCreateVecs(K.get(), parts[0].g.out(), nullptr));
    if (first == 0) check(VecSetValue(parts[0].g.get(), 0, 1.0, INSERT_VALUES));
    check(VecAssemblyBegin(parts[0].g.get()));
    check(VecAssemblyEnd(parts[0].g.get()));
    Handle<KSP> ksp;
    check(KSPCreate(comm, ksp.out()));
    configure_linear_solver(ksp.get(), K.get(), LinearKind::cholesky, Symmetry::symmetric);
    RankOneSystem system(ksp.get(), K.get(), parts);
    ASSERT_EQ(set_up_preconditioner(system.inner(), K.get()), SetUp::sound);
    ASSERT_TRUE(system.set_up());
    EXPECT_EQ(negative_pivots(system.inner()).value() - system.negative_eigenvalues(), c > 1.0 ? 0 : 1);
  }
}

/// A unit cube on rollers whose three other faces press into a fluid: it stays a cube, of sides l, with
///
///     -p(S) = sigma(l) = (mu (l^2 - 1) + lambda ln l^3) / l^3,    S = l^3 - 1
ProblemSpec in_a_fluid(const CavityContent& content) {
  ProblemSpec spec;
  spec.order = 2;
  spec.law = make_law("neo-hookean", 1e6, 0.3);
  spec.supports = test::rollers();
  spec.newton.relative = 1e-11;
  spec.loads = [content](const Solid& solid) {
    FacetList walls;
    for (int axis = 0; axis < 3; ++axis) {
      const auto face = surface_facets(solid.mesh(), solid.layout(), test::face(axis, 1.0));
      walls.nodes_per_facet = face.nodes_per_facet;
      walls.nodes.insert(walls.nodes.end(), face.nodes.begin(), face.nodes.end());
      walls.is_owned.insert(walls.is_owned.end(), face.is_owned.begin(), face.is_owned.end());
      walls.is_outer.insert(walls.is_outer.end(), face.is_outer.begin(), face.is_outer.end());
    }
    std::vector<std::unique_ptr<EnergyTerm>> terms;
    terms.push_back(
        std::make_unique<Cavity>(WettedSurface(solid.layout(), solid.pattern(), std::move(walls), 0), content));
    return terms;
  };
  return spec;
}

double side_of_cube(const CavityContent& content) {
  const double mu = 1e6 / 2.6, lambda = 1e6 * 0.3 / (1.3 * 0.4);
  double low = 0.5, high = 1.6;
  for (int i = 0; i < 100; ++i) {
    const double l = 0.5 * (low + high), J = l * l * l;
    const double stress = (mu * (l * l - 1.0) + lambda * std::log(J)) / J;
    const double p = std::visit([&](const auto& of) { return of.pressure(J - 1.0, LoadState{1.0}); }, content);
    (stress + p > 0.0 ? high : low) = l;
  }
  return low;
}

class CubesInFluids : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Contents, CubesInFluids, ::testing::Values(0, 1, 2, 3));

TEST_P(CubesInFluids, FindTheirSizeInAFewIterations) {
  const std::array<CavityContent, 4> contents{
      GivenPressure{Expression("2e5*t")}, Gas{0.5, 4e5, 1e5, 1.4, Expression(1.0)},
      Gas{0.5, 0.0, 1e5, 1.0, Expression("1-0.9*t")}, Liquid{0.5, 0.0, 1e12, Expression("0.2*t")}};  // as good as rigid
  const CavityContent& content = contents[static_cast<std::size_t>(GetParam())];
  const Scratch scratch(comm);
  const auto file = scratch.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::jittered, 2});
  });
  Problem problem(comm, file, in_a_fluid(content));
  EXPECT_TRUE(problem.potential().is_potential());
  EXPECT_EQ(problem.potential().symmetry(), Symmetry::symmetric);
  const auto q = problem.solid().vector(test::at_rest);
  const auto report = problem.solve_static(q);
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  const double l = side_of_cube(content);
  EXPECT_GT(std::abs(l - 1.0), 0.01);
  EXPECT_LE(test::deviation(problem.solid(), q.get(),
                            [l](const Point& X) {
                              return Point{(l - 1.0) * X[0], (l - 1.0) * X[1], (l - 1.0) * X[2]};
                            }),
            1e-9);
  // Newton's method in full: quadratic, and with one or two iterations of the linear solver each.
  EXPECT_LE(report.newton_iterations, 8);
  EXPECT_LE(problem.statistics().linear_iterations, 4 * report.newton_iterations);
  // The first guesses squeeze the liquid so much that its pressure would buckle anything.
  EXPECT_LE(problem.statistics().projections, std::holds_alternative<Liquid>(content) ? 4 : 0);
}

}  // namespace
}  // namespace pliant::test_rank_one_system
