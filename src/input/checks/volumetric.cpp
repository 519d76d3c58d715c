#include "input/checks/volumetric.hpp"

#include "input/elasticity.hpp"
#include "material/registry.hpp"
#include "material/volume_split.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// A body's law; nothing if it is not determined, which is already an error.
std::optional<ElasticityRule> rule_of(const ElasticityConfig& e) {
  try {
    if (e.model.empty()) return std::nullopt;
    ElasticityRule rule(e);
    if (rule.is_uniform()) static_cast<void>(rule.law_at(0, {}));
    return rule;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

void check_mean_dilatation(const ElasticityConfig& e, const ElasticityRule& rule, Diagnostics& diagnostics) {
  if (!rule.kind().traits().constant_tangent) return;
  diagnostics.add(e.where,
                  fmt::format("model '{}' is for small strains, and 'volumetric: mean-dilatation' for large ones; "
                              "use saint-venant-kirchhoff, which is equivalent at small strain",
                              e.model));
}

void check_mixed(const ElasticityConfig& e, const ElasticityRule& rule, Diagnostics& diagnostics) {
  if (!volumetric_form_of(rule.kind())) {
    diagnostics.add(
        e.where, fmt::format("'volumetric: mixed' needs an energy with a separate volumetric part, which model "
                             "'{}' does not have; use one of {}, or 'element: P2' with 'volumetric: mean-dilatation'",
                             e.model, names_of_split_laws()));
  } else if (rule.is_uniform()) {
    const double kappa = split_volume(rule.law_at(0, {}))->kappa;
    if (!(kappa > 0.0)) diagnostics.add(e.where, lacks_volumetric_stiffness(e.model, kappa));
  }
}

/// Reports viscosities that would resist a change of volume at every point, which 'volumetric' is meant to avoid.
void check_viscosity(const BodyConfig& body, const std::optional<ElasticityRule>& rule, Diagnostics& diagnostics) {
  const bool splits = rule && volumetric_form_of(rule->kind());
  for (const auto& mechanism : body.viscosity) {
    const auto* branch = std::get_if<MaxwellRatios>(&mechanism.law);
    if (branch != nullptr && branch->bulk_ratio > 0.0) {
      diagnostics.add(mechanism.where,
                      "a maxwell branch with a 'bulk_ratio' resists a change of volume at every point, which "
                      "'volumetric' is meant to avoid; give a 'shear_ratio' only");
    }
    if (!rule || !std::holds_alternative<Prony>(mechanism.law)) continue;
    if (!splits) {
      diagnostics.add(
          mechanism.where,
          fmt::format("a prony branch relaxes the law without its volumetric part here, and model '{}' does "
                      "not have one; use one of {}, or maxwell with a 'shear_ratio'",
                      body.elasticity->model, names_of_split_laws()));
    } else if (!can_relax(split_volume(typical_law(rule->kind().row))->rest)) {
      diagnostics.add(mechanism.where,
                      fmt::format("a prony branch cannot follow model '{}' without its volumetric part, which does not "
                                  "resist every deformation; use 'volumetric: standard'",
                                  body.elasticity->model));
    }
  }
}

/// Reports what softening cannot be combined with.
void check_mullins(const Config& config, const BodyConfig& body, const ElasticityRule& rule, Diagnostics& diagnostics) {
  const Location& where = body.mullins->where;
  const std::string& model = body.elasticity->model;
  if (body.mullins->law.m + body.mullins->law.beta == 0.0) {
    diagnostics.add(where, "'mullins' needs an 'm' or a 'beta' above 0: the stress would jump at every reversal");
  }
  if (body.active && std::holds_alternative<ActiveConfig::Shortening>(body.active->contraction)) {
    diagnostics.add(where,
                    "'mullins' cannot follow a body whose fibres shorten, because the law sees only a part of its "
                    "deformation; let them pull, with a 'stress' in place of the 'shortening'");
  }
  if (body.expansion) {
    diagnostics.add(where,
                    "'mullins' cannot follow a body that expands, because the law sees only a part of its deformation; "
                    "leave 'expansion' or 'mullins' out");
  }
  if (!volumetric_form_of(rule.kind())) {
    diagnostics.add(where,
                    fmt::format("'mullins' softens the resistance to a change of shape alone, and model '{}' has no "
                                "separate volumetric part; use one of {}",
                                model, names_of_split_laws()));
  } else if (config.volumetric == VolumetricTreatment::mean_dilatation &&
             !is_isochoric(*make_law_field(split_volume(typical_law(rule.kind().row))->rest))) {
    diagnostics.add(where,
                    fmt::format("without its volumetric part, model '{}' still feels a change of volume, which "
                                "'volumetric: mean-dilatation' averages and 'mullins' cannot follow; use 'volumetric: "
                                "mixed' or another model, such as neo-hookean-isochoric",
                                model));
  }
}

/// Reports what cannot be combined with pressures, which have neither history nor inertia.
void check_mixed(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const TimeConfig& time = config.time;
  if (std::holds_alternative<MethodConfig::PetscIntegrator>(time.method.kind)) {
    diagnostics.add(time.method.where,
                    "'volumetric: mixed' needs one of Pliant's own methods; PETSc's do not support pressures");
  } else if (const auto error = method_error_of_incompressible_bodies(config);
             error && has_incompressible_body(config)) {
    diagnostics.add(time.method.where, *error);
  }
  if (config.solver.linear == LinearSolver::p_multigrid) {
    diagnostics.add(given(root, {"solver", "linear"})->where,
                    "'volumetric: mixed' has an indefinite matrix, which p-multigrid cannot solve; use 'amg' or "
                    "'cholesky'");
  }
  const auto& start = config.initial.displacement;
  if (has_incompressible_body(config) && std::ranges::any_of(start, [](const Expression& e) { return !e.is_zero(); })) {
    diagnostics.add(given(root, {"initial", "displacement"})->where,
                    "an incompressible body must start undeformed, because its deformation does not determine its "
                    "pressure; use a poissons_ratio below 1/2");
  }
}

}  // namespace

void check_volumetric(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const VolumetricTreatment treatment = config.volumetric;
  for (const auto& body : config.bodies) {
    if (!body.elasticity) continue;
    const ElasticityConfig& elasticity = *body.elasticity;
    const auto rule = rule_of(elasticity);
    if (treatment != VolumetricTreatment::standard) check_viscosity(body, rule, diagnostics);
    if (!rule) continue;
    if (body.mullins) check_mullins(config, body, *rule, diagnostics);
    if (treatment == VolumetricTreatment::mixed) {
      check_mixed(elasticity, *rule, diagnostics);
    } else if (rule->is_uniform() && is_incompressible(rule->law_at(0, {}))) {
      diagnostics.add(elasticity.where, std::string(incompressible_without_pressures));
    } else if (treatment == VolumetricTreatment::mean_dilatation) {
      check_mean_dilatation(elasticity, *rule, diagnostics);
    }
  }
  if (treatment == VolumetricTreatment::mixed) check_mixed(config, root, diagnostics);
  if (treatment != VolumetricTreatment::mean_dilatation || config.element == ElementOrder::p2) return;
  const InputNode* key = root.find("volumetric");
  diagnostics.add(
      key->where,
      fmt::format("'volumetric: {}' needs quadratic tetrahedra; add 'element: P2', or use 'volumetric: mixed'",
                  key->text));
}

bool is_incompressible(const ElasticLawSpec& law) {
  return std::ranges::any_of(law.parameters, [](double p) { return std::isinf(p); });
}

bool has_incompressible_body(const Config& config) {
  return std::ranges::any_of(config.bodies, [](const BodyConfig& body) {
    if (!body.elasticity) return false;
    const auto rule = rule_of(*body.elasticity);
    return rule && rule->is_uniform() && is_incompressible(rule->law_at(0, {}));
  });
}

std::optional<std::string> method_error_of_incompressible_bodies(const Config& config) {
  const Method* method = method_of(config.time);
  if (method == nullptr || method->stiffly_accurate) return std::nullopt;
  return fmt::format(
      "an incompressible body needs a stiffly accurate method, because its pressures are known only at "
      "stages, and a step of '{}' does not end with one; use bdf2, or a poissons_ratio below 1/2",
      method->name);
}

std::string lacks_volumetric_stiffness(std::string_view model, double kappa) {
  return fmt::format(
      "'volumetric: mixed' needs a volumetric part that resists a change of volume; with these "
      "constants, that of model '{}' is {:.3g} Pa; use 'volumetric: standard'",
      model, kappa);
}

}  // namespace pliant
