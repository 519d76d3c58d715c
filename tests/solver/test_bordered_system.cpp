// Linear systems that are symmetric but for a few rows and columns.
#include "solver/bordered_system.hpp"
#include "solver/linear.hpp"
#include "solver/problem.hpp"
#include "solver/rank_one_system.hpp"

namespace pliant::test_bordered_system {
namespace {

using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;

/// A vector of ones, but for some entries.
Handle<Vec> ones_but(Mat K, const std::vector<PetscInt>& rows, double value) {
  Handle<Vec> x;
  check(MatCreateVecs(K, x.out(), nullptr));
  check(VecSet(x.get(), 1.0));
  PetscInt first = 0, last = 0;
  check(MatGetOwnershipRange(K, &first, &last));
  for (const PetscInt row : rows) {
    if (row >= first && row < last) check(VecSetValue(x.get(), row, value, INSERT_VALUES));
  }
  check(VecAssemblyBegin(x.get()));
  check(VecAssemblyEnd(x.get()));
  return x;
}

class BorderedSystems : public testing::Test {
 protected:
  const Scratch scratch{comm};
  const Solid solid{comm,
                    scratch.file("body.msh",
                                 [](const std::string& f) {
                                   test::write_body(f, {1, Shape::jittered, 4});
                                 }),
                    1, 1};
  std::unique_ptr<EnergyTerm> elastic_ = solid.elastic(make_law("neo-hookean", 1e6, 0.3));
  std::unique_ptr<EnergyTerm> inertia_ = solid.inertia(1000.0, Mass::consistent);
  IncrementalPotential potential_{
      solid.layout(), solid.pattern(), {elastic_.get(), inertia_.get()}, solid.nothing_prescribed()};
  TestStage stage_{solid, 0.0, 0.1};
  Handle<Mat> matrix_;
  Handle<KSP> ksp_;
  std::vector<PetscInt> border_;  // the first two nodes and the last one: of the first and the last rank

  void SetUp() override {
    potential_.begin_stage(stage_.point);
    matrix_ = potential_.make_hessian();
    for (const MatOption is : {MAT_SYMMETRIC, MAT_SYMMETRY_ETERNAL})
      check(MatSetOption(matrix_.get(), is, PETSC_FALSE));
    potential_.hessian(stage_.q0.get(), matrix_.get(), Projection::none);
    check(KSPCreate(comm, ksp_.out()));
    const auto last_first = 3 * (solid.layout().num_global_nodes - 1);
    border_ = {0, 1, 2, 3, 4, 5, last_first, last_first + 1, last_first + 2};
  }

  /// Iterations that the present system takes, whose solution is compared with the right-hand side.
  PetscInt iterations() {
    const auto b = solid.vector(test::rough_field(1.0, 1));
    const Handle<Vec> x = potential_.make_vector(), Kx = potential_.make_vector();
    check(KSPSolve(ksp_.get(), b.get(), x.get()));
    check(MatMult(matrix_.get(), x.get(), Kx.get()));
    EXPECT_LE(test::distance(Kx.get(), b.get()), 2e-9 * test::norm(b.get()));
    PetscInt number = 0;
    check(KSPGetIterationNumber(ksp_.get(), &number));
    return number;
  }
};

// Neither the asymmetry nor later changes of the border cost iterations: with the factor of the rest, two or three.
TEST_F(BorderedSystems, AreSolvedAsFastAsTheRest) {
  configure_linear_solver(ksp_.get(), matrix_.get(), LinearKind::cholesky, Symmetry::nearly_symmetric);
  check(KSPSetTolerances(ksp_.get(), 1e-9, PETSC_DEFAULT, PETSC_DEFAULT, 100));
  PC inner = nullptr;
  check(KSPGetPC(ksp_.get(), &inner));
  check(MatDiagonalScale(matrix_.get(), ones_but(matrix_.get(), border_, 3.0).get(), nullptr));
  BorderedSystem system(ksp_.get(), matrix_.get(), border_, solid.nothing_prescribed(), nullptr);
  ASSERT_EQ(set_up_preconditioner(inner, system.inner_matrix(matrix_.get())), SetUp::sound);
  system.set_up(matrix_.get());
  system.follow(matrix_.get(), {});
  EXPECT_LE(iterations(), 3);
  check(MatDiagonalScale(matrix_.get(), ones_but(matrix_.get(), border_, -0.2).get(),
                         ones_but(matrix_.get(), border_, 7.0).get()));
  system.follow(matrix_.get(), {});
  EXPECT_LE(iterations(), 3);
}

// A rank-one term of the border alone is a part of its block.
TEST_F(BorderedSystems, TakeRankOneTermsOfTheBorder) {
  configure_linear_solver(ksp_.get(), matrix_.get(), LinearKind::cholesky, Symmetry::nearly_symmetric);
  check(KSPSetTolerances(ksp_.get(), 1e-9, PETSC_DEFAULT, PETSC_DEFAULT, 100));
  PC inner = nullptr;
  check(KSPGetPC(ksp_.get(), &inner));
  std::vector<RankOne> parts(1);
  parts[0].c = 1e12;
  parts[0].g = ones_but(matrix_.get(), border_, 2.0);
  check(VecShift(parts[0].g.get(), -1.0));
  RankOneSystem rank_one(ksp_.get(), matrix_.get(), parts);
  BorderedSystem system(ksp_.get(), matrix_.get(), border_, solid.nothing_prescribed(), nullptr);
  ASSERT_EQ(set_up_preconditioner(inner, system.inner_matrix(matrix_.get())), SetUp::sound);
  ASSERT_TRUE(rank_one.set_up([&](Vec x) { system.clear_border(x); }));
  check(KSPSetOperators(ksp_.get(), rank_one.matrix(), matrix_.get()));
  system.set_up(matrix_.get());
  system.follow(matrix_.get(), parts);
  const auto b = solid.vector(test::rough_field(1.0, 1));
  const Handle<Vec> x = potential_.make_vector();
  check(KSPSolve(ksp_.get(), b.get(), x.get()));
  PetscInt number = 0;
  check(KSPGetIterationNumber(ksp_.get(), &number));
  EXPECT_LE(number, 3);
  const Handle<Vec> Kx = potential_.make_vector();
  check(MatMult(rank_one.matrix(), x.get(), Kx.get()));
  EXPECT_LE(test::distance(Kx.get(), b.get()), 1e-6 * test::norm(b.get()));  // c = 1e12 costs digits
}

}  // namespace
}  // namespace pliant::test_bordered_system
