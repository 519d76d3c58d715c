/// Active strain of muscle: the fibres shorten by g(x, t), and the law sees the remaining deformation,
///     F = F_e F_a,  F_a = (1 - g) f (x) f + (1 - g)^(-1/2) (I - f (x) f),  det F_a = 1
///     psi(F) = psi_e(F B),  P = P_e B,  A_iJkL = A_e iMkN B_MJ B_NL,  B = F_a^-1
/// With B - I = c2 I + (c1 - c2) f (x) f, c1 = g / (1 - g), c2 = -g / (1 + (1 - g)^(1/2)), no digits are lost where g
/// and the strain are small. Source: Ambrosi & Pezzuto, J. Elasticity 107 (2012) 199-212, section 3.
#pragma once

#include "energy/volume/activation.hpp"
#include "material/law_field.hpp"

namespace pliant {

/// A law with shortened fibres. It refers to the law and the shortening, which must outlive it.
class ActiveStrain final : public LawField {
 public:
  ActiveStrain(const LawField& law, const Activation& shortening, const Instant& at)
      : law_(law), shortening_(shortening), g_(shortening.amounts(at)) {}

  LawTraits traits() const override { return law_.traits(); }
  Pack psi(std::size_t n, const Tensor3<Pack>& H) const override;
  Pack psi_change(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& dH) const override;
  Tensor3<Pack> P(std::size_t n, const Tensor3<Pack>& H) const override;
  void tangent(std::size_t n, const Tensor3<Pack>& H, Tangent<Pack>& A) const override;

  /// d psi / d g at fixed F [J/m^3].
  Pack slope(std::size_t n, const Tensor3<Pack>& H) const;

 private:
  /// B - I.
  Tensor3<Pack> change(std::size_t n) const;

  const LawField& law_;
  const Activation& shortening_;
  PerPoint<Pack> g_;
};

}  // namespace pliant
