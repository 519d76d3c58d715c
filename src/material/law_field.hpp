/// An elastic law of a body, evaluated on packs of its quadrature points. Its kind is known only at run time, and its
/// parameters may differ from point to point. Each pack costs one virtual call, a few per cent of the cheapest law's
/// time; in return the loops over cells are compiled once instead of once per law.
#pragma once

#include "material/elastic_law.hpp"
#include "material/law.hpp"

#include <functional>
#include <memory>

namespace pliant {

/// All functions are those of material/law.hpp, at the n-th pack of points; a uniform body ignores n.
class LawField {
 public:
  virtual ~LawField() = default;

  virtual LawTraits traits() const = 0;

  virtual Pack psi(std::size_t n, const Tensor3<Pack>& H) const = 0;
  /// psi(H + dH) - psi(H), accurate relative to the change (material/energy_change.hpp).
  virtual Pack psi_change(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& dH) const = 0;
  virtual Tensor3<Pack> P(std::size_t n, const Tensor3<Pack>& H) const = 0;
  /// A = dP/dH.
  virtual void tangent(std::size_t n, const Tensor3<Pack>& H, Tangent<Pack>& A) const = 0;
};

std::unique_ptr<LawField> make_law_field(const ElasticLawSpec& uniform);

/// `at(n, lane)` is the law at the lane's point in the n-th pack, n < num_packs; all are of the kind of `common`.
std::unique_ptr<LawField> make_law_field(const ElasticLawSpec& common, std::size_t num_packs,
                                         const std::function<ElasticLawSpec(std::size_t n, int lane)>& at);

}  // namespace pliant
