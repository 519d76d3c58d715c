/// The law of a branch of a Prony series: its stress follows the elastic law and relaxes (energy/volume/prony.hpp).
///
/// A branch measures strain as D(H), and the stress that belongs to it is S, with psi_e the elastic energy:
///
///   small strain     D = sym H                      S = P_e              laws of small strain
///   Green-Lagrange   D = E                          S = F^-1 P_e         all others
///   isochoric        D = (J^(-2/3) F^T F - I)/2     S = J^(2/3) F^-1 P_e   laws that do not feel a change of volume
///
/// With A the stress that the branch has forgotten, its force is P_e - d(A : D)/dH, for the isochoric strain
///
///     d(A : D)/dH = J^(-2/3) (F A - (A : C)/3 F^-T),   C = F^T F
///
/// so that a branch of an isochoric law does not resist a change of volume either. What the branch stores is
/// psi_e(H) - psi_e(H_i) - A : (D - D_i), where H_i minimises psi_e - A : D: the state in which the branch would be
/// free of stress. It dissipates (S - A) : (D - D_i) / tau, >= 0 for neo-Hookean laws and wherever psi_e is convex in
/// D. Sources: Simo, Comput. Methods Appl. Mech. Eng. 60 (1987), 153-173; Holzapfel, Nonlinear Solid Mechanics (2000),
/// section 6.10.
#pragma once

#include "material/law_field.hpp"

namespace pliant {

/// The energy that a branch stores per reference volume, and the strain from which it is measured.
struct BranchState {
  Pack energy;               ///< psi_e - psi_e(H_i) - A : (D - D_i) [J/m^3]
  Tensor3<Pack> elongation;  ///< D - D_i
};

/// All functions are evaluated at the n-th pack of points of the law (LawField).
class BranchLaw {
 public:
  enum class Strain { small, green_lagrange, isochoric };

  /// `elastic` must outlive the object.
  explicit BranchLaw(const LawField& elastic);

  Strain strain_measure() const { return measure_; }
  Tensor3<Pack> strain(const Tensor3<Pack>& H) const;
  /// D(H + dH) - D(H), accurate relative to the change.
  Tensor3<Pack> strain_change(const Tensor3<Pack>& H, const Tensor3<Pack>& dH) const;
  /// S [Pa].
  Tensor3<Pack> stress(std::size_t n, const Tensor3<Pack>& H) const;
  /// d(A : D)/dH [Pa].
  Tensor3<Pack> force(const Tensor3<Pack>& H, const Tensor3<Pack>& A) const;
  /// B with B : dA = L : force(H, dA) for symmetric dA.
  Tensor3<Pack> pulled_back_force(const Tensor3<Pack>& H, const Tensor3<Pack>& L) const;
  /// d(Z : S)/dH for symmetric Z [Pa].
  Tensor3<Pack> stress_slope(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& Z) const;
  /// K -= d2(A : D)/dH2.
  void subtract_stiffness(const Tensor3<Pack>& H, const Tensor3<Pack>& A, Tangent<Pack>& K) const;
  /// By Newton's method starting from H; the result of the last iteration if psi_e - A : D has no minimum.
  BranchState state(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& A) const;

 private:
  /// H_i.
  Tensor3<Pack> relaxed(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& A) const;
  Tensor3<Pack> isochoric_relaxed(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& A) const;

  const LawField& elastic_;
  Strain measure_;
};

/// F^-1 P, the second Piola-Kirchhoff stress.
Tensor3<Pack> pulled_back_stress(const Tensor3<Pack>& H, const Tensor3<Pack>& P);

}  // namespace pliant
