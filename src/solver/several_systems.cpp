#include "solver/several_systems.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/matrix_pattern.hpp"

#include <array>

namespace pliant {
namespace {

namespace stdx = std::experimental;

/// Stands for the square of a norm that is 0.
constexpr double least = 1e-300;

void load(std::span<const Vec> from, std::span<SeveralDoubles> to) {
  std::ranges::fill(to, SeveralDoubles(0.0));
  for (std::size_t lane = 0; lane < from.size(); ++lane) {
    if (from[lane] == nullptr) continue;
    const ConstArrayView values(from[lane]);
    for (std::size_t i = 0; i < to.size(); ++i) to[i][lane] = values.span()[i];
  }
}

void store(std::span<const SeveralDoubles> from, std::span<const Vec> to) {
  for (std::size_t lane = 0; lane < to.size(); ++lane) {
    const ArrayView values(to[lane]);
    for (std::size_t i = 0; i < from.size(); ++i) values.span()[i] = from[i][lane];
  }
}

/// a / b where `is`, 0 elsewhere.
SeveralDoubles quotient(const SeveralDoubles& a, const SeveralDoubles& b, const SeveralDoubles::mask_type& is) {
  SeveralDoubles result(0.0);
  where(is, result) = a / b;
  return result;
}

}  // namespace

void SeveralSystems::open(const MatrixBlocks& blocks, Mat K) {
  if (pattern_ == pattern_id(K)) return;
  pattern_ = pattern_id(K);
  halo_ = blocks.make_halo();
  const std::size_t own = 3 * static_cast<std::size_t>(blocks.num_rows());
  for (auto* vector : {&x_, &r_, &z_, &Kp_}) vector->assign(own, SeveralDoubles(0.0));
  p_.assign(3 * static_cast<std::size_t>(halo_.num_local()), SeveralDoubles(0.0));
}

SeveralDoubles SeveralSystems::dot(std::span<const SeveralDoubles> a, std::span<const SeveralDoubles> b) const {
  SeveralDoubles products(0.0);
  for (std::size_t i = 0; i < b.size(); ++i) products += a[i] * b[i];
  std::array<double, num_several> sums{};
  products.copy_to(sums.data(), stdx::element_aligned);
  sum_in_place(halo_.comm(), sums);
  return SeveralDoubles(sums.data(), stdx::element_aligned);
}

std::optional<SeveralSystems::Cost> SeveralSystems::solve(Mat K, const Inverse& inverse, std::span<const Vec> r,
                                                          std::span<const Vec> guesses, std::span<const Vec> y,
                                                          double part, int most) {
  const std::optional<MatrixBlocks> blocks = MatrixBlocks::of(K);
  if (!blocks) return std::nullopt;
  open(*blocks, K);
  load(r, r_);
  std::ranges::fill(p_, SeveralDoubles(0.0));
  load(guesses, std::span(p_).first(r_.size()));
  halo_.fetch(std::span(p_), 3);
  blocks->multiply(p_, Kp_);
  for (std::size_t i = 0; i < r_.size(); ++i) Kp_[i] += r_[i];
  std::ranges::fill(x_, SeveralDoubles(0.0));
  const SeveralDoubles target = part * part * dot(Kp_, Kp_);
  SeveralDoubles size = dot(r_, r_), before(1.0);
  const SeveralDoubles digits = 0.5 * stdx::log10(stdx::max(size, target) / stdx::max(target, SeveralDoubles(least)));
  int iterations = 0;
  for (auto is_left = size > target; any_of(is_left); is_left = size > target, ++iterations) {
    if (iterations == most || !inverse(r_, z_)) return std::nullopt;
    const SeveralDoubles now = dot(r_, z_);
    const SeveralDoubles beta = iterations == 0 ? SeveralDoubles(0.0) : quotient(now, before, is_left);
    before = now;
    for (std::size_t i = 0; i < z_.size(); ++i) p_[i] = z_[i] + beta * p_[i];
    halo_.fetch(std::span(p_), 3);
    blocks->multiply(p_, Kp_);
    const SeveralDoubles curvature = dot(p_, Kp_);
    if (any_of(is_left && !(now > 0.0 && curvature > 0.0))) return std::nullopt;
    const SeveralDoubles alpha = quotient(now, curvature, is_left);
    for (std::size_t i = 0; i < r_.size(); ++i) {
      x_[i] += alpha * p_[i];
      r_[i] -= alpha * Kp_[i];
    }
    size = dot(r_, r_);
    if (any_of(!(size >= 0.0))) return std::nullopt;
  }
  store(x_, y);
  return Cost{iterations, stdx::hmax(digits)};
}

}  // namespace pliant
