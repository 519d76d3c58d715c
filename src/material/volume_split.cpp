#include "material/volume_split.hpp"

#include "material/mooney_rivlin_coupled.hpp"
#include "material/neo_hookean.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// The parameter to which the volumetric part is proportional, and its form; nullopt if there is none.
struct Part {
  std::string_view parameter;
  VolumetricForm form;
};
std::optional<Part> part_of(const ElasticLawSpec& law) {
  if (law.info().name == NeoHookean<double>::name) return Part{"lame_lambda", VolumetricForm::log};
  if (law.info().name == MooneyRivlinCoupled<double>::name) return Part{"lambda", VolumetricForm::log};
  if (law.traits().takes_volumetric_form) return Part{"bulk_modulus", law.volumetric};
  return std::nullopt;
}

}  // namespace

std::optional<VolumetricForm> volumetric_form_of(const ElasticLawSpec& law) {
  const auto part = part_of(law);
  return part ? std::optional(part->form) : std::nullopt;
}

std::optional<VolumeSplit> split_volume(const ElasticLawSpec& law) {
  const auto part = part_of(law);
  if (!part) return std::nullopt;
  const auto& parameters = law.info().parameters;
  const auto found = std::ranges::find(parameters, part->parameter, &ParameterInfo::name);
  if (found == parameters.end()) return std::nullopt;
  const auto place = static_cast<std::size_t>(found - parameters.begin());
  VolumeSplit split{law, law.parameters[place], part->form};
  split.rest.parameters[place] = 0.0;
  return split;
}

bool is_isochoric(const LawField& law) {
  const Tensor3<Pack> H{{0.1, 0.03, -0.02, 0.05, -0.04, 0.06, 0.01, -0.03, 0.08}};
  const Tensor3<Pack> larger = add_to_diagonal(1.2 * H, 0.2);  // F a fifth larger
  const Pack energy = law.psi(0, H);
  return all_of(std::experimental::abs(law.psi(0, larger) - energy) <= 1e-12 * std::experimental::abs(energy));
}

bool can_relax(const ElasticLawSpec& law) {
  const auto field = make_law_field(law);
  // A law whose fibres do not push, around an isochoric matrix, has no stiffness against an even compression.
  return is_isochoric(*field) || all_of(field->psi(0, add_to_diagonal(Tensor3<Pack>{}, -0.01)) > 0.0);
}

std::string names_of_split_laws() {
  std::string names;
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    if (!split_volume(typical_law(row))) continue;
    names += (names.empty() ? "" : ", ") + std::string(elastic_laws()[row].name);
  }
  return names;
}

}  // namespace pliant
