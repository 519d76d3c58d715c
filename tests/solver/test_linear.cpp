// Linear solvers: what they recover from.
#include "energy/solid.hpp"
#include "solver/linear.hpp"

namespace pliant {
namespace {

using testing::Scratch;
using testing::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;

/// Leaves the factorization to come a twentieth of the workspace that MUMPS estimates.
void shrink_workspace(KSP ksp) {
  PC pc = nullptr;
  Mat factor = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(PCFactorGetMatrix(pc, &factor));
  check(MatMumpsSetIcntl(factor, 14, -95));
}

// It fails with too little, as a plain set-up shows, and is given more.
TEST(LinearSolver, AFactorizationOutOfWorkspaceIsRepeatedWithMore) {
  const Scratch scratch(comm);
  const auto file = scratch.file("cube.msh", [](const std::string& f) {
    testing::write_body(f, {1, testing::Shape::straight, 8});
  });
  const Solid solid(comm, file, 1, 2);
  const auto elastic = solid.elastic(make_law("linear", 1e6, 0.3));
  const auto inertia = solid.inertia(1e6, Mass::consistent);
  IncrementalPotential potential(solid.layout(), solid.pattern(), {elastic.get(), inertia.get()},
                                 solid.nothing_prescribed());
  const testing::TestStage stage(solid, 0.0, 1.0);
  potential.begin_stage(stage.point);
  const Handle<Mat> K = potential.make_hessian();
  potential.hessian(stage.q0.get(), K.get(), Projection::none);
  for (const auto symmetry : {Symmetry::symmetric, Symmetry::unsymmetric}) {
    Handle<KSP> plain, ksp;
    for (Handle<KSP>* solver : {&plain, &ksp}) {
      check(KSPCreate(comm, solver->out()));
      configure_linear_solver(solver->get(), K.get(), LinearKind::cholesky, symmetry);
      shrink_workspace(solver->get());
    }
    check(KSPSetUp(plain.get()));
    PC pc = nullptr;
    PCFailedReason failure = PC_NOERROR;
    check(KSPGetPC(plain.get(), &pc));
    check(PCGetFailedReason(pc, &failure));
    ASSERT_NE(failure, PC_NOERROR);

    check(KSPGetPC(ksp.get(), &pc));
    ASSERT_TRUE(set_up_preconditioner(pc, K.get()));
    const auto b = solid.vector(testing::rough_field(1.0, 1));
    const Handle<Vec> x = potential.make_vector(), Kx = potential.make_vector();
    check(KSPSolve(ksp.get(), b.get(), x.get()));
    PetscInt iterations = 0;
    check(KSPGetIterationNumber(ksp.get(), &iterations));
    EXPECT_LE(iterations, 2);
    check(MatMult(K.get(), x.get(), Kx.get()));
    EXPECT_LE(testing::distance(Kx.get(), b.get()), 1e-5 * testing::norm(b.get()));
  }
}

}  // namespace
}  // namespace pliant
