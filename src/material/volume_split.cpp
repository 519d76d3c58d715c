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

std::string names_of_split_laws() {
  std::string names;
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    if (!split_volume(typical_law(row))) continue;
    names += (names.empty() ? "" : ", ") + std::string(elastic_laws()[row].name);
  }
  return names;
}

}  // namespace pliant
