#include "app/input_viscosity.hpp"

#include "app/input_laws.hpp"
#include "material/viscosity_registry.hpp"

namespace pliant {
namespace {

Format<std::optional<StrainRate>> strain_rate() {
  std::vector<std::pair<std::string, std::optional<StrainRate>>> forms{{"auto", std::nullopt}};
  for (const StrainRateInfo& form : strain_rates()) forms.emplace_back(form.name, form.rate);
  return choice_of(forms);
}

}  // namespace

Section<ViscosityConfig> viscosity_keys() {
  using Need = KeyGroup::Need;
  using V = ViscosityConfig;
  const auto laws = viscosity_laws();
  const Anchor kelvin_voigt{"model", std::string(KelvinVoigt::name)};
  const Anchor maxwell{"model", std::string(Maxwell::name)};
  const auto is_not = [](const Anchor& model) { return [model](const V& v) { return v.model != model.value; }; };
  return {
      {
          field("model", &V::model, choice(law_names(laws)), "law of viscosity (`pliant materials`)").required(),
          law_field(laws, &V::shear, "shear").left_out_if(is_not(kelvin_voigt)),
          law_field(laws, &V::bulk, "bulk").otherwise("0").left_out_if(is_not(kelvin_voigt)),
          field("rate", &V::rate, strain_rate(),
                "strain rate within a step; `auto`: the form that has a potential where it keeps the method's order, "
                "else the exact one")
              .otherwise("auto")
              .left_out_if(is_not(kelvin_voigt)),
          law_field(laws, &V::shear_modulus, "shear_modulus").left_out_if(is_not(maxwell)),
          law_field(laws, &V::bulk_modulus, "bulk_modulus").otherwise("0").left_out_if(is_not(maxwell)),
          law_field(laws, &V::relaxation_time, "relaxation_time").left_out_if(is_not(maxwell)),
      },
      {{{"shear"}, Need::all, {kelvin_voigt}},
       {{"bulk", "rate"}, Need::any, {kelvin_voigt}},
       {{"shear_modulus", "relaxation_time"}, Need::all, {maxwell}},
       {{"bulk_modulus"}, Need::any, {maxwell}}},
      &V::where};
}

}  // namespace pliant
