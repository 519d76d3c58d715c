#include "input/checks/volumetric.hpp"

#include "input/elasticity.hpp"
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
  if (!rule.is_uniform()) {
    diagnostics.add(
        e.where,
        "'volumetric: mixed' needs elastic constants that are the same everywhere; give each region a body of "
        "its own, or use 'volumetric: mean-dilatation'");
    return;
  }
  const auto split = split_volume(rule.law_at(0, {}));
  if (!split) {
    diagnostics.add(e.where,
                    fmt::format("'volumetric: mixed' needs an energy with a separate volumetric part, which model "
                                "'{}' does not have; use one of {}, or 'volumetric: mean-dilatation'",
                                e.model, names_of_split_laws()));
  } else if (!(split->kappa > 0.0)) {
    diagnostics.add(e.where,
                    fmt::format("'volumetric: mixed' needs a volumetric part that resists a change of volume; with "
                                "these constants, that of model '{}' is {:.3g} Pa; use 'volumetric: standard'",
                                e.model, split->kappa));
  }
}

/// Reports what acts on the displacement at every point in addition to the elastic law, which neither treatment allows.
void check_points(const BodyConfig& body, Diagnostics& diagnostics) {
  if (body.active && std::holds_alternative<ActiveConfig::Shortening>(body.active->contraction)) {
    diagnostics.add(body.active->where,
                    "'shortening' can only be used with 'volumetric: standard'; give the fibres a 'stress' instead");
  }
  for (const auto& mechanism : body.viscosity) {
    const auto* branch = std::get_if<MaxwellRatios>(&mechanism.law);
    const bool resists = std::holds_alternative<Prony>(mechanism.law) ||
                         std::holds_alternative<StiffnessProportional>(mechanism.law) ||
                         (branch != nullptr && branch->bulk_ratio > 0.0);
    if (!resists) continue;
    diagnostics.add(
        mechanism.where,
        fmt::format("viscosity '{}' resists a change of volume at every point, which 'volumetric' is meant to "
                    "avoid; use kelvin-voigt, or maxwell with a 'shear_ratio' only",
                    name_of(mechanism.law)));
  }
}

/// Reports what cannot be combined with pressures, which have neither history nor inertia.
void check_mixed(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const TimeConfig& time = config.time;
  const Method* method = method_of(time);
  if (std::holds_alternative<MethodConfig::PetscIntegrator>(time.method.kind)) {
    diagnostics.add(time.method.where,
                    "'volumetric: mixed' needs one of Pliant's own methods; PETSc's do not support pressures");
  } else if (method != nullptr && !method->stiffly_accurate) {
    diagnostics.add(time.method.where,
                    fmt::format("'volumetric: mixed' needs a stiffly accurate method, because pressures are known only "
                                "at stages, and a step of '{}' does not end with one; use bdf2, dirk22 or dirk33, or "
                                "'volumetric: mean-dilatation'",
                                method->name));
  }
  if (config.solver.linear == LinearSolver::amg || config.solver.linear == LinearSolver::p_multigrid) {
    diagnostics.add(given(root, {"solver", "linear"})->where,
                    "'volumetric: mixed' has an indefinite matrix, which multigrid cannot solve; use 'cholesky'");
  }
  const auto& start = config.initial.displacement;
  if (std::ranges::any_of(start, [](const Expression& e) { return !e.is_zero(); })) {
    diagnostics.add(given(root, {"initial", "displacement"})->where,
                    "'volumetric: mixed' must start from undeformed bodies, whose pressure is known; use 'volumetric: "
                    "mean-dilatation'");
  }
}

}  // namespace

void check_volumetric(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const VolumetricTreatment treatment = config.volumetric;
  for (const auto& body : config.bodies) {
    if (treatment != VolumetricTreatment::standard) check_points(body, diagnostics);
    if (!body.elasticity) continue;
    const ElasticityConfig& elasticity = *body.elasticity;
    const auto rule = rule_of(elasticity);
    if (!rule) continue;
    if (treatment == VolumetricTreatment::mixed) {
      check_mixed(elasticity, *rule, diagnostics);
    } else if (rule->is_uniform() && is_incompressible(rule->law_at(0, {}))) {
      diagnostics.add(elasticity.where, std::string(incompressible_without_pressures));
    } else if (treatment == VolumetricTreatment::mean_dilatation) {
      check_mean_dilatation(elasticity, *rule, diagnostics);
    }
  }
  if (treatment == VolumetricTreatment::mixed) check_mixed(config, root, diagnostics);
  if (treatment == VolumetricTreatment::standard || config.element == ElementOrder::p2) return;
  const InputNode* key = root.find("volumetric");
  diagnostics.add(key->where, fmt::format("'volumetric: {}' needs quadratic tetrahedra; add 'element: P2'", key->text));
}

bool is_incompressible(const ElasticLawSpec& law) {
  return std::ranges::any_of(law.parameters, [](double p) { return std::isinf(p); });
}

}  // namespace pliant
