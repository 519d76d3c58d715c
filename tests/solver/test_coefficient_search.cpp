// Stages whose coefficients follow the solution.
#include "solver/newton.hpp"
#include "solver/small_equation.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace pliant::test {
namespace {

constexpr PetscInt num_springs = 12;
constexpr double pi = 3.14159265358979324;

/// dr/dx for frozen coefficients.
std::vector<double> stiffness_of_springs(std::span<const double> x) {
  std::vector<double> K(x.size() * x.size(), 0.0);
  for (std::size_t i = 0; i < x.size(); ++i) K[i * (x.size() + 1)] = 1.0 + 3.0 * x[i] * x[i];
  return K;
}

/// Springs that harden, r_i = x_i + x_i^3 - 1 + c_i a_(i+1), where a is x, frozen. With |c| > 1 the solutions for
/// frozen coefficients move away from the common one.
class Frozen : public SmallEquation {
 public:
  Frozen(MPI_Comm comm, double coupling)
      : SmallEquation(comm, SmallFunction{num_springs, nullptr, stiffness_of_springs}),
        coupling_(coupling),
        a_(make_vector()),
        f_(make_vector()) {}

  void freeze(Vec q) override { check(VecCopy(q, a_.get())); }
  bool refreeze(Vec q) override {
    freeze(q);
    return true;
  }
  void drag(Vec /*q*/, Vec at, Vec f) override {
    freeze(at);
    const ConstArrayView a(at);
    const ArrayView to(f);
    const std::size_t n = to.span().size();
    for (std::size_t i = 0; i < n; ++i) to.span()[i] = c(i) * a.span()[(i + 1) % n];
  }
  void gradient(Vec q, Vec r) override {
    drag(q, a_.get(), f_.get());
    const ConstArrayView x(q), f(f_.get());
    const ArrayView to(r);
    for (std::size_t i = 0; i < x.span().size(); ++i) {
      const double xi = x.span()[i];
      to.span()[i] = xi + xi * xi * xi - 1.0 + f.span()[i];
    }
  }
  double c(std::size_t i) const { return coupling_ * std::cos(2.0 * pi * static_cast<double>(i) / num_springs); }

 private:
  double coupling_;
  Handle<Vec> a_, f_;
};

StageReport solve(Frozen& equation, Vec q) {
  NewtonSolver solver(equation, {.relative = 1e-10}, LinearKind::cholesky);
  const Handle<Vec> q0 = equation.filled(0.0), v0 = equation.filled(0.0);
  return solver.solve({.time = 1.0, .dt = 1.0, .q0 = q0.get(), .v0 = v0.get()}, q);
}

class CoefficientSearches : public testing::TestWithParam<double> {};

TEST_P(CoefficientSearches, FindTheCommonSolutionInAFewSteps) {
  Frozen equation(PETSC_COMM_WORLD, GetParam());
  const Handle<Vec> q = equation.filled(0.0), r = equation.make_vector();
  const StageReport report = solve(equation, q.get());
  EXPECT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  equation.freeze(q.get());
  equation.gradient(q.get(), r.get());
  PetscReal left = 0.0;
  check(VecNorm(r.get(), NORM_2, &left));
  EXPECT_LT(left, 2e-10);
  EXPECT_LE(report.newton_iterations, 20);
}

/// The same springs with a drag of +-size that jumps where they would be without it: no solution has its own.
class Jumping final : public Frozen {
 public:
  Jumping(MPI_Comm comm, double size) : Frozen(comm, 0.0), size_(size) {}
  void drag(Vec /*q*/, Vec at, Vec f) override {
    freeze(at);
    const ConstArrayView a(at);
    const ArrayView to(f);
    for (std::size_t i = 0; i < to.span().size(); ++i) to.span()[i] = a.span()[i] > free_length ? size_ : -size_;
  }

 private:
  static constexpr double free_length = 0.68232780382801933;  // x + x^3 = 1
  double size_;
};

// As where a body leaves the ground: forces that small decide nothing.
TEST(CoefficientSearchesOfJumps, FailOnlyWhereTheDragMatters) {
  for (const double size : {1e-7, 1e-2}) {
    Jumping equation(PETSC_COMM_WORLD, size);
    const Handle<Vec> q = equation.filled(0.0);
    const StageReport report = solve(equation, q.get());
    EXPECT_EQ(report.outcome == StageOutcome::converged, size == 1e-7) << report.reason;
  }
}

INSTANTIATE_TEST_SUITE_P(Couplings, CoefficientSearches, testing::Values(0.0, 0.3, -0.9, 2.0, 3.0));

}  // namespace
}  // namespace pliant::test
