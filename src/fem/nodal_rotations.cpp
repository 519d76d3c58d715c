#include "fem/nodal_rotations.hpp"

#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <functional>

namespace pliant {
namespace {

/// Newton's method for one rotation: it starts at the rotation of the previous stage and converges quadratically; an
/// error of `enough` [rad] costs no iteration of the Krylov method.
constexpr int most_iterations = 8;
constexpr double enough = 1e-3;

/// The rotation by the vector w with tan(angle / 2) = |w| / 2 (Cayley), near exp(w).
Tensor3<double> cayley(const Vector3<double>& w) {
  const double square = 0.25 * dot(w, w), scale = 1.0 / (1.0 + square);
  const Tensor3<double> W{{0.0, -w[2], w[1], w[2], 0.0, -w[0], -w[1], w[0], 0.0}};
  return scale * add_to_diagonal(W + 0.5 * outer(w, w), 1.0 - square);
}

/// Moves R towards the rotation that maximises tr(R^T A), by Newton's method on R exp(w); R is unchanged if the
/// iteration does not approach a maximum.
void improve(Tensor3<double>& R, const Tensor3<double>& A) {
  for (int i = 0; i < most_iterations; ++i) {
    const auto S = matmul(transpose(R), A);
    const Vector3<double> g = {S(2, 1) - S(1, 2), S(0, 2) - S(2, 0), S(1, 0) - S(0, 1)};
    const auto H = add_to_diagonal(-0.5 * (S + transpose(S)), trace(S));
    const double minor = H(0, 0) * H(1, 1) - H(0, 1) * H(0, 1), determinant = det(H);
    if (!(H(0, 0) > 0.0 && minor > 0.0 && determinant > 0.0)) return;
    const auto w = (1.0 / determinant) * matvec(cofactor(H), g);
    R = matmul(R, cayley(w));
    if (dot(w, w) < enough * enough) return;
  }
}

/// x = R x of each node, or R^T x if `is_transposed`.
template <int is_transposed, class T>
void turn_each(const std::vector<Tensor3<double>>& rotations, T* x) {
  for (const Tensor3<double>& R : rotations) {
    T turned[3];
    for (std::size_t i = 0; i < 3; ++i) {
      turned[i] = is_transposed ? R(0, i) * x[0] + R(1, i) * x[1] + R(2, i) * x[2]
                                : R(i, 0) * x[0] + R(i, 1) * x[1] + R(i, 2) * x[2];
    }
    x = std::copy_n(turned, 3, x);
  }
}

}  // namespace

NodalRotations::NodalRotations(const NodeLayout& layout, std::span<const char> is_held)
    : layout_(layout),
      turns_(static_cast<std::size_t>(layout.num_owned_nodes), 1),
      rotations_(turns_.size(), identity<double>()),
      moments_(turns_.size()),
      with_ghosts_(make_vector(layout)) {
  hold(is_held);
}

void NodalRotations::hold(std::span<const char> is_held) {
  for (std::size_t a = 0; a < turns_.size(); ++a) {
    if (is_held[3 * a] || is_held[3 * a + 1] || is_held[3 * a + 2]) turns_[a] = 0;
  }
}

void NodalRotations::positions_of(Vec u, std::vector<double>& positions) {
  check(VecCopy(u, with_ghosts_.get()));
  update_ghosts(with_ghosts_.get());
  const ConstGhostedView displacement(with_ghosts_.get());
  positions.resize(layout_.coordinates.size());
  std::ranges::transform(layout_.coordinates, displacement.span(), positions.begin(), std::plus());
}

void NodalRotations::start(Vec u) {
  positions_of(u, start_);
  std::ranges::fill(rotations_, identity<double>());
}

void NodalRotations::follow(Vec u) {
  positions_of(u, now_);
  std::ranges::fill(moments_, Tensor3<double>{});
  for (PetscInt c = 0; c < layout_.num_local_cells; ++c) {
    const auto nodes = layout_.nodes_of_cell(c);
    // Edges from the last corner; (sum over corners of products of the differences from the mean) = sum_k n_k s_k^T -
    // (sum n)(sum s)^T / 4.
    Tensor3<double> moment{};
    Vector3<double> now_sum{}, start_sum{};
    const std::size_t last = 3 * static_cast<std::size_t>(nodes[3]);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t corner = 3 * static_cast<std::size_t>(nodes[k]);
      Vector3<double> n, s;
      for (std::size_t i = 0; i < 3; ++i) {
        n[i] = now_[corner + i] - now_[last + i];
        s[i] = start_[corner + i] - start_[last + i];
        now_sum[i] += n[i];
        start_sum[i] += s[i];
      }
      moment = moment + outer(n, s);
    }
    moment = moment - 0.25 * outer(now_sum, start_sum);
    for (const PetscInt a : nodes) {
      if (a < layout_.num_owned_nodes) moments_[a] = moments_[a] + moment;
    }
  }
  for (std::size_t a = 0; a < rotations_.size(); ++a) {
    if (turns_[a]) improve(rotations_[a], moments_[a]);
  }
}

void NodalRotations::turn(Vec x) const {
  const ArrayView entries(x);
  turn_each<0>(rotations_, entries.span().data());
}

void NodalRotations::turn_back(Vec x) const {
  const ArrayView entries(x);
  turn_each<1>(rotations_, entries.span().data());
}

void NodalRotations::turn(std::span<SeveralDoubles> x) const {
  turn_each<0>(rotations_, x.data());
}

void NodalRotations::turn_back(std::span<SeveralDoubles> x) const {
  turn_each<1>(rotations_, x.data());
}

}  // namespace pliant
