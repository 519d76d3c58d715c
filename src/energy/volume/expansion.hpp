/// Expansion by heat or swelling: free of stress, a body is stretched by s(X, t) in all directions. Its material acts
/// on the rest of the deformation, and on the volume of the expanded body:
///
///     F = s F_e,   psi(F) = s^3 psi_e(F_e),   P = s^2 P_e(F_e),   dP = s A_e dF
///
/// so that a body that has expanded freely is a body of the same material and s times the size, with the Cauchy stress
/// P_e F_e^T / J_e. A law of small strain sees H_e = H - (s - 1) I instead, psi = psi_e(H_e): its stress is linear in
/// s. Sources: Lu & Pister, Int. J. Solids Struct. 11 (1975) 927-934 (F = F_e F_thermal); Rodriguez, Hoger & McCulloch,
/// J. Biomech. 27 (1994) 455-467 (the stress of grown matter is that of its law at F_e).
#pragma once

#include "energy/volume/activation.hpp"
#include "material/kinematics.hpp"
#include "material/law.hpp"
#include "material/law_field.hpp"

#include <memory>

namespace pliant {

/// How the expansion is split off.
enum class ExpansionSplit {
  multiplicative,  ///< F_e = F / s
  additive         ///< H_e = H - (s - 1) I, for laws of small strain
};
inline ExpansionSplit split_of(const LawField& law) {
  return law.traits().constant_tangent ? ExpansionSplit::additive : ExpansionSplit::multiplicative;
}

/// The split at a pack of points; without expansion unless said otherwise. A function of H has the gradient
/// `volume * inverse * df/dH_e`.
struct ExpandedPoint {
  Pack inverse = 1.0;  ///< dH_e/dH: 1/s, or 1
  Pack shift = 0.0;    ///< H_e of H = 0: 1/s - 1, or 1 - s
  Pack volume = 1.0;   ///< dX_e/dX: s^3, or 1
  ExpansionSplit split = ExpansionSplit::multiplicative;

  ExpandedPoint() = default;
  ExpandedPoint(const Pack& change, ExpansionSplit how);  ///< change = s - 1; NaN where s <= 0

  /// H_e.
  PLIANT_INLINE Tensor3<Pack> strain(const Tensor3<Pack>& H) const { return add_to_diagonal(inverse * H, shift); }
  /// d/dt (volume psi_e(H_e)) at fixed H, from ds/dt, psi_e and P_e [W/m^3].
  Pack power(const Pack& rate, const Pack& psi, const Tensor3<Pack>& P, const Tensor3<Pack>& H_e) const;
};

/// The stretch s of a body.
class FreeExpansion {
 public:
  explicit FreeExpansion(GivenAmount stretch) : stretch_(std::move(stretch)) {}

  PerPoint<Pack> changes(const Instant& at) const { return stretch_.amounts(at); }  ///< s - 1
  PerPoint<ExpandedPoint> at(const Instant& at, ExpansionSplit split) const { return points(changes(at), split); }
  static PerPoint<ExpandedPoint> points(const PerPoint<Pack>& changes, ExpansionSplit split);
  const GivenAmount& stretch() const { return stretch_; }

 private:
  GivenAmount stretch_;
};

/// What changes the shape that a body has free of stress: F = s F_e F_a (energy/volume/active_strain.hpp).
struct FreeShape {
  std::shared_ptr<const Activation> shortening;    ///< active strain of the fibres; nullptr: none
  std::shared_ptr<const FreeExpansion> expansion;  ///< nullptr: none
};

template <int Order>
std::shared_ptr<const FreeExpansion> make_expansion(const Expression& stretch, const NodeLayout& layout,
                                                    const CellGroups<Order>& groups, int body);

/// The split at the points of a body; `expansion` may be nullptr.
PerPoint<ExpandedPoint> expanded_points(const FreeExpansion* expansion, const Instant& at, ExpansionSplit split);

/// A law in a body that has expanded. It refers to the law, which must outlive it.
class ExpandedLaw final : public LawField {
 public:
  ExpandedLaw(const LawField& law, PerPoint<ExpandedPoint> points) : law_(law), points_(std::move(points)) {}

  LawTraits traits() const override { return law_.traits(); }
  Pack psi(std::size_t n, const Tensor3<Pack>& H) const override;
  Pack psi_change(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& dH) const override;
  Tensor3<Pack> P(std::size_t n, const Tensor3<Pack>& H) const override;
  void tangent(std::size_t n, const Tensor3<Pack>& H, Tangent<Pack>& A) const override;

 private:
  const LawField& law_;
  PerPoint<ExpandedPoint> points_;
};

}  // namespace pliant
