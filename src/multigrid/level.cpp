#include "multigrid/level.hpp"

#include "multigrid/block_csr_several.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/Dense>
#include <limits>
#include <numeric>
#include <utility>

namespace pliant {
namespace {

/// The part of the spectrum that is smoothed, relative to the estimate of the largest eigenvalue.
constexpr double smoothed_from = 0.1, smoothed_to = 1.1;
/// Products with the matrix for each smoothing from a given x.
constexpr int degree = 2;
/// Iterations of conjugate gradients that estimate the largest eigenvalue.
constexpr int num_estimating = 10;

/// A number between -1 and 1 for each entry, the same on any number of ranks.
float pseudorandom(PetscInt64 entry) {
  auto bits = static_cast<std::uint64_t>(entry) * 0x9E3779B97F4A7C15U;
  bits ^= bits >> 31U;
  bits *= 0xBF58476D1CE4E5B9U;
  return static_cast<float>(bits >> 40U) / static_cast<float>(1U << 23U) - 1.0F;
}

double dot(MPI_Comm comm, std::span<const float> x, std::span<const float> y) {
  double local = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) local += static_cast<double>(x[i]) * y[i];
  return sum(comm, local);
}

template <int n>
void invert(const double* block, float* inverse) {
  using Block = Eigen::Matrix<double, n, n>;
  const Eigen::Map<const Block> D(block);
  const Eigen::FullPivLU<Block> lu(D);
  Block result = Block::Zero();
  if (lu.isInvertible()) {
    result = lu.inverse();
  } else {
    for (int k = 0; k < n; ++k) result(k, k) = D(k, k) != 0.0 ? 1.0 / D(k, k) : 1.0;
  }
  Eigen::Map<Eigen::Matrix<float, n, n>> into(inverse);
  into = result.template cast<float>();
}

}  // namespace

Level::Level(Halo halo, BlockCsr pattern) : halo_(std::move(halo)), A_(std::move(pattern)) {
  A_.allocate();
  D_.resize(static_cast<std::size_t>(A_.num_rows()) * A_.block_size() + BlockCsr::padding);
}

bool Level::take(const BlockSource& values) {
  double block[36];
  for (int row = 0; row < A_.num_rows(); ++row) {
    for (std::size_t k = A_.begin(row); k < A_.end(row); ++k) {
      values.read(row, k - A_.begin(row), block);
      std::transform(block, block + A_.block_size(), A_.block(k), [](double x) { return static_cast<float>(x); });
      if (A_.columns[k] != row) continue;
      float* const inverse = D_.data() + static_cast<std::size_t>(row) * A_.block_size();
      A_.height == 3 ? invert<3>(block, inverse) : invert<6>(block, inverse);
    }
  }
  largest_ = estimate_largest();
  return largest_ > 0.0 && std::isfinite(largest_);
}

// The coefficients of conjugate gradients are those of Lanczos' method (Saad 2003, Iterative Methods for Sparse Linear
// Systems, 6.7.3).
double Level::estimate_largest() const {
  std::vector<float> r(num_own_entries()), z(num_own_entries()), Ap(num_own_entries()), p = make_vector();
  for (std::size_t i = 0; i < r.size(); ++i) {
    r[i] = pseudorandom(halo_.first() * A_.height + static_cast<PetscInt64>(i) + 1);
  }
  std::vector<double> diagonal, beside;
  double before = 0.0, alpha = 0.0, beta = 0.0;
  for (int k = 0; k < num_estimating; ++k) {
    scale_blocks(A_.height, D_, r, 1.0F, z);
    const double now = dot(halo_.comm(), r, z);
    if (!(now > 0.0)) break;
    beta = k == 0 ? 0.0 : now / before;
    for (std::size_t i = 0; i < z.size(); ++i) p[i] = z[i] + static_cast<float>(beta) * p[i];
    halo_.fetch(std::span(p), A_.height);
    multiply(A_, p, Ap);
    const double curvature = dot(halo_.comm(), own(std::span<const float>(p)), Ap);
    if (!(curvature > 0.0)) break;
    if (k > 0) beside.push_back(std::sqrt(beta) / alpha);
    diagonal.push_back((k > 0 ? beta / alpha : 0.0) + curvature / now);
    alpha = now / curvature;
    for (std::size_t i = 0; i < r.size(); ++i) r[i] -= static_cast<float>(alpha) * Ap[i];
    before = now;
  }
  if (diagonal.empty()) return halo_.num_global() == 0 ? 1.0 : 0.0;
  const auto size = static_cast<Eigen::Index>(diagonal.size());
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(Eigen::Map<Eigen::VectorXd>(diagonal.data(), size),
                                Eigen::Map<Eigen::VectorXd>(beside.data(), size - 1), Eigen::EigenvaluesOnly);
  return solver.eigenvalues().maxCoeff();
}

template <class T>
void Level::residual(Work<T>& w) const {
  halo_.fetch(std::span(w.x), A_.height);
  pliant::residual(A_, w.x, own(std::span(w.b)), own(std::span(w.r)));
}

// Saad 2003, algorithm 12.1.
template <class T>
void Level::smooth(Work<T>& w, Start start) const {
  const double theta = (smoothed_to + smoothed_from) / 2.0 * largest_;
  const double delta = (smoothed_to - smoothed_from) / 2.0 * largest_;
  const double sigma = theta / delta;
  const std::span<T> p = own(std::span(w.step)), b = own(std::span(w.b));
  double rho = 1.0 / sigma;
  for (int k = 0; k < degree; ++k) {
    const double next = k == 0 ? 0.0 : 1.0 / (2.0 * sigma - rho);
    const double keep = next * rho, take = k == 0 ? 1.0 / theta : 2.0 * next / delta;
    if (k > 0) rho = next;
    if (k == 0 && start == Start::zero) {
      scale_blocks(A_.height, D_, b, static_cast<float>(take), p);
      std::ranges::copy(p, w.x.begin());
      continue;
    }
    if (k == 0) std::ranges::fill(p, T(0.0F));
    halo_.fetch(std::span(w.x), A_.height);
    pliant::smooth(A_, D_, w.x, b, static_cast<float>(keep), static_cast<float>(take), p);
    for (std::size_t i = 0; i < p.size(); ++i) w.x[i] += p[i];
  }
}

template void Level::residual(Work<float>&) const;
template void Level::residual(Work<SeveralFloats>&) const;
template void Level::smooth(Work<float>&, Start) const;
template void Level::smooth(Work<SeveralFloats>&, Start) const;

}  // namespace pliant
