#include "study/fit_input.hpp"

#include "base/text.hpp"
#include "input/formats.hpp"
#include "input/parse.hpp"
#include "input/reference.hpp"
#include "input/sections/laws.hpp"
#include "material/constants.hpp"
#include "material/parameter_slope.hpp"
#include "material/viscosity_registry.hpp"
#include "study/fit_tests.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include <fmt/format.h>

namespace pliant {
namespace {

using Json = nlohmann::ordered_json;
using Need = KeyGroup::Need;

constexpr const char* fit_introduction = R"md(# The fit file

<!-- Written by `pliant schema --fit --markdown` from the table in src/study/fit_input.cpp; change it there. -->

The keys of the file that `pliant fit` reads. [From a test to a material](fitting.md) explains them by examples. Numbers have units as in
[an input](input.md).
)md";

/// The rows of the laws that can be fitted: isotropic ones.
std::vector<std::size_t> fitted_laws() {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    if (has_parameter_slopes(typical_law(row))) rows.push_back(row);
  }
  return rows;
}

template <class Takes>
std::vector<Anchor> fitted_laws_that(Takes takes_key) {
  std::vector<Anchor> anchors;
  for (const std::size_t row : fitted_laws()) {
    if (takes_key(row)) anchors.push_back({"model", std::string(elastic_laws()[row].name)});
  }
  return anchors;
}

/// A constant that may be held.
Field<FitMaterialConfig> held_field(const ParameterInfo& p) {
  const auto format = format_of(p);
  const std::string key(p.name);
  Field<FitMaterialConfig> result{info_of(key, format, fmt::format("held at this value, not fitted: {}", p.meaning))};
  result.read = [key, read = format.read](const InputNode& node, Diagnostics& diagnostics, FitMaterialConfig& into) {
    double value = 0.0;
    if (read(node, key, diagnostics, value)) into.held.push_back({key, value, node.where});
  };
  result.info.only_with = fitted_laws_that([&](std::size_t row) { return takes(row, p.name); });
  return std::move(result).otherwise_in_words("fitted");
}

std::vector<Field<FitMaterialConfig>> held_fields() {
  std::vector<Field<FitMaterialConfig>> fields;
  const auto is_known = [&](std::string_view name) {
    return std::ranges::any_of(fields, [&](const auto& f) { return f.info.key == name; });
  };
  for (const auto& p : elastic_constants()) fields.push_back(held_field(p));
  for (const std::size_t row : fitted_laws()) {
    for (const auto& p : elastic_laws()[row].parameters) {
      if (!is_known(p.name)) fields.push_back(held_field(p));
    }
  }
  return fields;
}

Section<FitMaterialConfig> material_keys() {
  using M = FitMaterialConfig;
  std::vector<std::string> names;
  for (const std::size_t row : fitted_laws()) names.emplace_back(elastic_laws()[row].name);
  std::vector<std::pair<std::string, VolumetricForm>> forms;
  for (std::size_t n = 0; n < volumetric_form_names.size(); ++n) {
    forms.emplace_back(volumetric_form_names[n], static_cast<VolumetricForm>(n));
  }
  Section<M> section;
  section.where = &M::where;
  section.fields = {
      field("model", &M::model, choice(names), "elastic law (`pliant materials`)").required(),
      field("terms", &M::terms, integer(Range::from_to(1, 4)), "number of terms of a law that has some to choose")
          .otherwise_in_words("1"),
      field("incompressible", &M::is_incompressible, truth(),
            "whether the volume cannot change; otherwise give a `poissons_ratio` or a `bulk_modulus`, or let it be "
            "fitted")
          .otherwise("false"),
      field("volumetric_energy", &M::volumetric, choice_of(forms), "energy of a change of volume, as in an input")
          .otherwise("mixed")};
  section.fields[1].info.only_with = {{"model", "ogden"}};
  section.groups.push_back({{"volumetric_energy"}, Need::any, fitted_laws_that([](std::size_t row) {
                              return typical_law(row).traits().takes_volumetric_form;
                            })});
  for (auto& f : held_fields()) section.fields.push_back(std::move(f));
  return section;
}

Section<FitViscosityConfig> viscosity_keys() {
  using V = FitViscosityConfig;
  return {{field("model", &V::model, choice({std::string(Prony::name)}), "law of viscosity").required(),
           field("terms", &V::terms, integer(Range::from_to(1, 20)),
                 "number of branches, each with a ratio and a relaxation time that are fitted"),
           field("relaxation_times", &V::relaxation_times, list_of(quantity("s", Range::above(0)), 1),
                 "relaxation times that are held: only the ratios are fitted")},
          {{{"terms", "relaxation_times"}, Need::exactly_one}},
          &V::where};
}

Format<TestKind> kind_format() {
  std::vector<std::pair<std::string, TestKind>> kinds;
  for (std::size_t n = 0; n < test_kinds().size(); ++n) {
    kinds.emplace_back(test_kinds()[n].name, static_cast<TestKind>(n));
  }
  return choice_of(kinds);
}

Section<FitTestConfig> test_keys() {
  using T = FitTestConfig;
  const Anchor relaxation{"kind", "relaxation"}, dma{"kind", "dma"};
  const auto of_relaxation = [&](Need need, std::vector<std::string> keys) {
    return KeyGroup{std::move(keys), need, {relaxation}};
  };
  return {{field("kind", &T::kind, kind_format(), "what was done to the specimen").required(),
           field("data", &T::data, path_of_file(), "table of the measurements (CSV), relative to this file").required(),
           field("weight", &T::weight, quantity("1", Range::above(0)), "factor of the test's squared residuals")
               .otherwise("1"),
           field("loading", &T::loading,
                 choice_of<Loading>({{"uniaxial", Loading::uniaxial},
                                     {"equibiaxial", Loading::equibiaxial},
                                     {"pure-shear", Loading::pure_shear},
                                     {"simple-shear", Loading::simple_shear}}),
                 "how the specimen of a test in time or frequency is loaded")
               .otherwise_in_words("uniaxial")
               .only_with({relaxation, dma}),
           field("stretch", &T::stretch, quantity("1", Range::above(0)), "stretch at which the specimen is held"),
           field("shear", &T::shear, quantity("1"), "amount of shear at which the specimen is held"),
           field("rate", &T::rate, quantity("1/s", Range::above(0)),
                 "rate of the stretch until it is held; times count from its beginning")
               .otherwise_in_words("none: at once")},
          {of_relaxation(Need::exactly_one, {"stretch", "shear"}), of_relaxation(Need::any, {"rate"})},
          &T::where};
}

/// A map from parameters to values whose format depends on the parameter.
Format<std::vector<NamedNode>> by_parameter(const std::string& value) {
  Format<std::vector<NamedNode>> format{
      "map of parameter to " + value, std::make_shared<Json>(Json{{"type", "object"}}), {}, {}};
  format.read = [](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                   std::vector<NamedNode>& into) {
    if (node.kind != InputNode::Kind::map) return refuse(node, name, "a map of parameters", diagnostics);
    for (const InputNode& child : node.children) into.push_back({child.key, child});
    return true;
  };
  return format;
}

Section<FitTargetConfig> target_keys() {
  using T = FitTargetConfig;
  Field<T> scale{info_of("scale", quantity("1"), "how large a residual counts as 1: the scatter of the measurements")};
  scale.info.type = "quantity in the unit of the column";
  scale.read = [](const InputNode& node, Diagnostics&, T& into) { into.scale = node; };
  return {{field("column", &T::column, text(), "a column of history.csv: `tip_z`, `clamp_fx`").required(),
           field("data", &T::data, path_of_file(),
                 "table of the measurements (CSV) with the columns `time` and that one, relative to this file")
               .required(),
           std::move(scale).otherwise_in_words("the largest measured value"),
           field("weight", &T::weight, quantity("1", Range::above(0)), "factor of the target's squared residuals")
               .otherwise("1")},
          {},
          &T::where};
}

/// The keys of a fit of a material, and those of a fit by runs.
std::vector<KeyGroup> fit_groups() {
  const Anchor material{"material"}, input{"input"};
  return {{{"material", "input"}, Need::exactly_one},
          {{"tests"}, Need::all, {material}},
          {{"viscosity", "residual", "bounds", "initial"}, Need::any, {material}},
          {{"parameters", "targets"}, Need::all, {input}}};
}

const Format<FitConfig>& fit_format() {
  using F = FitConfig;
  static const Format<FitConfig> format = map_of(Section<F>{
      {field("title", &F::title, text(), "free text for the report"),
       field("material", &F::material, map_of(material_keys()),
             "the elastic law; its constants are fitted unless they are given here")
           .or_none("none: numbers of an `input` are fitted"),
       field("viscosity", &F::viscosity, map_of(viscosity_keys()), "the viscous branches")
           .or_none("none; needed by tests in time or frequency"),
       field("tests", &F::tests, list_of(map_of(test_keys()), 1), "the measurements"),
       field("residual", &F::residual,
             choice_of<ResidualKind>({{"absolute", ResidualKind::absolute}, {"relative", ResidualKind::relative}}),
             "whether differences from the measurements or their ratios to them are made small")
           .otherwise("absolute"),
       field("bounds", &F::bounds, by_parameter("[lowest, highest]"), "bounds of fitted parameters")
           .or_none("those of the law"),
       field("initial", &F::initial, by_parameter("value"), "values from which the first start begins")
           .or_none("typical values of the law, scaled to the data"),
       field("starts", &F::starts, integer(Range::from_to(1, 10000)),
             "number of starts; the best minimum counts. They are the same every time")
           .otherwise_in_words("10, with `input` 1"),
       field("input", &F::input, path_of_file(), "the input of which numbers are fitted, relative to this file"),
       field("parameters", &F::parameters, by_parameter("[lowest, highest]"),
             "numbers of the input, named as for --set, with their bounds"),
       field("targets", &F::targets, list_of(map_of(target_keys()), 1), "what was measured of the motion")},
      fit_groups()});
  return format;
}

/// Two curves may be of one column; a parameter is one.
void check_parameters(const FitConfig& config, Diagnostics& diagnostics) {
  if (config.input && config.parameters.empty()) {
    diagnostics.add(config.input->where, "no parameters to fit; name numbers of the input in 'parameters'");
  }
}

/// What the keys of several sections say together.
void check_tests(const FitConfig& config, Diagnostics& diagnostics) {
  for (const FitTestConfig& test : config.tests) {
    const bool needs_branches = test.kind == TestKind::relaxation || test.kind == TestKind::dma;
    if (needs_branches && !config.viscosity) {
      diagnostics.add(test.where, "this test measures viscosity; add a section 'viscosity'");
    }
    if (test.kind == TestKind::volumetric && config.material.is_incompressible) {
      diagnostics.add(test.where, "a volumetric test does not go with 'incompressible: true'; leave one of them out");
    }
    const Loading loading = test.loading.value_or(Loading::uniaxial);
    if (test.kind == TestKind::dma && loading != Loading::uniaxial && loading != Loading::simple_shear) {
      diagnostics.add(test.where, "'loading' of a dma test must be uniaxial or simple-shear");
    }
    const bool is_sheared = test.kind == TestKind::relaxation && loading == Loading::simple_shear;
    if (is_sheared && test.stretch) {
      diagnostics.add(test.where, "a specimen in simple shear is held at a 'shear', not at a 'stretch'");
    }
    if (!is_sheared && test.shear) {
      diagnostics.add(test.where, "'shear' goes with 'loading: simple-shear'; give a 'stretch'");
    }
    if (is_sheared && test.rate) {
      diagnostics.add(test.where, "'rate' does not go with simple shear, which is applied at once");
    }
    const double held = test.stretch.value_or(1.0 + test.shear.value_or(1.0));
    if (test.kind == TestKind::relaxation && held == 1.0) {
      diagnostics.add(test.where, "a specimen held at rest shows no stress; give another 'stretch' or 'shear'");
    }
  }
}

}  // namespace

const std::vector<KeyInfo>& fit_keys() {
  return fit_format().children;
}

std::string fit_schema() {
  Json schema{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "Fit of Pliant"}};
  schema.update(*fit_format().schema);
  return schema.dump(2) + '\n';
}

std::string fit_reference() {
  return std::string(fit_introduction) + key_reference(fit_keys());
}

FitConfig read_fit(const std::string& text, const std::string& file) {
  Diagnostics diagnostics;
  const InputNode root = parse_yaml(text, file, diagnostics);
  if (root.kind == InputNode::Kind::null) throw InputError({file, 0, 0}, "the file is empty");
  if (root.find("mesh") != nullptr || root.find("bodies") != nullptr) {
    throw InputError({file, 1, 1},
                     "this is the input of a run, not a fit file; to fit numbers of it, name it in a fit "
                     "file (YAML) with the keys input, parameters and targets");
  }
  FitConfig config;
  fit_format().read(root, "", diagnostics, config);
  config.file = file;
  warn_of_decimal_commas(root, diagnostics);
  check_tests(config, diagnostics);
  check_parameters(config, diagnostics);
  diagnostics.throw_if_errors();
  return config;
}

}  // namespace pliant
