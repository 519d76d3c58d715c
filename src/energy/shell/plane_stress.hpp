/// Elastic laws in plane stress: the law of a thin layer, from which no stress acts on its faces.
///
/// A point of the layer has the axes t_1, t_2 in the layer and N across it. Its columns f_a = F t_a follow the surface;
/// the third, the director d = F N, is the one that the thickness takes by itself:
///
///     W(f_1, f_2) = min over d of psi(f_1 (x) t_1 + f_2 (x) t_2 + d (x) N),      so that P N = 0
///     dP/df = A_ff - A_fd A_dd^-1 A_df
///
/// d is found by Newton's method from that of an unchanged volume, n / (f_1 x f_2 . n). All three components of P N
/// vanish, so laws with fibres across the layer are covered too. |d| is the stretch of the thickness in isotropic laws.
/// Source: Klinkel & Govindjee, Eng. Comput. 19 (2002) 147-164 (condensation by Newton's method at the point).
#pragma once

#include "material/law_field.hpp"

#include <array>

namespace pliant {

/// The rows are t_1, t_2 and N = t_1 x t_2, unit vectors.
using LayerAxes = Tensor3<Pack>;
/// Two vectors along the axes in the layer: f_a - t_a, forces, ...
using LayerColumns = std::array<std::array<Pack, 3>, 2>;
/// d P_ia / d f_kb [Pa] at [6 (3 a + i) + 3 b + k]; symmetric.
using LayerTangent = std::array<Pack, 36>;

/// A point of a layer in plane stress.
struct LayerState {
  Tensor3<Pack> H;  ///< F - I
  LayerColumns P;   ///< P t_a [Pa]; NaN where no such state exists
};

/// A law of a body, in plane stress.
class PlaneStress {
 public:
  explicit PlaneStress(std::unique_ptr<LawField> law) : law_(std::move(law)) {}

  const LawField& law() const { return *law_; }
  /// At the n-th pack of points, for the changes h_a = f_a - t_a.
  LayerState state(std::size_t n, const LayerAxes& axes, const LayerColumns& h) const;
  /// W [J/m^3]; `at` is the state there.
  Pack psi(std::size_t n, const LayerState& at) const { return law_->psi(n, at.H); }
  /// W(after) - W(before), accurate relative to the change.
  Pack psi_change(std::size_t n, const LayerState& before, const LayerState& after) const {
    return law_->psi_change(n, before.H, after.H - before.H);
  }
  /// T, and the state there.
  LayerState tangent(std::size_t n, const LayerAxes& axes, const LayerColumns& h, LayerTangent& T) const;

 private:
  /// The state, and A = dP/dH next to it: off by a step whose square is lost.
  LayerState solve(std::size_t n, const LayerAxes& axes, const LayerColumns& h, Tangent<Pack>& A) const;

  std::unique_ptr<LawField> law_;
};

}  // namespace pliant
