#include "energy/volume/expansion.hpp"

#include "base/limits.hpp"

namespace pliant {

ExpandedPoint::ExpandedPoint(const Pack& change, ExpansionSplit how) : split(how) {
  const Pack s = select(change > -1.0, Pack(1.0 + change), Pack(nan));
  if (how == ExpansionSplit::additive) {
    shift = 1.0 - s;
    return;
  }
  inverse = 1.0 / s;
  shift = -change / s;
  volume = s * s * s;
}

// d/ds (s^3 psi_e(F/s)) = s^2 (3 psi_e - P_e : F_e).
Pack ExpandedPoint::power(const Pack& rate, const Pack& psi, const Tensor3<Pack>& P, const Tensor3<Pack>& H_e) const {
  if (split == ExpansionSplit::additive) return -rate * trace(P);
  return volume * inverse * rate * (3.0 * psi - dot(P, add_to_diagonal(H_e, 1.0)));
}

PerPoint<ExpandedPoint> FreeExpansion::points(const PerPoint<Pack>& changes, ExpansionSplit split) {
  PerPoint<ExpandedPoint> result;
  result.values.reserve(changes.values.size());
  for (const Pack& change : changes.values) result.values.emplace_back(change, split);
  return result;
}

PerPoint<ExpandedPoint> expanded_points(const FreeExpansion* expansion, const Instant& at, ExpansionSplit split) {
  if (expansion == nullptr) return {{ExpandedPoint{}}};
  return expansion->at(at, split);
}

template <int Order>
std::shared_ptr<const FreeExpansion> make_expansion(const Expression& stretch, const NodeLayout& layout,
                                                    const CellGroups<Order>& groups, int body) {
  return std::make_shared<const FreeExpansion>(
      GivenAmount(stretch, places_of_points<Order>(layout, groups, body), 1.0));
}

template std::shared_ptr<const FreeExpansion> make_expansion<1>(const Expression&, const NodeLayout&,
                                                                const CellGroups<1>&, int);
template std::shared_ptr<const FreeExpansion> make_expansion<2>(const Expression&, const NodeLayout&,
                                                                const CellGroups<2>&, int);

Pack ExpandedLaw::psi(std::size_t n, const Tensor3<Pack>& H) const {
  const ExpandedPoint& at = points_[n];
  return at.volume * law_.psi(n, at.strain(H));
}

Pack ExpandedLaw::psi_change(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& dH) const {
  const ExpandedPoint& at = points_[n];
  return at.volume * law_.psi_change(n, at.strain(H), at.inverse * dH);
}

Tensor3<Pack> ExpandedLaw::P(std::size_t n, const Tensor3<Pack>& H) const {
  const ExpandedPoint& at = points_[n];
  return Pack(at.volume * at.inverse) * law_.P(n, at.strain(H));
}

void ExpandedLaw::tangent(std::size_t n, const Tensor3<Pack>& H, Tangent<Pack>& A) const {
  const ExpandedPoint& at = points_[n];
  law_.tangent(n, at.strain(H), A);
  const Pack scale = at.volume * at.inverse * at.inverse;
  for (Pack& entry : A) entry *= scale;
}

}  // namespace pliant
