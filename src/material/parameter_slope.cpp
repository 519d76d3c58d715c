#include "material/parameter_slope.hpp"

#include "material/law_kind.hpp"

namespace pliant {

bool has_parameter_slopes(const ElasticLawSpec& law) {
  return kind_of(law.row).dual_stress != nullptr;
}

Tensor3<Dual<double>> dual_stress(const ElasticLawSpec& law, std::span<const Dual<double>> parameters,
                                  const Tensor3<double>& H) {
  return kind_of(law.row).dual_stress({parameters, law.volumetric}, H);
}

LameOf<Dual<double>> dual_at_rest(const ElasticLawSpec& law, std::span<const Dual<double>> parameters) {
  return kind_of(law.row).dual_at_rest({parameters, law.volumetric});
}

}  // namespace pliant
