#include "study/least_squares.hpp"

#include "base/limits.hpp"
#include "petsc/callback.hpp"
#include "petsc/tao.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>

#include <petscmat.h>

namespace pliant {
namespace {

double length(std::span<const double> x) {
  return std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.0));
}

/// Whether all are numbers whose squares are.
bool is_finite(std::span<const double> x) {
  constexpr double largest = 1e100;
  return std::ranges::all_of(x, [](double value) { return std::abs(value) < largest; });
}

/// Residuals and Jacobian at a point.
struct Linearised {
  std::vector<double> r, J;

  Linearised(const LeastSquaresProblem& problem, std::span<const double> x)
      : r(problem.num_residuals), J(problem.num_residuals * problem.num_parameters()) {
    problem.evaluate(x, r, J);
  }
  std::size_t num_columns() const { return r.empty() ? 0 : J.size() / r.size(); }
  std::vector<double> column(std::size_t j) const {
    std::vector<double> result;
    for (std::size_t i = 0; i < r.size(); ++i) result.push_back(J[i * num_columns() + j]);
    return result;
  }
};

/// Whether a bound keeps the parameter from moving along the descent of the sum.
bool is_held(const LeastSquaresProblem& problem, std::span<const double> x, std::size_t j, double gradient) {
  const double room = 1e-12 * std::max(1.0, std::abs(x[j]));
  return (x[j] - problem.lower[j] <= room && gradient >= 0.0) || (problem.upper[j] - x[j] <= room && gradient <= 0.0);
}

/// The largest cosine of the angle between the residual and a column that can move; 0 if the residual, or the change of
/// the parameters that it asks for, is as small as errors of the evaluation make it.
double orthogonality(const LeastSquaresProblem& problem, std::span<const double> x) {
  const Linearised at(problem, x);
  if (!is_finite(at.r) || !is_finite(at.J)) return nan;
  const double size = length(at.r), noise = 100.0 * problem.error_of_evaluation;
  double largest = 0.0;
  for (std::size_t j = 0; j < at.num_columns() && size > problem.error_of_evaluation; ++j) {
    const auto column = at.column(j);
    const double gradient = std::inner_product(column.begin(), column.end(), at.r.begin(), 0.0);
    const double squares = length(column) * length(column);
    const bool moves = std::abs(gradient) > noise * std::max(1.0, std::abs(x[j])) * squares;
    if (squares > 0.0 && moves && !is_held(problem, x, j, gradient)) {
      largest = std::max(largest, std::abs(gradient) / (length(column) * size));
    }
  }
  return largest;
}

/// The problem as PETSc sees it, in parameters whose columns at the start have the length one. It has one parameter
/// more, which is the residual that is added: BNTR (PETSc 3.18) fails where bounds hold all parameters.
class TaoProblem {
 public:
  TaoProblem(const LeastSquaresProblem& problem, std::span<const double> start) : problem_(problem) {
    const Linearised at(problem, start);
    double longest = 0.0;
    for (std::size_t j = 0; j < at.num_columns(); ++j) longest = std::max(longest, length(at.column(j)));
    constexpr double shortest = 1e-4;  // of a column that is counted as one, relative to the longest
    for (std::size_t j = 0; j < at.num_columns(); ++j) {
      const double size = std::max(length(at.column(j)), shortest * longest);
      scale_.push_back(std::isfinite(size) && size > 0.0 ? 1.0 / size : 1.0);
      const auto column = at.column(j);
      const double gradient = scale_.back() * std::inner_product(column.begin(), column.end(), at.r.begin(), 0.0);
      added_ = std::max(added_, std::abs(gradient));
    }
    // As large as what has to fall: tolerances are relative to that.
    added_ = added_ > 0.0 && added_ < 1.0 ? added_ : 1.0;
  }

  Minimum solve(std::span<const double> start) {
    const auto n = static_cast<PetscInt>(problem_.num_residuals) + 1;
    const auto p = static_cast<PetscInt>(problem_.num_parameters()) + 1;
    Handle<Vec> x = vector(p), r = vector(n), lower = vector(p), upper = vector(p);
    Handle<Mat> J;
    check(MatCreateSeqDense(PETSC_COMM_SELF, n, p, nullptr, J.out()));
    const auto is_added = [&](std::size_t j) { return j == scale_.size(); };
    fill(x.get(), [&](std::size_t j) { return is_added(j) ? added_ : start[j] / scale_[j]; });
    fill(lower.get(), [&](std::size_t j) {
      return is_added(j) ? PETSC_NINFINITY : std::max(problem_.lower[j] / scale_[j], PETSC_NINFINITY);
    });
    fill(upper.get(), [&](std::size_t j) {
      return is_added(j) ? PETSC_INFINITY : std::min(problem_.upper[j] / scale_[j], PETSC_INFINITY);
    });
    const Handle<Tao> tao = gauss_newton(problem_.error_of_evaluation);
    check(TaoSetSolution(tao.get(), x.get()));
    check(TaoSetVariableBounds(tao.get(), lower.get(), upper.get()));
    check(TaoSetResidualRoutine(tao.get(), r.get(), residual_callback, this));
    check(TaoSetJacobianResidualRoutine(tao.get(), J.get(), J.get(), jacobian_callback, this));
    Tao inner = nullptr;
    check(TaoBRGNGetSubsolver(tao.get(), &inner));
    check(TaoSetConvergenceTest(inner, convergence_callback, this));
    guard_.rethrow(TaoSolve(tao.get()));
    Minimum minimum;
    minimum.x = unscaled(x.get());
    PetscInt iterations = 0;
    check(TaoGetIterationNumber(inner, &iterations));
    minimum.num_iterations = static_cast<int>(iterations);
    TaoConvergedReason reason{};
    check(TaoGetConvergedReason(inner, &reason));
    minimum.reason = TaoConvergedReasons[reason];
    return minimum;
  }

 private:
  static Handle<Vec> vector(PetscInt size) {
    Handle<Vec> x;
    check(VecCreateSeq(PETSC_COMM_SELF, size, x.out()));
    return x;
  }
  template <class F>
  static void fill(Vec x, const F& value) {
    PetscInt size = 0;
    PetscScalar* entries = nullptr;
    check(VecGetLocalSize(x, &size));
    check(VecGetArrayWrite(x, &entries));
    for (std::size_t j = 0; j < static_cast<std::size_t>(size); ++j) entries[j] = value(j);
    check(VecRestoreArrayWrite(x, &entries));
  }
  std::vector<double> unscaled(Vec x) const {
    std::vector<double> result(scale_.size());
    const PetscScalar* entries = nullptr;
    check(VecGetArrayRead(x, &entries));
    for (std::size_t j = 0; j < result.size(); ++j) {
      result[j] = std::clamp(entries[j] * scale_[j], problem_.lower[j], problem_.upper[j]);
    }
    check(VecRestoreArrayRead(x, &entries));
    return result;
  }

  double added(Vec x) const {
    const PetscScalar* entries = nullptr;
    check(VecGetArrayRead(x, &entries));
    const double value = entries[scale_.size()];
    check(VecRestoreArrayRead(x, &entries));
    return value;
  }

  /// Residuals and Jacobian come together, and TAO asks for one after the other.
  const Linearised& linearised(Vec x) {
    std::vector<double> at = unscaled(x);
    if (!last_ || at != last_x_) {
      last_.emplace(problem_, at);
      constexpr double progress = 1e-6;  // relative
      const double size = length(last_->r);
      num_without_progress_ = size < (1.0 - progress) * shortest_ ? 0 : num_without_progress_ + 1;
      shortest_ = std::min(shortest_, size);
    }
    last_x_ = std::move(at);
    return *last_;
  }

  static Handle<Tao> gauss_newton(double error_of_evaluation) {
    Handle<Tao> tao;
    check(TaoCreate(PETSC_COMM_SELF, tao.out()));
    check(TaoSetType(tao.get(), TAOBRGN));
    check(TaoBRGNSetRegularizerWeight(tao.get(), 0.0));  // the trust region is enough
    Tao inner = nullptr;
    check(TaoBRGNGetSubsolver(tao.get(), &inner));
    check(TaoSetType(inner, TAOBNTR));
    const double gradient = 1e-3 * error_of_evaluation, relative = 0.1 * error_of_evaluation, reduction = relative;
    constexpr PetscInt most_iterations = 500, most_evaluations = 5000;
    for (Tao each : {tao.get(), inner}) {
      check(TaoSetTolerances(each, gradient, relative, reduction));
      check(TaoSetMaximumIterations(each, most_iterations));
      check(TaoSetMaximumFunctionEvaluations(each, most_evaluations));
    }
    KSP linear = nullptr;
    check(TaoGetKSP(inner, &linear));
    constexpr double exact = 1e-14;
    check(KSPSetTolerances(linear, exact, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
    return tao;
  }

  /// Ends what goes to and fro among the errors of the evaluation, too.
  static PetscErrorCode convergence_callback(Tao tao, void* context) {
    auto& self = *static_cast<TaoProblem*>(context);
    return self.guard_.run([&] {
      constexpr int most_without_progress = 15;
      check(TaoDefaultConvergenceTest(tao, nullptr));
      TaoConvergedReason reason{};
      check(TaoGetConvergedReason(tao, &reason));
      if (reason == TAO_CONTINUE_ITERATING && self.num_without_progress_ > most_without_progress) {
        check(TaoSetConvergedReason(tao, TAO_CONVERGED_STEPTOL));
      }
    });
  }
  static PetscErrorCode residual_callback(Tao, Vec x, Vec r, void* context) {
    auto& self = *static_cast<TaoProblem*>(context);
    return self.guard_.run([&] {
      const Linearised& at = self.linearised(x);
      const bool exists = is_finite(at.r) && is_finite(at.J);
      constexpr double far = 1e20;  // from anything that a trust region accepts; BNTR gives up at NaN
      const double added = self.added(x);
      fill(r, [&](std::size_t i) { return i == at.r.size() ? added : exists ? at.r[i] : far; });
    });
  }
  static PetscErrorCode jacobian_callback(Tao, Vec x, Mat J, Mat, void* context) {
    auto& self = *static_cast<TaoProblem*>(context);
    return self.guard_.run([&] {
      const Linearised& at = self.linearised(x);
      PetscScalar* entries = nullptr;  // by columns
      check(MatDenseGetArrayWrite(J, &entries));
      const std::size_t n = at.r.size(), p = at.num_columns();
      const bool exists = is_finite(at.r) && is_finite(at.J);
      std::fill_n(entries, (n + 1) * (p + 1), 0.0);
      for (std::size_t j = 0; j < p && exists; ++j) {
        for (std::size_t i = 0; i < n; ++i) entries[j * (n + 1) + i] = at.J[i * p + j] * self.scale_[j];
      }
      entries[p * (n + 1) + n] = 1.0;
      check(MatDenseRestoreArrayWrite(J, &entries));
      check(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
      check(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
    });
  }

  const LeastSquaresProblem& problem_;
  std::vector<double> scale_;
  std::vector<double> last_x_;
  std::optional<Linearised> last_;
  double added_ = 0.0;          // where the added parameter starts
  double shortest_ = infinity;  // residual so far
  int num_without_progress_ = 0;
  CallbackGuard guard_;
};

/// Singular values, descending, and the right singular vectors of the matrix with these columns.
struct Svd {
  std::vector<double> values;
  std::vector<std::vector<double>> right;
};

/// By one-sided Jacobi rotations, which make the columns orthogonal and find small singular values to their last
/// digits. Source: Hestenes, J. Soc. Ind. Appl. Math. 6 (1958) 51-90; Golub & Van Loan, Matrix Computations (4th ed.
/// 2013), section 8.6.3. (PETSc offers no singular vectors, and links LAPACK for itself alone.)
Svd svd(std::vector<std::vector<double>> A) {
  const std::size_t p = A.size();
  std::vector<std::vector<double>> V(p, std::vector<double>(p, 0.0));
  for (std::size_t j = 0; j < p; ++j) V[j][j] = 1.0;
  const auto product = [](const auto& x, const auto& y) {
    return std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
  };
  constexpr int most_sweeps = 60;
  bool has_turned = true;
  for (int sweep = 0; sweep < most_sweeps && has_turned; ++sweep) {
    has_turned = false;
    for (std::size_t i = 0; i < p; ++i) {
      for (std::size_t j = i + 1; j < p; ++j) {
        const double ii = product(A[i], A[i]), jj = product(A[j], A[j]), ij = product(A[i], A[j]);
        if (std::abs(ij) <= 1e-15 * std::sqrt(ii * jj)) continue;
        has_turned = true;
        const double zeta = (jj - ii) / (2.0 * ij);
        const double t = std::copysign(1.0, zeta) / (std::abs(zeta) + std::hypot(1.0, zeta));
        const double c = 1.0 / std::hypot(1.0, t), s = c * t;
        for (auto* columns : {&A, &V}) {
          auto &x = (*columns)[i], &y = (*columns)[j];
          for (std::size_t k = 0; k < x.size(); ++k) {
            const double before = x[k];
            x[k] = c * before - s * y[k];
            y[k] = s * before + c * y[k];
          }
        }
      }
    }
  }
  std::vector<std::size_t> order(p);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, std::greater{}, [&](std::size_t j) { return length(A[j]); });
  Svd result;
  for (const std::size_t j : order) {
    result.values.push_back(length(A[j]));
    result.right.push_back(V[j]);
  }
  return result;
}

}  // namespace

Minimum minimise(const LeastSquaresProblem& problem, std::span<const double> start) {
  Minimum minimum;
  const Linearised at(problem, start);
  minimum.x.assign(start.begin(), start.end());
  if (!is_finite(at.r) || !is_finite(at.J)) {
    minimum.sum = infinity;
    minimum.reason = "the law does not exist at the start";
    return minimum;
  }
  if (problem.num_parameters() > 0) minimum = TaoProblem(problem, start).solve(start);
  const Linearised end(problem, minimum.x);
  minimum.sum = std::inner_product(end.r.begin(), end.r.end(), end.r.begin(), 0.0);
  constexpr double orthogonal = 1e-6;
  minimum.is_converged = orthogonality(problem, minimum.x) <= orthogonal;
  return minimum;
}

Determination determination(const LeastSquaresProblem& problem, const Minimum& minimum, std::span<const double> size) {
  constexpr double blind = 1e-8, part = 0.05;  // relative singular value, and what of a direction counts
  const Linearised at(problem, minimum.x);
  const std::size_t n = at.r.size(), p = problem.num_parameters();
  Determination result;
  std::vector<std::size_t> moving;
  std::vector<std::vector<double>> A;
  for (std::size_t j = 0; j < p; ++j) {
    auto column = at.column(j);
    const double gradient = std::inner_product(column.begin(), column.end(), at.r.begin(), 0.0);
    result.is_at_bound.push_back(is_held(problem, minimum.x, j, gradient));
    if (result.is_at_bound.back()) continue;
    moving.push_back(j);
    for (double& entry : column) entry *= size[j];
    A.push_back(std::move(column));
  }
  result.is_determined.assign(p, true);
  result.covariance.assign(p * p, 0.0);
  result.variance = n > moving.size() ? minimum.sum / static_cast<double>(n - moving.size()) : nan;
  if (moving.empty()) return result;
  const Svd of = svd(std::move(A));
  result.singular_values = of.values;
  for (std::size_t k = 0; k < moving.size(); ++k) {
    result.modes.emplace_back(p, 0.0);
    for (std::size_t j = 0; j < moving.size(); ++j) result.modes[k][moving[j]] = of.right[k][j];
    const bool is_seen = of.values[k] > blind * of.values[0];
    for (std::size_t i = 0; i < p; ++i) {
      if (!is_seen && std::abs(result.modes[k][i]) > part) result.is_determined[i] = false;
      for (std::size_t j = 0; j < p && is_seen; ++j) {
        const double value = result.modes[k][i] * size[i] * result.modes[k][j] * size[j];
        result.covariance[p * i + j] += result.variance * value / (of.values[k] * of.values[k]);
      }
    }
  }
  for (std::size_t i = 0; i < p; ++i) {
    if (!result.is_determined[i]) result.covariance[p * i + i] = infinity;
  }
  return result;
}

std::vector<double> halton_point(int n, std::size_t dimension) {
  std::vector<double> point;
  for (int base = 2; point.size() < dimension; ++base) {
    const auto divides = [&](int d) { return base % d == 0; };
    bool is_prime = true;
    for (int d = 2; d * d <= base; ++d) is_prime = is_prime && !divides(d);
    if (!is_prime) continue;
    double value = 0.0, digit = 1.0;
    for (int rest = n; rest > 0; rest /= base) {
      digit /= base;
      value += digit * (rest % base);
    }
    point.push_back(value);
  }
  return point;
}

}  // namespace pliant
