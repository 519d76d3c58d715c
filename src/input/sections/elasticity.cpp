#include "input/sections/elasticity.hpp"

#include "base/units.hpp"
#include "input/elasticity.hpp"
#include "input/formats.hpp"
#include "input/sections/cell_data.hpp"
#include "input/sections/laws.hpp"
#include "material/constants.hpp"
#include "material/library.hpp"
#include "material/volume_split.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

bool is_constant(const Expression& e) {
  return !e.depends_on_space() && !e.depends_on_time();
}

/// Names of the elastic constants in the literature.
std::vector<std::string> other_names(std::string_view constant) {
  if (constant == "youngs_modulus") return {"E", "Young", "young", "Youngs_modulus", "elastic_modulus"};
  if (constant == "poissons_ratio") return {"nu", "Poisson", "poisson"};
  if (constant == "shear_modulus") return {"mu", "G", "shear", "lame_mu"};
  if (constant == "bulk_modulus") return {"K", "kappa", "bulk"};
  if (constant == "lame_lambda") return {"lambda", "lame", "lmbda"};
  return {};
}

/// The laws that take a key.
template <class Takes>
std::vector<Anchor> laws_that(Takes takes_key) {
  std::vector<Anchor> laws;
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    if (takes_key(row)) laws.push_back({"model", std::string(elastic_laws()[row].name)});
  }
  return laws;
}

/// A constant that any law may have: its bounds are checked where it is one number.
Field<ElasticityConfig> constant_field(const ParameterInfo& p, const std::string& description) {
  using E = ElasticityConfig;
  const auto format = or_cell_data(expression(std::string(p.unit), Variables::space));
  Field<E> result{{std::string(p.name), format.type, description}};
  result.info.schema = format.schema;
  result.info.also = other_names(p.name);
  result.info.only_with = laws_that([&](std::size_t row) { return takes(row, p.name); });
  result.read = [p, read = format.read, bounded = format_of(p).read](const InputNode& node, Diagnostics& diagnostics,
                                                                     E& into) {
    ValueOrCellData<Expression> given;
    if (!read(node, std::string(p.name), diagnostics, given)) return;
    GivenConstant constant{std::string(p.name), std::move(given.value), std::move(given.cell_data), node.where};
    double number = 0.0;
    const bool good = constant.cell_data.empty() && is_constant(constant.value) && looks_like_quantity(node.text)
                          ? bounded(node, constant.key, diagnostics, number)
                          : true;
    if (good) into.constants.push_back(std::move(constant));
  };
  result.write = [p, write = format.write](const E& from) {
    const auto found = std::ranges::find(from.constants, p.name, &GivenConstant::key);
    return found == from.constants.end() ? InputNode{} : write({found->value, found->cell_data});
  };
  return result;
}

std::string joined_names(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// The elastic constants, then the parameters of the laws by name; a name that several laws share is listed once.
std::vector<Field<ElasticityConfig>> constant_fields() {
  std::vector<Field<ElasticityConfig>> fields;
  for (const auto& p : elastic_constants()) fields.push_back(constant_field(p, std::string(p.meaning)));
  const auto is_known = [&](std::string_view name) {
    return std::ranges::any_of(fields, [&](const auto& f) { return f.info.key == name; });
  };
  for (const auto& law : elastic_laws()) {
    for (const auto& p : law.parameters) {
      if (is_known(p.name)) continue;
      std::vector<std::string> owners;
      for (const auto& other : elastic_laws()) {
        if (std::ranges::find(other.parameters, p.name, &ParameterInfo::name) != other.parameters.end()) {
          owners.emplace_back(other.name);
        }
      }
      fields.push_back(constant_field(p, fmt::format("{}: {}{}", joined_names(owners), p.meaning, fallback_words(p))));
    }
  }
  return fields;
}

std::vector<std::string> library_names() {
  std::vector<std::string> names;
  for (const LibraryMaterial& material : material_library()) names.emplace_back(material.name);
  return names;
}

Section<ElasticityConfig> elasticity_keys() {
  using E = ElasticityConfig;
  Section<E> section;
  section.where = &E::where;
  section.fields.push_back(
      field("model", &E::model,
            choice(law_names(elastic_laws()), " (linear elasticity: 'linear' at small strain, else 'neo-hookean')"),
            "elastic law (`pliant materials`)")
          .otherwise_in_words("that of the `library`")
          .left_out_if([](const E& e) { return !e.library.empty(); }));
  section.fields.push_back(
      field("library", &E::library, choice(library_names()),
            "measured material that gives the law, its constants and, where it was measured, the density "
            "(`pliant materials --library`); keys next to it take precedence")
          .otherwise_in_words("none")
          .left_out_if([](const E& e) { return e.library.empty(); }));
  // As everybody calls the first Lame parameter, which is another key: said where the law has no lambda.
  section.groups.push_back(
      {{"lambda"}, KeyGroup::Need::any, laws_that([](std::size_t row) { return takes(row, "lambda"); })});
  section.groups.push_back({{"model", "library"}, KeyGroup::Need::exactly_one});
  for (auto& f : constant_fields()) section.fields.push_back(std::move(f));
  section.fields.push_back(
      direction_field("fibre", &E::directions, "direction of the fibres, for laws that have some"));
  section.fields.push_back(direction_field("sheet", &E::directions,
                                           "holzapfel-ogden: direction of the sheets, made orthogonal to the fibres"));
  section.fields.push_back(
      direction_field("fibre2", &E::directions, "holzapfel-gasser-ogden: direction of the second family of fibres"));
  for (auto& f : section.fields) {
    const auto has_direction = [&](std::size_t row) {
      return std::ranges::find(elastic_laws()[row].directions, f.info.key) != elastic_laws()[row].directions.end();
    };
    if (auto laws = laws_that(has_direction); !laws.empty()) f.info.only_with = std::move(laws);
  }
  std::vector<std::pair<std::string, VolumetricForm>> forms;
  std::vector<Anchor> laws_with_form;
  for (std::size_t n = 0; n < volumetric_form_names.size(); ++n) {
    forms.emplace_back(volumetric_form_names[n], static_cast<VolumetricForm>(n));
  }
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    if (typical_law(row).traits().takes_volumetric_form) {
      laws_with_form.push_back({"model", std::string(elastic_laws()[row].name)});
    }
  }
  std::vector<Anchor> laws_with_split =
      laws_that([](std::size_t row) { return split_volume(typical_law(row)).has_value(); });
  section.fields.push_back(field("incompressible", &E::incompressible, truth(),
                                 "whether the volume cannot change at all, in place of the constant that resists it: a "
                                 "Poisson's ratio of 1/2; needs `volumetric: mixed`")
                               .otherwise("false")
                               .left_out_if([laws_with_split](const E& e) {
                                 return std::ranges::find(laws_with_split, e.model, &Anchor::value) ==
                                        laws_with_split.end();
                               }));
  section.fields.back().info.only_with = laws_with_split;
  section.groups.push_back({{"incompressible"}, KeyGroup::Need::any, laws_with_split});
  for (auto* laws : {&laws_with_split, &laws_with_form}) laws->push_back({"library"});  // their laws have both
  const auto has_no_form = [laws_with_form](const E& e) {
    return std::ranges::find(laws_with_form, e.model, &Anchor::value) == laws_with_form.end();
  };
  section.fields.push_back(field("volumetric_energy", &E::volumetric_energy, choice_of(forms),
                                 "energy U of a change of volume: (ln J)^2/2, (J - 1)^2/2 or (J^2 - 1 - 2 ln J)/4")
                               .otherwise("mixed")
                               .left_out_if(has_no_form));
  section.fields.back().info.only_with = laws_with_form;
  section.groups.push_back({{"volumetric_energy"}, KeyGroup::Need::any, laws_with_form});
  return section;
}

/// The law and the constants of the material that `library` names, where the input does not give them.
void complete_from_library(ElasticityConfig& e) {
  const LibraryMaterial* material = find_material(e.library);
  if (material == nullptr) return;
  e.model = material->law;
  const auto gives = [&](std::string_view key) {
    return std::ranges::find(e.constants, key, &GivenConstant::key) != e.constants.end();
  };
  for (const auto& [key, value] : material->constants) {
    if (!gives(key)) e.constants.push_back({std::string(key), Expression(value), {}, e.where});
  }
  if (e.incompressible || gives("poissons_ratio") || gives("bulk_modulus")) return;
  e.constants.push_back({"poissons_ratio", Expression(library_poissons_ratio), {}, e.where});
}

/// Whether the constants determine the law; where they are numbers, whether it is admissible.
void check_law(const ElasticityConfig& e, Diagnostics& diagnostics) {
  try {
    const ElasticityRule rule(e);
    if (rule.is_uniform()) static_cast<void>(rule.law_at(0, {}));
  } catch (const InputError& error) {
    for (const auto& d : error.diagnostics()) diagnostics.add(d.where, d.message);
  }
}

}  // namespace

Format<ElasticityConfig> elasticity_format() {
  Format<ElasticityConfig> format = map_of(elasticity_keys());
  format.read = [read = format.read](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                     ElasticityConfig& into) {
    const std::size_t before = diagnostics.num_errors();
    const bool good = read(node, name, diagnostics, into);
    if (!good || diagnostics.num_errors() != before) return good;
    complete_from_library(into);
    check_law(into, diagnostics);
    return good;
  };
  return format;
}

}  // namespace pliant
