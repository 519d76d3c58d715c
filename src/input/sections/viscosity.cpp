#include "input/sections/viscosity.hpp"

#include "input/sections/laws.hpp"
#include "material/viscosity_registry.hpp"

namespace pliant {
namespace {

Format<std::optional<StrainRate>> strain_rate() {
  std::vector<std::pair<std::string, std::optional<StrainRate>>> forms{{"auto", std::nullopt}};
  for (const StrainRateInfo& form : strain_rates()) forms.emplace_back(form.name, form.rate);
  return choice_of(forms);
}

Section<ViscosityConfig> mechanism_keys() {
  using Need = KeyGroup::Need;
  using V = ViscosityConfig;
  const auto laws = viscosity_laws();
  const auto model = [](std::string_view name) { return Anchor{"model", std::string(name)}; };
  const Anchor kelvin_voigt = model(KelvinVoigt::name), maxwell = model(Maxwell::name), prony = model(Prony::name),
               stiffness = model(StiffnessProportional::name), mass = model(MassProportional::name);
  const auto is_not = [](const Anchor& of) { return [of](const V& v) { return v.model != of.value; }; };
  const auto has_no_rate = [=](const V& v) { return v.model != kelvin_voigt.value && v.model != stiffness.value; };
  const auto has_no_branch = [=](const V& v) { return v.model != maxwell.value && v.model != prony.value; };
  const auto has_no_moduli = [=](const V& v) { return v.model != maxwell.value || v.shear_ratio; };
  return {
      {
          field("model", &V::model, choice(law_names(laws)), "law of viscosity (`pliant materials`)").required(),
          law_field(laws, &V::shear, "shear").left_out_if(is_not(kelvin_voigt)),
          law_field(laws, &V::bulk, "bulk").otherwise("0").left_out_if(is_not(kelvin_voigt)),
          law_field(laws, &V::time, "time").left_out_if(is_not(stiffness)),
          field("rate", &V::rate, strain_rate(),
                "strain rate within a step; `auto`: the form that has a potential where it keeps the method's order, "
                "else the exact one")
              .otherwise("auto")
              .left_out_if(has_no_rate),
          law_field(laws, &V::decay_rate, "decay_rate").left_out_if(is_not(mass)),
          law_field(laws, &V::shear_modulus, "shear_modulus").left_out_if(has_no_moduli),
          law_field(laws, &V::bulk_modulus, "bulk_modulus").otherwise("0").left_out_if(has_no_moduli),
          field("shear_ratio", &V::shear_ratio, quantity("1", Range::at_least(0)),
                "`shear_modulus` as a part of the elastic law's shear modulus at rest"),
          field("bulk_ratio", &V::bulk_ratio, quantity("1", Range::at_least(0)),
                "`bulk_modulus` as a part of the elastic law's bulk modulus at rest")
              .otherwise("0")
              .left_out_if([](const V& v) { return !v.shear_ratio; }),
          law_field(laws, &V::ratio, "ratio").left_out_if(is_not(prony)),
          law_field(laws, &V::relaxation_time, "relaxation_time").left_out_if(has_no_branch),
      },
      {{{"shear"}, Need::all, {kelvin_voigt}},
       {{"bulk"}, Need::any, {kelvin_voigt}},
       {{"time"}, Need::all, {stiffness}},
       {{"rate"}, Need::any, {kelvin_voigt, stiffness}},
       {{"decay_rate"}, Need::all, {mass}},
       {{"relaxation_time"}, Need::all, {maxwell, prony}},
       {{"ratio"}, Need::all, {prony}},
       {{"shear_modulus", "shear_ratio"}, Need::exactly_one, {maxwell}},
       {{"bulk_modulus"}, Need::any, {{"shear_modulus"}}},
       {{"bulk_ratio"}, Need::any, {{"shear_ratio"}}}},
      &V::where};
}

}  // namespace

Format<std::vector<ViscosityConfig>> viscosity_format() {
  return one_or_list_of(map_of(mechanism_keys()));
}

}  // namespace pliant
