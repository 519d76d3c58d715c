#include "model/elastic_parts.hpp"

#include "energy/volume/mean_dilatation.hpp"
#include "energy/volume/mullins.hpp"

#include <cmath>
#include <utility>

namespace pliant {
namespace {

using LawAt = std::function<ElasticLawSpec(PetscInt, const std::array<double, 3>&)>;

template <int Order>
MixedLaw make_split_law(const ElasticBody<Order>& on, VolumetricForm form, const LawAt& law_at, ElasticParts& parts) {
  const auto split_at = [&](PetscInt cell, const std::array<double, 3>& X) {
    VolumeSplit split = *split_volume(law_at(cell, X));
    if (on.pressures != nullptr) {
      require_volumetric_stiffness(split, *on.config.bodies[static_cast<std::size_t>(on.body)].elasticity);
      (std::isinf(split.kappa) ? parts.volume.some_incompressible : parts.volume.some_compressible) = true;
    }
    return split;
  };
  if (on.rule.is_uniform()) return make_mixed_law(split_at(0, {}));
  return make_varying_mixed_law<Order>(on.rule.kind(), form, on.layout, on.groups, on.body, split_at);
}

template <int Order>
std::shared_ptr<const LawField> make_whole_law(const ElasticBody<Order>& on, const LawAt& law_at) {
  if (on.rule.is_uniform()) return make_law_field(law_at(0, {}));
  return make_varying_law<Order>(on.rule.kind(), on.layout, on.groups, on.body, law_at);
}

}  // namespace

template <int Order>
ElasticParts make_elastic_parts(const ElasticBody<Order>& on, const LawAt& law_at, FreeShape shape) {
  const VolumetricTreatment treatment = on.config.volumetric;
  const PetscInt num_owned = on.layout.num_owned_nodes;
  const auto form = volumetric_form_of(on.rule.kind());
  MixedLaw split;
  ElasticParts parts;
  const auto& mullins = on.config.bodies[static_cast<std::size_t>(on.body)].mullins;
  if ((treatment != VolumetricTreatment::standard || mullins) && form) {
    split = make_split_law(on, *form, law_at, parts);
  }
  if (mullins) parts.softening = make_mullins_term<Order>(mullins->law, split.rest, on.groups, on.body, num_owned);
  if (treatment != VolumetricTreatment::standard) parts.shape = split.rest;
  if (on.pressures != nullptr) {
    auto term =
        make_mixed_term<Order>(std::move(split), on.groups, on.body, num_owned, *on.pressures, std::move(shape));
    parts.mixed = term.get();
    parts.term = std::move(term);
    return parts;
  }
  auto whole = make_whole_law(on, law_at);
  if (!parts.shape) parts.shape = whole;
  if constexpr (Order == 2) {
    if (treatment == VolumetricTreatment::mean_dilatation) {
      parts.term = make_mean_dilatation_term(std::move(whole), on.groups, on.body, num_owned, std::move(shape));
      return parts;
    }
  }
  parts.term = make_elastic_term<Order>(std::move(whole), on.groups, on.body, num_owned, std::move(shape));
  return parts;
}

template ElasticParts make_elastic_parts<1>(const ElasticBody<1>&, const LawAt&, FreeShape);
template ElasticParts make_elastic_parts<2>(const ElasticBody<2>&, const LawAt&, FreeShape);

}  // namespace pliant
