#include "energy/volume/active_strain.hpp"

#include "energy/volume/body_cells.hpp"
#include "material/fibre.hpp"

#include <cmath>

namespace pliant {
namespace {

/// Lane by lane: for whole packs g++ 12 warns of its own header.
Pack square_root(const Pack& x) {
  return Pack([&](auto lane) { return std::sqrt(static_cast<double>(x[lane])); });
}

/// H_e = F B - I, as a function of B - I.
Tensor3<Pack> elastic_part(const Tensor3<Pack>& H, const Tensor3<Pack>& change) {
  return H + change + matmul(H, change);
}

}  // namespace

Tensor3<Pack> ActiveStrain::change(std::size_t n) const {
  const Pack g = g_[n], c1 = g / (1.0 - g), c2 = -g / (1.0 + square_root(1.0 - g));
  const PackDirection& f = shortening_.fibre(n);
  return add_to_diagonal((c1 - c2) * outer(f, f), c2);
}

Pack ActiveStrain::psi(std::size_t n, const Tensor3<Pack>& H) const {
  return law_.psi(n, elastic_part(H, change(n)));
}

Pack ActiveStrain::psi_change(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& dH) const {
  const Tensor3<Pack> b = change(n);
  return law_.psi_change(n, elastic_part(H, b), dH + matmul(dH, b));
}

Tensor3<Pack> ActiveStrain::P(std::size_t n, const Tensor3<Pack>& H) const {
  const Tensor3<Pack> b = change(n), P_e = law_.P(n, elastic_part(H, b));
  return P_e + matmul(P_e, b);
}

void ActiveStrain::tangent(std::size_t n, const Tensor3<Pack>& H, Tangent<Pack>& A) const {
  const Tensor3<Pack> b = change(n);
  law_.tangent(n, elastic_part(H, b), A);
  A = pulled_back(A, add_to_diagonal(b, 1.0));
}

// dB/dg = 1 / (1 - g)^2 f (x) f - 1 / (2 (1 - g)^(1/2)) (I - f (x) f).
Pack ActiveStrain::slope(std::size_t n, const Tensor3<Pack>& H) const {
  const Pack rest = 1.0 - g_[n], c1 = 1.0 / (rest * rest), c2 = -0.5 / square_root(rest);
  const PackDirection& f = shortening_.fibre(n);
  const Tensor3<Pack> dB = add_to_diagonal((c1 - c2) * outer(f, f), c2);
  const Tensor3<Pack> P_e = law_.P(n, elastic_part(H, change(n)));
  return dot(P_e, dB + matmul(H, dB));
}

}  // namespace pliant
