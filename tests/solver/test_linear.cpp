// Linear solvers: what they recover from.
#include "energy/solid.hpp"
#include "petsc/collective.hpp"
#include "solver/linear.hpp"
#include "solver/single_factorization.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

namespace pliant::test_linear {
namespace {

using test::Scratch;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;

/// Leaves the factorization to come a twentieth of the workspace that MUMPS estimates.
void shrink_workspace(KSP ksp) {
  PC pc = nullptr;
  Mat factor = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(PCFactorGetMatrix(pc, &factor));
  check(MatMumpsSetIcntl(factor, 14, -95));
}

/// An option of PETSc while the object lives.
class Option {
 public:
  Option(const char* name, const char* value) : name_(name) { check(PetscOptionsSetValue(nullptr, name, value)); }
  ~Option() { (void)PetscOptionsClearValue(nullptr, name_); }
  Option(const Option&) = delete;
  Option& operator=(const Option&) = delete;

 private:
  const char* name_;
};

/// A cube of linear tetrahedra, E = 1 MPa, with `density` / s^2 times its mass matrix: the less of it, the nearer to
/// the six motions that cost nothing.
class Cube {
 public:
  explicit Cube(double density)
      : solid_(comm,
               scratch_.file("cube.msh",
                             [](const std::string& f) {
                               test::write_body(f, {1, test::Shape::straight, 8});
                             }),
               1, 2),
        elastic_(solid_.elastic(make_law("linear", 1e6, 0.3))),
        inertia_(solid_.inertia(density, Mass::consistent)),
        potential_(solid_.layout(), solid_.pattern(), {elastic_.get(), inertia_.get()}, solid_.nothing_prescribed()),
        stage_(solid_, 0.0, 1.0),
        K_(potential_.make_hessian()) {
    potential_.begin_stage(stage_.point);
    potential_.hessian(stage_.q0.get(), K_.get(), Projection::none);
  }
  Mat K() const { return K_.get(); }
  Handle<Vec> vector() const { return potential_.make_vector(); }
  /// K x for a rough field x.
  Handle<Vec> right_hand_side() const {
    const auto x = solid_.vector(test::rough_field(1.0, 1));
    Handle<Vec> b = vector();
    check(MatMult(K(), x.get(), b.get()));
    return b;
  }
  double residual(Vec x, Vec b) const {
    const Handle<Vec> Kx = vector();
    check(MatMult(K(), x, Kx.get()));
    return test::distance(Kx.get(), b) / test::norm(b);
  }

 private:
  Scratch scratch_{comm};
  Solid solid_;
  std::unique_ptr<ElasticTerm> elastic_;
  std::unique_ptr<Inertia> inertia_;
  IncrementalPotential potential_;
  test::TestStage stage_;
  Handle<Mat> K_;
};

Handle<KSP> solver_of(const Cube& cube, Symmetry symmetry, LinearKind kind = LinearKind::cholesky) {
  Handle<KSP> ksp;
  check(KSPCreate(comm, ksp.out()));
  configure_linear_solver(ksp.get(), cube.K(), kind, symmetry);
  return ksp;
}

PC preconditioner_of(KSP ksp) {
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  return pc;
}

bool set_up(KSP ksp, Mat K) {
  return set_up_preconditioner(preconditioner_of(ksp), K) == SetUp::sound;
}

PetscInt num_negative(KSP ksp) {
  return negative_pivots(preconditioner_of(ksp)).value_or(-1);
}

bool is_in_single_precision(KSP ksp) {
  const char* name = nullptr;
  check(PCShellGetName(preconditioner_of(ksp), &name));
  return std::string_view(name).find("single precision") != std::string_view::npos;
}

// It fails with too little, as a plain set-up shows, and is given more.
TEST(LinearSolver, AFactorizationOutOfWorkspaceIsRepeatedWithMore) {
  const Cube cube(1e6);
  for (const auto symmetry : {Symmetry::symmetric, Symmetry::unsymmetric}) {
    const Option type("-pc_type", symmetry == Symmetry::symmetric ? "cholesky" : "lu");
    const Option library("-pc_factor_mat_solver_type", "mumps");
    const auto plain = solver_of(cube, symmetry), ksp = solver_of(cube, symmetry);
    for (const auto& solver : {plain.get(), ksp.get()}) shrink_workspace(solver);
    check(KSPSetUp(plain.get()));
    PC pc = nullptr;
    PCFailedReason failure = PC_NOERROR;
    check(KSPGetPC(plain.get(), &pc));
    check(PCGetFailedReason(pc, &failure));
    ASSERT_NE(failure, PC_NOERROR);

    ASSERT_TRUE(set_up(ksp.get(), cube.K()));
    const auto b = cube.right_hand_side(), x = cube.vector();
    check(KSPSolve(ksp.get(), b.get(), x.get()));
    PetscInt iterations = 0;
    check(KSPGetIterationNumber(ksp.get(), &iterations));
    EXPECT_LE(iterations, 2);
    EXPECT_LE(cube.residual(x.get(), b.get()), 1e-5);
  }
}

TEST(LinearSolver, AFactorizationInSinglePrecisionOutOfWorkspaceIsRepeatedWithMore) {
  const Option option("-mat_mumps_icntl_14", "-95");
  const Cube cube(1e6);
  SingleFactorization factorization(Symmetry::symmetric);
  ASSERT_EQ(factorization.factorize(cube.K()), SetUp::sound);
  const auto b = cube.right_hand_side(), x = cube.vector();
  factorization.solve(b.get(), x.get());
  EXPECT_LE(cube.residual(x.get(), b.get()), 1e-5);
}

// MUMPS may take a megabyte per rank, a third of what it needs.
TEST(LinearSolver, MultigridTakesOverWhereMemoryDoesNotSuffice) {
  const Option limit("-mat_mumps_icntl_23", "1");
  const Cube cube(1e6);
  SingleFactorization factorization(Symmetry::symmetric);
  ASSERT_EQ(factorization.factorize(cube.K()), SetUp::out_of_memory);
  for (const auto symmetry : {Symmetry::symmetric, Symmetry::unsymmetric}) {
    const auto ksp = solver_of(cube, symmetry);
    EXPECT_FALSE(uses_multigrid_instead(preconditioner_of(ksp.get())));
    for (int time = 0; time < 2; ++time) {  // again, as for the next Hessian
      ASSERT_TRUE(set_up(ksp.get(), cube.K()));
      EXPECT_TRUE(uses_multigrid_instead(preconditioner_of(ksp.get())));
      EXPECT_EQ(num_negative(ksp.get()), -1);  // it does not count them
      const auto b = cube.right_hand_side(), x = cube.vector();
      check(KSPSolve(ksp.get(), b.get(), x.get()));
      PetscInt iterations = 0;
      check(KSPGetIterationNumber(ksp.get(), &iterations));
      EXPECT_LE(iterations, 40);
      EXPECT_LE(cube.residual(x.get(), b.get()), 1e-5);
    }
  }
}

// Step by step: in double precision, with another ordering; then there is nothing better.
TEST(LinearSolver, APoorFactorizationGivesWayToABetterOne) {
  const Cube cube(1e6);
  for (const auto symmetry : {Symmetry::symmetric, Symmetry::unsymmetric}) {
    const auto ksp = solver_of(cube, symmetry);
    PC pc = preconditioner_of(ksp.get());
    ASSERT_TRUE(set_up(ksp.get(), cube.K()));
    EXPECT_TRUE(is_in_single_precision(ksp.get()));
    const auto b = cube.right_hand_side(), x = cube.vector();
    for (int refinement = 0; refinement < 2; ++refinement) {
      ASSERT_TRUE(refine_factorization(pc));
      ASSERT_TRUE(set_up(ksp.get(), cube.K()));
      EXPECT_FALSE(is_in_single_precision(ksp.get()));
      check(KSPSetTolerances(ksp.get(), 1e-12, 0.0, PETSC_DEFAULT, PETSC_DEFAULT));
      check(KSPSolve(ksp.get(), b.get(), x.get()));
      PetscInt iterations = 0;
      check(KSPGetIterationNumber(ksp.get(), &iterations));
      EXPECT_LE(iterations, 1);
      EXPECT_LE(cube.residual(x.get(), b.get()), 1e-12);
    }
    EXPECT_FALSE(refine_factorization(pc));
    EXPECT_TRUE(set_up(ksp.get(), cube.K()));
  }
}

// Who asks for a factorization of PETSc's is told that there is none, and not that the matrix is singular.
TEST(LinearSolver, AFactorizationOfTheUsersThatLacksMemorySaysSo) {
  const Option limit("-mat_mumps_icntl_23", "1");
  const Option library("-pc_factor_mat_solver_type", "mumps");
  const Cube cube(1e6);
  for (const auto symmetry : {Symmetry::symmetric, Symmetry::unsymmetric}) {
    const Option type("-pc_type", symmetry == Symmetry::symmetric ? "cholesky" : "lu");
    const auto ksp = solver_of(cube, symmetry);
    EXPECT_EQ(set_up_preconditioner(preconditioner_of(ksp.get()), cube.K()), SetUp::out_of_memory);
  }
}

// eps = 6e-8 of single precision times some tens of operations; whatever the size of the numbers.
TEST(LinearSolver, SinglePrecisionIsAGoodPreconditioner) {
  const Cube cube(1e6);
  for (const double scale : {1.0, 1e-60, 1e60}) {
    check(MatScale(cube.K(), scale));
    for (const auto symmetry : {Symmetry::symmetric, Symmetry::unsymmetric}) {
      SingleFactorization factorization(symmetry);
      for (int again = 0; again < 2; ++again) {
        ASSERT_EQ(factorization.factorize(cube.K()), SetUp::sound);
        const auto b = cube.right_hand_side(), x = cube.vector();
        factorization.solve(b.get(), x.get());
        EXPECT_LE(cube.residual(x.get(), b.get()), 1e-5);
        EXPECT_EQ(factorization.negative_pivots(), 0);
        check(VecZeroEntries(b.get()));
        factorization.solve(b.get(), x.get());
        EXPECT_EQ(test::norm(x.get()), 0.0);
      }
      const auto ksp = solver_of(cube, symmetry);
      ASSERT_TRUE(set_up(ksp.get(), cube.K()));
      EXPECT_TRUE(is_in_single_precision(ksp.get()));
      check(KSPSetTolerances(ksp.get(), 1e-12, 0.0, PETSC_DEFAULT, PETSC_DEFAULT));
      const auto b = cube.right_hand_side(), x = cube.vector();
      check(KSPSolve(ksp.get(), b.get(), x.get()));
      PetscInt iterations = 0;
      check(KSPGetIterationNumber(ksp.get(), &iterations));
      EXPECT_LE(iterations, 4);
      EXPECT_LE(cube.residual(x.get(), b.get()), 2e-12);
    }
    check(MatScale(cube.K(), 1.0 / scale));
  }
}

TEST(LinearSolver, SinglePrecisionCountsNegativePivots) {
  const Cube cube(1e6);
  Handle<Vec> shift = cube.vector();
  check(MatGetDiagonal(cube.K(), shift.get()));
  PetscInt expected = 0;
  {
    // A row far below zero is a negative pivot, wherever it stands: its neighbours weigh little against it.
    PetscInt begin = 0;
    check(VecGetOwnershipRange(shift.get(), &begin, nullptr));
    const ArrayView values(shift.get());
    for (std::size_t i = 0; i < values.span().size(); ++i) {
      const bool is_chosen = (begin + static_cast<PetscInt>(i)) % 7 == 0;
      values[static_cast<PetscInt>(i)] *= is_chosen ? -1e4 : 0.0;
      expected += is_chosen;
    }
  }
  expected = static_cast<PetscInt>(sum(comm, static_cast<PetscInt64>(expected)));
  check(MatDiagonalSet(cube.K(), shift.get(), ADD_VALUES));
  const auto ksp = solver_of(cube, Symmetry::symmetric);
  ASSERT_TRUE(set_up(ksp.get(), cube.K()));
  EXPECT_EQ(num_negative(ksp.get()), expected);
  // Double precision found the same, and leaves the work to single precision.
  EXPECT_TRUE(is_in_single_precision(ksp.get()));
}

/// Changes the entries of the first six rows by a part of them, each by another one: as a rigid part makes them.
void make_nearly_symmetric(Mat K, double part) {
  const Handle<Mat> before = [&] {
    Handle<Mat> copy;
    check(MatDuplicate(K, MAT_COPY_VALUES, copy.out()));
    return copy;
  }();
  PetscInt begin = 0, end = 0;
  check(MatGetOwnershipRange(K, &begin, &end));
  for (PetscInt row = begin; row < std::min<PetscInt>(6, end); ++row) {
    PetscInt number = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(before.get(), row, &number, &columns, &values));
    const std::vector<PetscInt> where(columns, columns + number);
    std::vector<double> changed(values, values + number);
    check(MatRestoreRow(before.get(), row, &number, &columns, &values));
    for (std::size_t k = 0; k < where.size(); ++k) changed[k] *= 1.0 + part * std::sin(2.0 + row + 3.0 * where[k]);
    check(MatSetValues(K, 1, &row, static_cast<PetscInt>(where.size()), where.data(), changed.data(), INSERT_VALUES));
  }
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
}

PetscInt solve(KSP ksp, Vec b, Vec x) {
  PetscInt iterations = 0;
  check(KSPSolve(ksp, b, x));
  check(KSPGetIterationNumber(ksp, &iterations));
  return iterations;
}

TEST(LinearSolver, TheSymmetricPartPreconditionsANearlySymmetricMatrix) {
  const Cube cube(1e6);
  make_nearly_symmetric(cube.K(), 0.1);
  const auto ksp = solver_of(cube, Symmetry::nearly_symmetric);
  ASSERT_TRUE(set_up(ksp.get(), cube.K()));
  EXPECT_TRUE(is_of_symmetric_part(preconditioner_of(ksp.get())));
  EXPECT_EQ(num_negative(ksp.get()), -1);
  const auto b = cube.right_hand_side(), x = cube.vector();
  EXPECT_LE(solve(ksp.get(), b.get(), x.get()), 5);
  EXPECT_LE(cube.residual(x.get(), b.get()), 1e-5);
}

TEST(LinearSolver, TheWholeOfAMatrixIsFactorizedWhereItsSymmetricPartIsFar) {
  const Cube cube(1e6);
  make_nearly_symmetric(cube.K(), 20.0);
  const auto ksp = solver_of(cube, Symmetry::nearly_symmetric);
  ASSERT_TRUE(set_up(ksp.get(), cube.K()));
  const auto b = cube.right_hand_side(), x = cube.vector();
  const PetscInt iterations = solve(ksp.get(), b.get(), x.get());
  ASSERT_TRUE(refine_factorization(preconditioner_of(ksp.get())));
  EXPECT_FALSE(is_of_symmetric_part(preconditioner_of(ksp.get())));
  EXPECT_TRUE(is_in_single_precision(ksp.get()));
  ASSERT_TRUE(set_up(ksp.get(), cube.K()));
  const PetscInt refined = solve(ksp.get(), b.get(), x.get());
  EXPECT_LE(refined, 3);
  EXPECT_GT(iterations, refined);
  EXPECT_LE(cube.residual(x.get(), b.get()), 1e-5);
}

// The six motions that cost nothing have 1e-11 of the stiffness of the others: single precision cannot tell them from
// singular ones, double precision can.
TEST(LinearSolver, DoublePrecisionTakesOverWhereSingleDoesNotDo) {
  const Cube cube(1e-5);
  const auto ksp = solver_of(cube, Symmetry::symmetric);
  ASSERT_TRUE(set_up(ksp.get(), cube.K()));
  EXPECT_FALSE(is_in_single_precision(ksp.get()));
  EXPECT_EQ(num_negative(ksp.get()), 0);
  const auto b = cube.right_hand_side(), x = cube.vector();
  check(KSPSolve(ksp.get(), b.get(), x.get()));
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(ksp.get(), &iterations));
  EXPECT_LE(iterations, 3);
  EXPECT_LE(cube.residual(x.get(), b.get()), 1e-5);
}

TEST(LinearSolver, MultigridBecomesAFactorizationWhereThatIsAskedFor) {
  const Cube cube(1e6);
  const auto ksp = solver_of(cube, Symmetry::symmetric, LinearKind::adaptive);
  PC pc = preconditioner_of(ksp.get());
  ASSERT_TRUE(set_up(ksp.get(), cube.K()));
  EXPECT_TRUE(may_become_factorization(pc));
  EXPECT_TRUE(uses_near_null_space(pc));
  EXPECT_EQ(num_negative(ksp.get()), -1);
  const auto b = cube.right_hand_side(), x = cube.vector();
  std::array<PetscInt, 2> iterations{};
  for (const std::size_t k : {0u, 1u}) {
    check(KSPSolve(ksp.get(), b.get(), x.get()));
    check(KSPGetIterationNumber(ksp.get(), &iterations[k]));
    EXPECT_LE(cube.residual(x.get(), b.get()), 1e-5);
    if (k == 1) break;
    ASSERT_TRUE(refine_factorization(pc));
    ASSERT_TRUE(set_up(ksp.get(), cube.K()));
    EXPECT_FALSE(may_become_factorization(pc));
    EXPECT_EQ(num_negative(ksp.get()), 0);
  }
  EXPECT_LE(iterations[1], 3);
  EXPECT_GT(iterations[0], iterations[1]);
  EXPECT_LE(iterations[0], 15);
}

// Without the rigid motions there are no levels, and the factorization is there from the start.
TEST(LinearSolver, WhereThereIsNoMultigridThereIsAFactorization) {
  const Cube cube(1e6);
  check(MatSetNearNullSpace(cube.K(), nullptr));
  const auto ksp = solver_of(cube, Symmetry::symmetric, LinearKind::adaptive);
  ASSERT_TRUE(set_up(ksp.get(), cube.K()));
  EXPECT_FALSE(may_become_factorization(preconditioner_of(ksp.get())));
  EXPECT_EQ(num_negative(ksp.get()), 0);
}

// The finer the mesh, the better linear functions take care of what the smoother does not: the iterations stay.
TEST(LinearSolver, PMultigridTakesAsManyIterationsOnFinerMeshes) {
  const Scratch scratch(comm);
  std::vector<PetscInt> iterations;
  for (const int n : {4, 8}) {
    const auto file = scratch.file("cube.msh", [&](const std::string& f) {
      test::write_body(f, {1, test::Shape::straight, n});
    });
    const Solid solid(comm, file, 2, 2);
    const auto elastic = solid.elastic(make_law("neo-hookean", 1e6, 0.3));
    std::vector<char> clamped(3 * static_cast<std::size_t>(solid.layout().num_local_nodes), 0);
    for (PetscInt a = 0; a < solid.layout().num_local_nodes; ++a) {
      if (solid.layout().position(a)[0] < 1e-9) std::fill_n(clamped.begin() + 3 * a, 3, 1);
    }
    IncrementalPotential potential(solid.layout(), solid.pattern(), {elastic.get()}, clamped);
    const test::TestStage stage(solid, 0.0, 1.0);
    potential.begin_stage(stage.point);
    const Handle<Mat> K = potential.make_hessian();
    potential.hessian(stage.q0.get(), K.get(), Projection::none);
    const auto coarsening = potential.make_coarsening();
    ASSERT_TRUE(coarsening.has_value());
    Handle<KSP> ksp;
    check(KSPCreate(comm, ksp.out()));
    configure_linear_solver(ksp.get(), K.get(), LinearKind::p_multigrid, Symmetry::symmetric, &*coarsening);
    // A second set-up, of a matrix twice as stiff, must not keep the coarse level of the first.
    for (const double factor : {1.0, 2.0}) {
      check(MatScale(K.get(), factor));
      ASSERT_TRUE(set_up(ksp.get(), K.get()));
      check(KSPSetTolerances(ksp.get(), 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
      const Handle<Vec> b = potential.make_vector(), x = potential.make_vector(), Kx = potential.make_vector();
      check(MatMult(K.get(), solid.vector(test::rough_field(1.0, 1)).get(), b.get()));
      check(KSPSolve(ksp.get(), b.get(), x.get()));
      check(MatMult(K.get(), x.get(), Kx.get()));
      EXPECT_LE(test::distance(Kx.get(), b.get()), 2e-8 * test::norm(b.get()));
      iterations.push_back(0);
      check(KSPGetIterationNumber(ksp.get(), &iterations.back()));
    }
    EXPECT_EQ(iterations.back(), iterations[iterations.size() - 2]);
  }
  EXPECT_LE(iterations.back(), 16);
  EXPECT_LE(iterations.back(), iterations.front() + 1);
}

}  // namespace
}  // namespace pliant::test_linear
