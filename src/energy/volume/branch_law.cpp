#include "energy/volume/branch_law.hpp"

#include "base/vector_math.hpp"
#include "energy/volume/point_tensor.hpp"
#include "material/kinematics.hpp"
#include "material/volume_split.hpp"

#include <array>
#include <cmath>

namespace pliant {
namespace {

using Symmetric = std::array<Pack, num_symmetric>;

constexpr int most_iterations = 40;
constexpr double longest = 0.3;  // of F^-1 dF: a law with a barrier stays within it
/// Newton's method ends with a step of this part of the strain: what is left is of the order of its square, rounding.
constexpr double last_step = 1e-9;
constexpr double least_strain = 1e-14;  // that differs from none

Tensor3<Pack> inverse(const Tensor3<Pack>& F) {
  return (1.0 / det(F)) * transpose(cofactor(F));
}

/// The symmetric tensor of unit size in the k-th component.
Tensor3<Pack> unit(int k) {
  const double size = k < 3 ? 1.0 : 0.5;
  Tensor3<Pack> D{};
  D(symmetric_rows[k], symmetric_columns[k]) = D(symmetric_columns[k], symmetric_rows[k]) = size;
  return D;
}

Symmetric components(const Tensor3<Pack>& S) {
  Symmetric s;
  for (int k = 0; k < num_symmetric; ++k) s[k] = S(symmetric_rows[k], symmetric_columns[k]);
  return s;
}

/// sum_k x_k unit(k).
Tensor3<Pack> assembled(const Symmetric& x) {
  Tensor3<Pack> D{};
  for (int k = 0; k < num_symmetric; ++k) {
    D(symmetric_rows[k], symmetric_columns[k]) = D(symmetric_columns[k], symmetric_rows[k]) = k < 3 ? x[k] : 0.5 * x[k];
  }
  return D;
}

/// Whether a step of Newton's method to this strain is not yet the last one.
bool continues(const Tensor3<Pack>& step, const Tensor3<Pack>& strain) {
  return any_of(dot(step, step) > last_step * last_step * (least_strain + dot(strain, strain)));
}

/// A : dF.
Tensor3<Pack> product(const Tangent<Pack>& A, const Tensor3<Pack>& dF) {
  Tensor3<Pack> dP{};
  for (int p = 0; p < 9; ++p) {
    for (int q = 0; q < 9; ++q) dP.a[p] += A[9 * p + q] * dF.a[q];
  }
  return dP;
}

/// Solves C x = b by elimination without pivoting; C is symmetric and positive definite, and its upper half is read.
Symmetric solve(std::array<Symmetric, num_symmetric>& C, Symmetric b) {
  Symmetric inverse_pivots;
  for (int k = 0; k < num_symmetric; ++k) {
    inverse_pivots[k] = 1.0 / C[k][k];
    for (int i = k + 1; i < num_symmetric; ++i) {
      const Pack factor = C[k][i] * inverse_pivots[k];
      for (int j = i; j < num_symmetric; ++j) C[i][j] -= factor * C[k][j];
      b[i] -= factor * b[k];
    }
  }
  for (int k = num_symmetric - 1; k >= 0; --k) {
    for (int j = k + 1; j < num_symmetric; ++j) b[k] -= C[k][j] * b[j];
    b[k] *= inverse_pivots[k];
  }
  return b;
}

/// At most `longest`: its factor.
Pack shortening(const Tensor3<Pack>& relative) {
  const Pack size = 1.0 / (longest * longest) * dot(relative, relative);
  return select(size > 1.0, 1.0 / size, Pack(1.0));
}

}  // namespace

Tensor3<Pack> pulled_back_stress(const Tensor3<Pack>& H, const Tensor3<Pack>& P) {
  return matmul(inverse(add_to_diagonal(H, 1.0)), P);
}

BranchLaw::BranchLaw(const LawField& elastic)
    : elastic_(elastic),
      measure_(elastic.traits().constant_tangent ? Strain::small
               : is_isochoric(elastic)           ? Strain::isochoric
                                                 : Strain::green_lagrange) {}

Tensor3<Pack> BranchLaw::strain(const Tensor3<Pack>& H) const {
  if (measure_ == Strain::small) return small_strain(H);
  const Tensor3<Pack> E = green_lagrange(H);
  if (measure_ == Strain::green_lagrange) return E;
  const Pack growth = expm1(Pack(-2.0 / 3.0 * log1p(volume_change(H))));  // J^(-2/3) - 1
  return add_to_diagonal((1.0 + growth) * E, 0.5 * growth);
}

Tensor3<Pack> BranchLaw::strain_change(const Tensor3<Pack>& H, const Tensor3<Pack>& dH) const {
  if (measure_ == Strain::small) return small_strain(dH);
  const Tensor3<Pack> dE = green_lagrange_change(H, dH);
  if (measure_ == Strain::green_lagrange) return dE;
  const Tensor3<Pack> F = add_to_diagonal(H, 1.0), after = F + dH;
  const Pack j = volume_change(H), dJ = det_change(F, dH);
  const Pack a = 1.0 + expm1(Pack(-2.0 / 3.0 * log1p(j)));
  const Pack growth = expm1(Pack(-2.0 / 3.0 * log1p(Pack(dJ / (1.0 + j)))));
  return a * (dE + 0.5 * growth * matmul(transpose(after), after));
}

Tensor3<Pack> BranchLaw::stress(std::size_t n, const Tensor3<Pack>& H) const {
  const Tensor3<Pack> P = elastic_.P(n, H);
  if (measure_ == Strain::small) return P;
  const Tensor3<Pack> S = pulled_back_stress(H, P);
  if (measure_ == Strain::green_lagrange) return S;
  return (1.0 + expm1(Pack(2.0 / 3.0 * log1p(volume_change(H))))) * S;
}

Tensor3<Pack> BranchLaw::force(const Tensor3<Pack>& H, const Tensor3<Pack>& A) const {
  if (measure_ == Strain::small) return A;
  const Tensor3<Pack> FA = A + matmul(H, A);
  if (measure_ == Strain::green_lagrange) return FA;
  const Tensor3<Pack> F = add_to_diagonal(H, 1.0), G = transpose(inverse(F));
  const Pack a = 1.0 + expm1(Pack(-2.0 / 3.0 * log1p(volume_change(H))));
  return a * (FA - Pack(dot(FA, F) / 3.0) * G);  // (F A) : F = A : C
}

Tensor3<Pack> BranchLaw::pulled_back_force(const Tensor3<Pack>& H, const Tensor3<Pack>& L) const {
  if (measure_ == Strain::small) return L;
  const Tensor3<Pack> F = add_to_diagonal(H, 1.0), FL = matmul(transpose(F), L);
  if (measure_ == Strain::green_lagrange) return FL;
  const Tensor3<Pack> G = transpose(inverse(F));
  const Pack a = 1.0 + expm1(Pack(-2.0 / 3.0 * log1p(volume_change(H))));
  return a * (FL - Pack(dot(G, L) / 3.0) * matmul(transpose(F), F));
}

// With S' = F^-1 P and M = F^-T Z, Z : dS' = M : dP - M : (dF S'); S = J^(2/3) S' of the isochoric strain.
Tensor3<Pack> BranchLaw::stress_slope(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& Z) const {
  Tangent<Pack> A;
  elastic_.tangent(n, H, A);
  if (measure_ == Strain::small) return product(A, Z);
  const Tensor3<Pack> G = transpose(inverse(add_to_diagonal(H, 1.0))), M = matmul(G, Z);
  const Tensor3<Pack> S = pulled_back_stress(H, elastic_.P(n, H));
  const Tensor3<Pack> slope = product(A, M) - matmul(M, transpose(S));
  if (measure_ == Strain::green_lagrange) return slope;
  const Pack b = 1.0 + expm1(Pack(2.0 / 3.0 * log1p(volume_change(H))));
  return b * (slope + Pack(2.0 / 3.0 * dot(Z, S)) * G);
}

// Isochoric, with a = J^(-2/3), G = F^-T, M = F A and w = A : C, d(a M - a w/3 G) is
//   a dF A - 2 a/3 ((G:dF) M + (M:dF) G) + 2 a w/9 (G:dF) G + a w/3 G dF^T G.
void BranchLaw::subtract_stiffness(const Tensor3<Pack>& H, const Tensor3<Pack>& A, Tangent<Pack>& K) const {
  if (measure_ == Strain::small) return;
  Pack a = 1.0;
  if (measure_ == Strain::isochoric) {
    const Tensor3<Pack> F = add_to_diagonal(H, 1.0), G = transpose(inverse(F)), M = A + matmul(H, A);
    a = 1.0 + expm1(Pack(-2.0 / 3.0 * log1p(volume_change(H))));
    const Pack aw = a * dot(M, F);
    for (int i = 0; i < 3; ++i) {
      for (int J = 0; J < 3; ++J) {
        for (int k = 0; k < 3; ++k) {
          for (int L = 0; L < 3; ++L) {
            K[9 * (3 * i + J) + 3 * k + L] += 2.0 / 3.0 * a * (M(i, J) * G(k, L) + G(i, J) * M(k, L)) -
                                              aw * (2.0 / 9.0 * (G(i, J) * G(k, L)) + 1.0 / 3.0 * (G(i, L) * G(k, J)));
          }
        }
      }
    }
  }
  for (int i = 0; i < 3; ++i) {
    for (int J = 0; J < 3; ++J) {
      for (int L = 0; L < 3; ++L) K[9 * (3 * i + J) + 3 * i + L] -= a * A(J, L);
    }
  }
}

// C_kl = unit_k : dS(unit_l), symmetric and positive definite where psi_e is convex in D. dE = sym(F^T dF) of dF = F^-T
// dE, and dS = F^-1 (dP - dF S).
Tensor3<Pack> BranchLaw::relaxed(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& A) const {
  const bool is_small = measure_ == Strain::small;
  Tensor3<Pack> at = H;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Tensor3<Pack> G = is_small ? identity<Pack>() : inverse(add_to_diagonal(at, 1.0));
    const Tensor3<Pack> P = elastic_.P(n, at), S = is_small ? P : matmul(G, P);
    Tangent<Pack> tangent;
    elastic_.tangent(n, at, tangent);
    std::array<Symmetric, num_symmetric> C;
    for (int l = 0; l < num_symmetric; ++l) {
      const Tensor3<Pack> dF = matmul(transpose(G), unit(l)), dP = product(tangent, dF);
      const Symmetric dS = components(is_small ? dP : matmul(G, dP - matmul(dF, S)));
      for (int k = 0; k <= l; ++k) C[k][l] = dS[k];
    }
    const Tensor3<Pack> dE = assembled(solve(C, components(A - S)));
    const Tensor3<Pack> dF = matmul(transpose(G), dE);
    at = at + shortening(matmul(G, dF)) * dF;
    if (!continues(dE, strain(at))) break;
  }
  return at;
}

// On F -> exp(h) F with symmetric h, along which isochoric energies of rubber are convex: with tau = P F^T, the
// derivatives of the energy are tau : h and (h F) : A : (h F) + tau : h h. A change of volume is free: a stiffness of
// the size of the law's fixes it.
Tensor3<Pack> BranchLaw::isochoric_relaxed(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& A) const {
  Tensor3<Pack> at = H;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Tensor3<Pack> F = add_to_diagonal(at, 1.0);
    const Tensor3<Pack> P = elastic_.P(n, at) - force(at, A), tau = matmul(P, transpose(F));
    Tangent<Pack> tangent;
    elastic_.tangent(n, at, tangent);
    subtract_stiffness(at, A, tangent);
    std::array<Symmetric, num_symmetric> C;
    Pack size = 0.0;
    for (int l = 0; l < num_symmetric; ++l) {
      const Tensor3<Pack> h = unit(l), slope = matmul(product(tangent, matmul(h, F)), transpose(F)) + matmul(tau, h);
      const Tensor3<Pack> even = small_strain(slope);
      const Symmetric column = components(even);
      for (int k = 0; k <= l; ++k) C[k][l] = column[k];
      size += C[l][l];
    }
    for (int k = 0; k < 3; ++k) {
      for (int l = 0; l < 3; ++l) C[k][l] += size;
    }
    Symmetric b = components(-1.0 * tau);
    const Tensor3<Pack> h = assembled(solve(C, b));
    const Tensor3<Pack> step = shortening(h) * h;
    at = at + matmul(step + 0.5 * matmul(step, step), F);
    if (!continues(h, strain(at))) break;
  }
  return at;
}

BranchState BranchLaw::state(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& A) const {
  const Tensor3<Pack> at = measure_ == Strain::isochoric ? isochoric_relaxed(n, H, A) : relaxed(n, H, A);
  const Tensor3<Pack> elongation = strain(H) - strain(at);
  return {elastic_.psi(n, H) - elastic_.psi(n, at) - dot(A, elongation), elongation};
}

}  // namespace pliant
