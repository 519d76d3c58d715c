#include "solver/eigenpairs.hpp"

#include "base/error.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/slepc.hpp"
#include "solver/factorization.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The first shift below the eigenvalues, as a fraction of the mean of K_ii / M_ii, roughly the largest eigenvalue: far
/// above rounding errors, below the first eigenvalue of all but very slender bodies. Each further one is a multiple.
constexpr double first_shift = 1e-9, shift_factor = 10.0, largest_shift = 1e2;
/// Rounding errors in eigenvalues, measured on bodies, shells, rods and mechanisms that nothing holds, and a tenth or
/// less of the first eigenvalue of the slenderest ones: those of the summands of x . K x, which are independent, and of
/// the factors, as a part of the sum of K_ii over that of M_ii; and a period of two days, which no body has [1/s^2].
constexpr double part_of_summands = 2e-14, part_of_quotient = 3e-16, slower_than_all = 1e-9;
/// The least value of that mean: of bodies that nothing but rounding errors holds [1/s^2].
constexpr double least_mean = 1e-3;
constexpr double tolerance = 1e-10;
constexpr PetscInt most_restarts = 1000;

MPI_Comm comm_of(Mat K) {
  return PetscObjectComm(reinterpret_cast<PetscObject>(K));
}

/// What the diagonals of K and M say.
struct Scale {
  double mean = 0.0;         ///< of |K_ii| / M_ii where there is mass [1/s^2]
  double quotient = 0.0;     ///< the sum of |K_ii| over that of M_ii, likewise [1/s^2]
  PetscInt64 with_mass = 0;  ///< number of such unknowns
};

Scale scale_of(const EigenProblem& problem) {
  Handle<Vec> k, m;
  check(MatCreateVecs(problem.K, k.out(), m.out()));
  check(MatGetDiagonal(problem.K, k.get()));
  check(MatGetDiagonal(problem.M, m.get()));
  const ConstArrayView stiffness(k.get()), mass(m.get());
  double total = 0.0, total_stiffness = 0.0, total_mass = 0.0;
  PetscInt64 count = 0;
  for (std::size_t i = 0; i < mass.span().size(); ++i) {
    if (!(mass.span()[i] > 0.0)) continue;
    total += std::abs(stiffness.span()[i]) / mass.span()[i];
    total_stiffness += std::abs(stiffness.span()[i]);
    total_mass += mass.span()[i];
    ++count;
  }
  Scale scale;
  scale.with_mass = sum(comm_of(problem.K), count);
  scale.mean = sum(comm_of(problem.K), total) / std::max(1.0, static_cast<double>(scale.with_mass));
  scale.mean = std::max(scale.mean, least_mean);
  total_mass = sum(comm_of(problem.K), total_mass);
  scale.quotient = sum(comm_of(problem.K), total_stiffness) / (total_mass > 0.0 ? total_mass : 1.0);
  return scale;
}

/// The size of rounding errors in the eigenvalue of x, for x . M x = 1, from the diagonal of K and the scale.
double rounding_of(Vec diagonal, Vec x, const Scale& scale) {
  const ConstArrayView k(diagonal), shape(x);
  double squares = 0.0;
  for (std::size_t i = 0; i < k.span().size(); ++i) squares += std::pow(k.span()[i] * std::pow(shape.span()[i], 2), 2);
  const double summands = std::sqrt(sum(PetscObjectComm(reinterpret_cast<PetscObject>(x)), squares));
  return std::max({part_of_summands * summands, part_of_quotient * scale.quotient, slower_than_all});
}

/// The factors of K - sigma M.
class Shifted {
 public:
  explicit Shifted(const EigenProblem& problem) : problem_(problem) {}

  SetUp factorize(double sigma) {
    check(MatDuplicate(problem_.K, MAT_COPY_VALUES, matrix_.out()));
    check(MatAXPY(matrix_.get(), -sigma, problem_.M, DIFFERENT_NONZERO_PATTERN));
    check(MatSetOption(matrix_.get(), MAT_SYMMETRIC, PETSC_TRUE));
    check(PCCreate(comm_of(problem_.K), factors_.out()));
    use_double_precision(factors_.get(), Symmetry::symmetric);
    check(PCSetOperators(factors_.get(), matrix_.get(), matrix_.get()));
    control_mumps(factors_.get(), matrix_.get(), first_workspace);
    return set_up_with_workspace(factors_.get(), matrix_.get());
  }
  /// How many eigenvalues lie below the shift.
  PetscInt count_below() const { return negative_pivots_of_petsc(factors_.get()).value() - problem_.num_negative; }
  PC factors() const { return factors_.get(); }

 private:
  const EigenProblem& problem_;
  Handle<Mat> matrix_;
  Handle<PC> factors_;
};

void require_memory(SetUp outcome) {
  if (outcome != SetUp::out_of_memory) return;
  throw SolveError("there is too little memory to factorize the stiffness; use more ranks or a coarser mesh");
}

/// Factorizes at a shift below all eigenvalues, and returns it.
double factorize_below(Shifted& shifted, double mean) {
  bool is_sound = false;
  for (double part = first_shift; part < largest_shift; part *= shift_factor) {
    const double sigma = -part * mean;
    const SetUp outcome = shifted.factorize(sigma);
    require_memory(outcome);
    is_sound = outcome == SetUp::sound;
    if (is_sound && shifted.count_below() <= 0) return sigma;
  }
  throw SolveError(is_sound ? "the stiffness has negative eigenvalues of any size: the state is unstable in motions "
                              "without mass; give every body a density"
                            : "the stiffness is singular in motions without mass; give every body a density");
}

PetscErrorCode apply_factors(PC shell, Vec x, Vec y) {
  PC factors = nullptr;
  PetscCall(PCShellGetContext(shell, &factors));
  PetscCall(PCApply(factors, x, y));
  return 0;
}

/// Lets the eigensolver use the factors that there are.
void use_factors(EPS eps, PC factors) {
  ST transformation = nullptr;
  check(EPSGetST(eps, &transformation));
  check(STSetType(transformation, STSINVERT));
  check(STSetMatMode(transformation, ST_MATMODE_SHELL));
  KSP ksp = nullptr;
  check(STGetKSP(transformation, &ksp));
  check(KSPSetType(ksp, KSPPREONLY));
  PC shell = nullptr;
  check(KSPGetPC(ksp, &shell));
  check(PCSetType(shell, PCSHELL));
  check(PCShellSetContext(shell, factors));
  check(PCShellSetApply(shell, apply_factors));
}

Eigenpairs solve(const EigenProblem& problem, PetscInt number, double sigma, const Shifted& shifted,
                 const Scale& scale) {
  number = std::min(number, static_cast<PetscInt>(scale.with_mass));
  PetscInt num_unknowns = 0;
  check(MatGetSize(problem.K, &num_unknowns, nullptr));
  Handle<EPS> eps;
  check(EPSCreate(comm_of(problem.K), eps.out()));
  check(EPSSetOperators(eps.get(), problem.K, problem.M));
  check(EPSSetProblemType(eps.get(), EPS_GHEP));
  check(EPSSetType(eps.get(), EPSKRYLOVSCHUR));
  check(EPSSetTarget(eps.get(), sigma));
  check(EPSSetWhichEigenpairs(eps.get(), EPS_TARGET_MAGNITUDE));
  check(EPSSetTolerances(eps.get(), tolerance, most_restarts));
  check(EPSSetDimensions(eps.get(), number, std::min(num_unknowns, std::max(2 * number, number + 20)), PETSC_DEFAULT));
  use_factors(eps.get(), shifted.factors());
  check(EPSSetFromOptions(eps.get()));
  check(EPSSolve(eps.get()));
  PetscInt converged = 0;
  check(EPSGetConverged(eps.get(), &converged));
  if (converged < number) {
    throw SolveError(
        fmt::format("only {} of {} modes converged; ask for fewer (--number), or let the eigensolver "
                    "iterate longer: -- -eps_max_it 10000",
                    converged, number));
  }
  Eigenpairs found;
  std::vector<double> values;
  std::vector<Handle<Vec>> vectors;
  for (PetscInt i = 0; i < number; ++i) {
    Handle<Vec> x;
    check(MatCreateVecs(problem.K, x.out(), nullptr));
    double value = 0.0;
    check(EPSGetEigenpair(eps.get(), i, &value, nullptr, x.get(), nullptr));
    values.push_back(value);
    vectors.push_back(std::move(x));
  }
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
  Handle<Vec> diagonal;
  check(MatCreateVecs(problem.K, diagonal.out(), nullptr));
  check(MatGetDiagonal(problem.K, diagonal.get()));
  for (const std::size_t i : order) {
    found.values.push_back(values[i]);
    found.roundings.push_back(rounding_of(diagonal.get(), vectors[i].get(), scale));
    found.vectors.push_back(std::move(vectors[i]));
  }
  return found;
}

Scale require_mass(const EigenProblem& problem) {
  const Scale scale = scale_of(problem);
  if (scale.with_mass > 0) return scale;
  throw SolveError("nothing that has a mass can move: it is all held");
}

}  // namespace

std::string slepc_version() {
  return fmt::format("{}.{}.{}", SLEPC_VERSION_MAJOR, SLEPC_VERSION_MINOR, SLEPC_VERSION_SUBMINOR);
}

Eigenpairs smallest_eigenpairs(const EigenProblem& problem, PetscInt number) {
  const SlepcSession session;
  const Scale scale = require_mass(problem);
  Shifted shifted(problem);
  const double sigma = factorize_below(shifted, scale.mean);
  return solve(problem, number, sigma, shifted, scale);
}

Eigenpairs nearest_eigenpairs(const EigenProblem& problem, PetscInt number, double target) {
  const SlepcSession session;
  const Scale scale = require_mass(problem);
  Shifted shifted(problem);
  const SetUp outcome = shifted.factorize(target);
  require_memory(outcome);
  if (outcome != SetUp::sound) {
    throw SolveError(
        "a mode has exactly this frequency, where the stiffness cannot be factorized; give a slightly different one");
  }
  return solve(problem, number, target, shifted, scale);
}

}  // namespace pliant
