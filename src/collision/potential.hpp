/// A potential U(d) of the distance of two features, to second order in the positions of their points.
///
/// The law gives U, the pressure p = -U' and its slope U'' at d; those of a penalty
/// and of a barrier are in material/contact_law. With the names of collision/distance and m = w n,
///
///     dU/dx_i = -p w_i n
///     d2U/dx_i dx_j = U'' w_i w_j n n^T + p sum_k [d w_k,i w_k,j n n^T + w_k,i w_j n t_k^T + w_i w_k,j t_k n^T]
///                     - (p / d) w_i w_j (I - n n^T - sum_k t_k t_k^T)
///
/// so that the Hessian is of rank 5 at most. What it does lies in the directions m, w_k n and w t_k, and apart from
/// them, in its last part: its projection is that of a matrix of 1 + 2 K rows instead of 3 N.
#pragma once

#include "collision/distance.hpp"

#include <concepts>

namespace pliant {

/// What a law of contact says of a distance, per area: U [J/m^2], p [Pa], U'' [Pa/m].
template <class R>
concept DistanceResponse = requires(const R& response) {
  { response.energy } -> std::convertible_to<double>;
  { response.pressure } -> std::convertible_to<double>;
  { response.stiffness } -> std::convertible_to<double>;
};

enum class Definiteness {
  exact,         ///< the Hessian as it is
  semidefinite,  ///< negative eigenvalues become zero
};

/// U(d), the Hessian's form once more with numbers in it:
///
///     block (i, j) = normal_ij n n^T + sum_k (mixed_k,i w_j n t_k^T + w_i mixed_k,j t_k n^T) + w_i w_j tangential
template <int N>
struct PotentialForm {
  std::array<double, N * N> normal{};
  std::array<std::array<double, N>, 2> mixed{};
  Tensor3<double> tangential{};
};

/// The form as it is.
template <int N>
PotentialForm<N> exact_form(const Separation<N>& at, double pressure, double stiffness);

/// The nearest one that is positive semidefinite.
template <int N>
PotentialForm<N> semidefinite_form(const Separation<N>& at, double pressure, double stiffness);

/// The gradient alone, and the value.
template <int N, DistanceResponse Response>
Expansion<N> first_order(const Separation<N>& at, const Response& response) {
  Expansion<N> U;
  U.value = response.energy;
  for (int i = 0; i < N; ++i) U.gradient[i] = (-response.pressure * at.weights[i]) * at.normal;
  return U;
}

template <int N, DistanceResponse Response>
Expansion<N> expand(const Separation<N>& at, const Response& response, Definiteness definiteness) {
  Expansion<N> U = first_order(at, response);
  const PotentialForm<N> form = definiteness == Definiteness::exact
                                    ? exact_form<N>(at, response.pressure, response.stiffness)
                                    : semidefinite_form<N>(at, response.pressure, response.stiffness);
  const auto& n = at.normal;
  // sum_k (mixed_k,i w_j n t_k^T + ...) = n y_i^T w_j + w_i y_j n^T
  std::array<Vector3<double>, N> y;
  for (int i = 0; i < N; ++i) y[i] = form.mixed[0][i] * at.tangents[0] + form.mixed[1][i] * at.tangents[1];
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      const double nn = form.normal[N * i + j], w_i = at.weights[i], w_j = at.weights[j], ww = w_i * w_j;
      U.block(i, j) = make_tensor([&](int p, int q) {
        return n[p] * (nn * n[q] + w_j * y[i][q]) + w_i * y[j][p] * n[q] + ww * form.tangential(p, q);
      });
    }
  }
  return U;
}

/// m U, of two functions of the same points: of edges that are nearly parallel.
Expansion<4> product(const Expansion<4>& m, const Expansion<4>& U);

extern template PotentialForm<2> exact_form(const Separation<2>&, double, double);
extern template PotentialForm<3> exact_form(const Separation<3>&, double, double);
extern template PotentialForm<4> exact_form(const Separation<4>&, double, double);
extern template PotentialForm<5> exact_form(const Separation<5>&, double, double);
extern template PotentialForm<6> exact_form(const Separation<6>&, double, double);
extern template PotentialForm<2> semidefinite_form(const Separation<2>&, double, double);
extern template PotentialForm<3> semidefinite_form(const Separation<3>&, double, double);
extern template PotentialForm<4> semidefinite_form(const Separation<4>&, double, double);
extern template PotentialForm<5> semidefinite_form(const Separation<5>&, double, double);
extern template PotentialForm<6> semidefinite_form(const Separation<6>&, double, double);

}  // namespace pliant
